"""The laws by which infractions become an infraction score. Records know none of them."""

import math
from collections import Counter
from collections.abc import Iterable, Mapping
from enum import StrEnum

from plant_bench.errors import InputError, did_you_mean
from plant_bench.scoring.infractions import COEFFICIENTS, PENALTIES, Infraction, InfractionKind


class Law(StrEnum):
    """A law; values are what `--law` takes."""

    LB1_0 = "lb1.0"  # multiplicative: CARLA leaderboard 1.0, Longest6, PlanT
    LB2_1 = "lb2.1"  # additive, also called hyperbolic: CARLA leaderboard 2.1


def law_of(name: str) -> Law:
    """Return the law of a name.

    Raises:
        InputError: There is no such law.
    """
    names = [law.value for law in Law]
    if name in names:
        return Law(name)
    hint = did_you_mean(name, names, cutoff=0.5)
    message = f"There is no law '{name}': {' and '.join(names)} are known.{hint}"
    raise InputError(message)


def infraction_score(
    counts: Mapping[InfractionKind, float], inside: float, law: Law = Law.LB1_0
) -> float:
    """Return IS, from 1 down to 0.

    Args:
        counts: How often each kind happened, or how often per kilometre; need not be whole. What
            costs by its share is left to `inside`.
        inside: Share of the distance that was driven inside the lanes.
        law: The law.
    """
    if law is Law.LB1_0:
        return inside * math.prod(PENALTIES.get(kind, 1.0) ** n for kind, n in counts.items())
    return inside / (1.0 + sum(COEFFICIENTS.get(kind, 0.0) * n for kind, n in counts.items()))


def score_of(infractions: Iterable[Infraction], law: Law = Law.LB1_0) -> float:
    """Return the IS of one episode's infractions."""
    infractions = tuple(infractions)
    inside = math.prod((1.0 - (item.share or 0.0) for item in infractions), start=1.0)
    counts = Counter(item.kind for item in infractions)
    return infraction_score({kind: float(n) for kind, n in counts.items()}, inside, law)
