"""Penalty schemes: how infractions become an infraction score. Records do not depend on them."""

import math
from collections import Counter
from collections.abc import Iterable, Mapping
from enum import StrEnum

from plant_bench.errors import InputError, did_you_mean
from plant_bench.scoring.infractions import COEFFICIENTS, PENALTIES, Infraction, InfractionKind


class PenaltyScheme(StrEnum):
    """A penalty scheme; values are those of the option `--penalties`."""

    LB1_0 = "lb1.0"  # multiplicative: CARLA leaderboard 1.0, Longest6, PlanT
    LB2_1 = "lb2.1"  # additive, also called hyperbolic: CARLA leaderboard 2.1


def penalty_scheme_of(name: str) -> PenaltyScheme:
    """Return the penalty scheme of a name.

    Raises:
        InputError: There is no such penalty scheme.
    """
    names = [scheme.value for scheme in PenaltyScheme]
    if name in names:
        return PenaltyScheme(name)
    hint = did_you_mean(name, names, cutoff=0.5)
    message = f"Unknown penalty scheme '{name}': expected {' or '.join(names)}.{hint}"
    raise InputError(message)


def infraction_score(
    counts: Mapping[InfractionKind, float],
    inside: float,
    penalties: PenaltyScheme = PenaltyScheme.LB1_0,
) -> float:
    """Return IS, from 1 down to 0.

    Args:
        counts: Number of infractions of each kind, or number per kilometre. OUTSIDE_LANES has no
            effect here; its penalty is `inside`.
        inside: Share of the distance that was driven inside the lanes.
        penalties: The penalty scheme.
    """
    if penalties is PenaltyScheme.LB1_0:
        return inside * math.prod(PENALTIES.get(kind, 1.0) ** n for kind, n in counts.items())
    return inside / (1.0 + sum(COEFFICIENTS.get(kind, 0.0) * n for kind, n in counts.items()))


def score_of(
    infractions: Iterable[Infraction], penalties: PenaltyScheme = PenaltyScheme.LB1_0
) -> float:
    """Return the IS of one episode's infractions."""
    infractions = tuple(infractions)
    inside = math.prod((1.0 - (item.share or 0.0) for item in infractions), start=1.0)
    counts = Counter(item.kind for item in infractions)
    return infraction_score({kind: float(n) for kind, n in counts.items()}, inside, penalties)
