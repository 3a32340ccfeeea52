"""Significance tests: a paired permutation test, and Holm's correction for multiple tests."""

import math
from collections.abc import Sequence

import numpy as np
from jaxtyping import Float

EXACT_UP_TO = 13  # routes: all 8192 combinations of signs are tried; above it, signs are drawn
ROUNDING = 1e-9  # relative tolerance for equality


def sign_flip_test(
    sums: Float[np.ndarray, " routes"], *, seed: int = 0, samples: int = 10_000
) -> float:
    """Return the two-sided p-value of a paired permutation test over routes.

    If the two agents were equal, the sign of each route's difference would be random. So p is the
    share of all combinations of signs whose sum is at least as far from zero as the observed one.
    Scores are discrete (a collision costs 40 %) and often equal, so that neither the normal
    distribution of a t-test nor the untied ranks of Wilcoxon's test can be assumed. Repetitions of
    a route share one sign, since they are not independent.

    Args:
        sums: Sum over each route's episodes of the score differences.
        seed: Random seed, used if there are too many combinations to try all.
        samples: Number of combinations drawn; the observed one is added, so that p is never 0.
    """
    routes = len(sums)
    if routes <= EXACT_UP_TO:
        bits = (np.arange(2**routes)[:, None] >> np.arange(routes)) & 1
        extra = 0
    else:
        bits = np.random.default_rng(seed).integers(2, size=(samples, routes))
        extra = 1
    observed = abs(float(sums.sum()))
    least = observed - ROUNDING * max(float(np.abs(sums).sum()), 1.0)
    as_far = int((np.abs((1.0 - 2.0 * bits) @ sums) >= least).sum())
    return (as_far + extra) / (len(bits) + extra)


def holm(p_values: Sequence[float]) -> list[float]:
    """Return the p-values corrected for multiple testing (Holm's step-down), in their order.

    This bounds the probability of any false positive among all tests. Values that are nan stay nan
    and do not count as tests.

    >>> holm([0.01, 0.04, 0.03])
    [0.03, 0.06, 0.06]
    """
    known = sorted((p, place) for place, p in enumerate(p_values) if not math.isnan(p))
    corrected = list(p_values)
    highest = 0.0
    for rank, (p, place) in enumerate(known):
        highest = max(highest, min(1.0, (len(known) - rank) * p))
        corrected[place] = highest
    return corrected
