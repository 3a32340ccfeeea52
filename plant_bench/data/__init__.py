"""Recordings: every tick of an episode on disk, to score again, replay and learn from."""
