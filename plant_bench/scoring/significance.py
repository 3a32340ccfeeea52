"""Is a difference chance? A paired test without assumptions of shape, and many tests at once."""

import math
from collections.abc import Sequence

import numpy as np
from jaxtyping import Float

EXACT_UP_TO = 13  # routes: all 8192 signs are tried; beyond that, signs are drawn
ROUNDING = 1e-9  # of the greatest sum: what differs by less is equal


def sign_flip_test(
    sums: Float[np.ndarray, " routes"], *, seed: int = 0, samples: int = 10_000
) -> float:
    """Return the two-sided p-value of a paired permutation test over routes.

    Were the two agents alike, each route's difference could as well have the other sign. So p is
    the share of all ways to choose signs whose sum is as far from zero as the one found. Scores
    leap (a collision costs 40 %) and are often equal, so that neither a normal distribution, as of
    a t-test, nor ranks without ties, as of Wilcoxon's, can be assumed. Repetitions of a route keep
    one sign together, since they are not independent.

    Args:
        sums: Of the differences of each route's episodes.
        seed: Of the signs drawn where there are too many to try all.
        samples: How many are drawn; the one found counts as one more, so that p is never 0.
    """
    routes = len(sums)
    if routes <= EXACT_UP_TO:
        bits = (np.arange(2**routes)[:, None] >> np.arange(routes)) & 1
        extra = 0
    else:
        bits = np.random.default_rng(seed).integers(2, size=(samples, routes))
        extra = 1
    found = abs(float(sums.sum()))
    least = found - ROUNDING * max(float(np.abs(sums).sum()), 1.0)
    as_far = int((np.abs((1.0 - 2.0 * bits) @ sums) >= least).sum())
    return (as_far + extra) / (len(bits) + extra)


def holm(p_values: Sequence[float]) -> list[float]:
    """Return the p-values corrected for being many (Holm's step-down), in their order.

    The chance that any of the tests finds a difference where there is none stays at the level.
    Values that are not a number stay so and do not count.

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
