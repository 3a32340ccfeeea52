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
from plant_bench.scoring.beyond import (
    COLLISIONS,
    Beyond,
    beyond_the_score,
    collisions_with,
    measure_row,
)
from plant_bench.scoring.comparison import Detectable, detectable_difference
from plant_bench.scoring.infractions import InfractionKind, Status
from plant_bench.scoring.laws import Law
from plant_bench.scoring.normalised import (
    LEAST_KM,
    counts_per_km,
    kilometres,
    normalised_score,
    outside_metres,
)
from plant_bench.scoring.results import EpisodeResult
from plant_bench.world.hazard import Phase
from plant_bench.world.scene import ActorKind


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
        normalised_score: NDS, 0 to 100: DS with infractions taken per kilometre.
    """

    driving_score: Spread
    route_completion: Spread
    infraction_score: Spread
    vehicle_collisions: Spread
    normalised_score: Spread


@dataclass(frozen=True)
class Summary:
    """One agent's row of the leaderboard.

    Attributes:
        agent: Its name.
        agent_checksum: Content hash of its code and weights.
        inputs: What it was given.
        protocol: The rules it was scored under.
        law: By which infractions became scores.
        scores: Over all towns.
        towns: Scores by town, in order of name.
        infractions_per_km: By kind, over all episodes; for OUTSIDE_LANES kilometres outside.
        cyclists_per_km: Collisions with bicycles, which count as vehicles in every law.
        statuses: How many episodes ended how.
        hazards: How many hazards came how far.
        ego_share: Share of the collisions that the ego caused; nan if there were none.
        blocked: Number of blocked routes in each repetition, in order.
        km: Kilometres driven along the routes.
        episodes: Number of episodes.
        expected: Number of episodes there should be.
        beyond: Measures that are no part of the score.
        detectable: The least difference in DS that the repetitions can show; None for a single one.
    """

    agent: str
    agent_checksum: str
    inputs: tuple[str, ...]
    protocol: str
    law: Law
    scores: Scores
    towns: dict[str, Scores]
    infractions_per_km: dict[InfractionKind, float]
    cyclists_per_km: float
    statuses: dict[Status, int]
    hazards: dict[Phase, int]
    ego_share: float
    blocked: tuple[int, ...]
    km: float
    episodes: int
    expected: int
    beyond: Beyond
    detectable: Detectable | None

    @property
    def complete(self) -> bool:
        """True if no episode is missing."""
        return self.episodes == self.expected


def summarise(results: Sequence[EpisodeResult], *, expected: int, law: Law = Law.LB1_0) -> Summary:
    """Sum up the episodes of one agent.

    Args:
        results: In any order.
        expected: How many there should be, routes times repetitions.
        law: By which infractions become scores.

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
        law=law,
        scores=_scores(results, law),
        towns={
            town: _scores([item for item in results if item.town == town], law)
            for town in sorted({item.town for item in results})
        },
        infractions_per_km=_rates(results),
        cyclists_per_km=sum(collisions_with(item, ActorKind.BICYCLE) for item in results)
        / max(kilometres(results), LEAST_KM),
        statuses={
            status: count
            for status in Status
            if (count := sum(item.status is status for item in results))
        },
        hazards=dict(Counter(item.phase for result in results for item in result.hazards)),
        ego_share=caused / len(collisions) if collisions else math.nan,
        blocked=tuple(
            sum(item.status is Status.BLOCKED for item in part) for part in _repetitions(results)
        ),
        km=kilometres(results),
        episodes=len(results),
        expected=expected,
        beyond=beyond_the_score(results),
        detectable=detectable_difference(results, law=law),
    )


def summary_frame(results: Iterable[EpisodeResult], *, law: Law = Law.LB1_0) -> pd.DataFrame:
    """Return one row for each episode, for CSV; sorted, so that equal results give equal text."""
    ordered = sorted(results, key=lambda item: (item.agent, item.town, item.route, item.repetition))
    return pd.DataFrame([_row(result, law) for result in ordered])


def _row(result: EpisodeResult, law: Law) -> dict[str, object]:
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
        "law": law.value,
        "driving_score": result.driving_score_by(law),
        "route_completion": result.route_completion,
        "infraction_score": result.infraction_score_by(law),
        "normalised_score": normalised_score([result], law),
        "route_length": result.route_length,
        "distance": result.distance,
        "duration": result.duration,
        **{kind.value: counts[kind] for kind in events},
        "collisions_cyclist": collisions_with(result, ActorKind.BICYCLE),
        "collisions_motorcyclist": collisions_with(result, ActorKind.MOTORCYCLE),
        "outside_share": sum(outside),
        "caused_by_ego": sum(item.cause == "ego" for item in result.infractions),
        "caused_by_other": sum(item.cause == "other" for item in result.infractions),
        **measure_row(result.measures),
        "reason": result.reason,
    }


def _scores(results: Sequence[EpisodeResult], law: Law) -> Scores:
    parts = _repetitions(results)
    return Scores(
        Spread.of([_mean(item.driving_score_by(law) for item in part) for part in parts]),
        Spread.of([_mean(item.route_completion for item in part) for part in parts]),
        Spread.of([_mean(item.infraction_score_by(law) for item in part) for part in parts]),
        Spread.of([_rates(part)[InfractionKind.COLLISION_VEHICLE] for part in parts]),
        Spread.of([normalised_score(part, law) for part in parts]),
    )


def _repetitions(results: Sequence[EpisodeResult]) -> list[list[EpisodeResult]]:
    numbers = sorted({item.repetition for item in results})
    return [[item for item in results if item.repetition == number] for number in numbers]


def _mean(values: Iterable[float]) -> float:
    return float(np.mean(list(values)))


def _rates(results: Sequence[EpisodeResult]) -> dict[InfractionKind, float]:
    outside = sum(map(outside_metres, results)) / 1000.0 / max(kilometres(results), LEAST_KM)
    return counts_per_km(results) | {InfractionKind.OUTSIDE_LANES: outside}


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
