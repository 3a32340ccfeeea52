"""Resimulates recorded episodes, to explain infractions and to verify submitted runs."""
