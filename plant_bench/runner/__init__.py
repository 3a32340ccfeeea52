"""Runs episodes and suites on worker processes, collects data, and manages the run folders."""
