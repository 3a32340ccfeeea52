"""What a run scores: episodes in, a summary of one agent out.

DS is the mean over routes of RC x IS, not the product of the two means. Rates per kilometre are all
counts over all kilometres: the leaderboard's sum of per-route rates is a known mistake
(carla-simulator/leaderboard#117).
"""

import math
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd

from plant_bench.errors import InputError
from plant_bench.scoring.infractions import InfractionKind, Status
from plant_bench.scoring.results import EpisodeResult

LEAST_KM = 0.001  # so that a rate is never a division by zero (CARLA leaderboard 2.0)
COLLISIONS = (
    InfractionKind.COLLISION_PEDESTRIAN,
    InfractionKind.COLLISION_VEHICLE,
    InfractionKind.COLLISION_STATIC,
)


@dataclass(frozen=True)
class Spread:
    """Mean and sample standard deviation over repetitions; nan for the latter if there is one."""

    mean: float
    std: float

    @classmethod
    def of(cls, values: Sequence[float]) -> "Spread":
        """Return the mean and the standard deviation (n - 1) of the values."""
        std = float(np.std(values, ddof=1)) if len(values) > 1 else math.nan
        return cls(float(np.mean(values)), std)


@dataclass(frozen=True)
class Scores:
    """The scores of a table row, each over repetitions.

    Attributes:
        driving_score: DS, 0 to 100.
        route_completion: RC in percent.
        infraction_score: IS, 0 to 1.
        vehicle_collisions: CV, collisions with vehicles per kilometre driven along the routes.
    """

    driving_score: Spread
    route_completion: Spread
    infraction_score: Spread
    vehicle_collisions: Spread


@dataclass(frozen=True)
class Summary:
    """One agent's row of the leaderboard.

    Attributes:
        agent: Its name.
        agent_checksum: Content hash of its code and weights.
        inputs: What it was given.
        protocol: The rules it was scored under.
        scores: Over all towns.
        towns: Scores by town, in order of name.
        infractions_per_km: By kind, over all episodes; for OUTSIDE_LANES kilometres outside.
        statuses: How many episodes ended how.
        ego_share: Share of the collisions that the ego caused; nan if there were none.
        blocked: Number of blocked routes in each repetition, in order.
        km: Kilometres driven along the routes.
        episodes: Number of episodes.
        expected: Number of episodes there should be.
    """

    agent: str
    agent_checksum: str
    inputs: tuple[str, ...]
    protocol: str
    scores: Scores
    towns: dict[str, Scores]
    infractions_per_km: dict[InfractionKind, float]
    statuses: dict[Status, int]
    ego_share: float
    blocked: tuple[int, ...]
    km: float
    episodes: int
    expected: int

    @property
    def complete(self) -> bool:
        """True if no episode is missing."""
        return self.episodes == self.expected


def summarise(results: Sequence[EpisodeResult], *, expected: int) -> Summary:
    """Sum up the episodes of one agent.

    Args:
        results: In any order.
        expected: How many there should be, routes times repetitions.

    Raises:
        InputError: There are none, they are of several agents or protocols, or one is there twice.
    """
    _check(results)
    first = results[0]
    collisions = [
        item for result in results for item in result.infractions if item.kind in COLLISIONS
    ]
    caused = sum(item.cause == "ego" for item in collisions)
    return Summary(
        agent=first.agent,
        agent_checksum=first.agent_checksum,
        inputs=first.inputs,
        protocol=first.protocol,
        scores=_scores(results),
        towns={
            town: _scores([item for item in results if item.town == town])
            for town in sorted({item.town for item in results})
        },
        infractions_per_km=_rates(results),
        statuses={
            status: count
            for status in Status
            if (count := sum(item.status is status for item in results))
        },
        ego_share=caused / len(collisions) if collisions else math.nan,
        blocked=tuple(
            sum(item.status is Status.BLOCKED for item in part) for part in _repetitions(results)
        ),
        km=sum(map(_km, results)),
        episodes=len(results),
        expected=expected,
    )


def summary_frame(results: Iterable[EpisodeResult]) -> pd.DataFrame:
    """Return one row for each episode, for CSV; sorted, so that equal results give equal text."""
    ordered = sorted(results, key=lambda item: (item.agent, item.town, item.route, item.repetition))
    return pd.DataFrame([_row(result) for result in ordered])


def _row(result: EpisodeResult) -> dict[str, object]:
    counts = Counter(item.kind for item in result.infractions)
    outside = [item.share for item in result.infractions if item.share is not None]
    events = [kind for kind in InfractionKind if kind is not InfractionKind.OUTSIDE_LANES]
    return {
        "agent": result.agent,
        "inputs": " ".join(result.inputs),
        "town": result.town,
        "route": result.route,
        "repetition": result.repetition,
        "seed": result.seed,
        "density": result.density,
        "scenario": result.scenario,
        "status": result.status.value,
        "driving_score": result.driving_score,
        "route_completion": result.route_completion,
        "infraction_score": result.infraction_score,
        "route_length": result.route_length,
        "distance": result.distance,
        "duration": result.duration,
        **{kind.value: counts[kind] for kind in events},
        "outside_share": sum(outside),
        "caused_by_other": sum(item.cause == "other" for item in result.infractions),
        "reason": result.reason,
    }


def _scores(results: Sequence[EpisodeResult]) -> Scores:
    parts = _repetitions(results)
    return Scores(
        Spread.of([_mean(item.driving_score for item in part) for part in parts]),
        Spread.of([_mean(item.route_completion for item in part) for part in parts]),
        Spread.of([_mean(item.infraction_score for item in part) for part in parts]),
        Spread.of([_rates(part)[InfractionKind.COLLISION_VEHICLE] for part in parts]),
    )


def _repetitions(results: Sequence[EpisodeResult]) -> list[list[EpisodeResult]]:
    numbers = sorted({item.repetition for item in results})
    return [[item for item in results if item.repetition == number] for number in numbers]


def _mean(values: Iterable[float]) -> float:
    return float(np.mean(list(values)))


def _km(result: EpisodeResult) -> float:
    return result.completion * result.route_length / 1000.0


def _rates(results: Sequence[EpisodeResult]) -> dict[InfractionKind, float]:
    km = max(sum(map(_km, results)), LEAST_KM)
    counts = Counter(item.kind for result in results for item in result.infractions)
    rates = {kind: counts[kind] / km for kind in InfractionKind}
    outside = sum(
        item.share * result.distance / 1000.0
        for result in results
        for item in result.infractions
        if item.share is not None
    )
    return rates | {InfractionKind.OUTSIDE_LANES: outside / km}


def _check(results: Sequence[EpisodeResult]) -> None:
    """Refuse what must not be summed up.

    Raises:
        InputError: Why.
    """
    if not results:
        message = "No episodes to sum up. Run 'plant-bench score' first."
        raise InputError(message)
    first = results[0]
    for item in results:
        if (item.agent, item.agent_checksum) != (first.agent, first.agent_checksum):
            message = (
                f"Episodes of two agents: {first.agent} ({first.agent_checksum[:12]}) and "
                f"{item.agent} ({item.agent_checksum[:12]}). Score one of them again."
            )
            raise InputError(message)
        if item.protocol != first.protocol:
            message = (
                f"Episodes of two protocols, {first.protocol} and {item.protocol}: their scores "
                "cannot be mixed. Score the older ones again."
            )
            raise InputError(message)
    counts = Counter((item.scenario, item.repetition) for item in results)
    (scenario, repetition), count = counts.most_common(1)[0]
    if count > 1:
        message = (
            f"{first.agent}: scenario {scenario}, repetition {repetition} is there {count} times. "
            "Give each episode once."
        )
        raise InputError(message)
