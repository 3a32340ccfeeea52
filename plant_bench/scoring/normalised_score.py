"""NDS: the driving score normalised by distance, with infractions counted per kilometre.

DS multiplies the penalties of a whole route: of two drivers with the same infraction rate, the one
who gets further may score less. NDS = RC x the IS that the same infractions per kilometre would
give over one kilometre. A rate is the total count over the total kilometres: a mean of scores per
episode would depend on the length of episodes.
"""

from collections import Counter
from collections.abc import Sequence

import numpy as np

from plant_bench.scoring.infractions import InfractionKind
from plant_bench.scoring.penalties import PenaltyScheme, infraction_score
from plant_bench.scoring.results import EpisodeResult

LEAST_KM = 0.001  # avoids division by zero in rates (CARLA leaderboard 2.0)


def kilometres(results: Sequence[EpisodeResult]) -> float:
    """Return the kilometres driven along the routes."""
    return sum((item.completion * item.route_length for item in results), start=0.0) / 1000.0


def counts_per_km(results: Sequence[EpisodeResult]) -> dict[InfractionKind, float]:
    """Return the number of infractions of each kind per kilometre."""
    km = max(kilometres(results), LEAST_KM)
    counts = Counter(item.kind for result in results for item in result.infractions)
    return {kind: counts[kind] / km for kind in InfractionKind}


def outside_metres(result: EpisodeResult) -> float:
    """Return the metres driven outside the lanes."""
    shares = (item.share or 0.0 for item in result.infractions)
    return result.distance * sum(shares, start=0.0)


def infraction_score_per_km(
    results: Sequence[EpisodeResult], penalties: PenaltyScheme = PenaltyScheme.LB1_0
) -> float:
    """Return the IS that the episodes' infraction rates give over one kilometre."""
    driven = sum(item.distance for item in results)
    outside = sum(map(outside_metres, results)) / driven if driven > 0.0 else 0.0
    return infraction_score(counts_per_km(results), 1.0 - min(outside, 1.0), penalties)


def normalised_score(
    results: Sequence[EpisodeResult], penalties: PenaltyScheme = PenaltyScheme.LB1_0
) -> float:
    """Return NDS, 0 to 100: mean RC times `infraction_score_per_km`."""
    completion = float(np.mean([item.route_completion for item in results]))
    return completion * infraction_score_per_km(results, penalties)
