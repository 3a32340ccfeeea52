"""Builds planners' observations from simulated scenes."""
