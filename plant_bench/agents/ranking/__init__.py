"""Rankers of actors by relevance, and the expert that sees only the top-ranked ones (RFDS)."""
