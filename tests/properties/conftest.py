"""Hypothesis: the same examples in every run."""

from hypothesis import settings

settings.register_profile("plant-bench", derandomize=True, max_examples=50, deadline=None)
settings.load_profile("plant-bench")
