"""Replays: recordings as pages that play in a browser, and as pictures and films."""
