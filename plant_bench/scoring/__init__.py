"""Scoring: infractions and their penalties, episode termination, metrics of episodes and runs."""
