"""Collecting data with the expert."""
