"""Recordings of episodes on disk, for rescoring, replays and training."""
