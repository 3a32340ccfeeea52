"""Collects training data: the expert's actions, in episodes that it or another planner drives."""
