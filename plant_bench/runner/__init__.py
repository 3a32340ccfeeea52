"""Runs episodes: one, a suite of them on worker processes, and the folder of their records."""
