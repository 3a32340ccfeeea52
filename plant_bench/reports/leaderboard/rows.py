"""Rows of a leaderboard: one planner's scores and facts, the same for every table."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from datetime import UTC, datetime

from plant_bench.reports.leaderboard.parameter_count import parameter_count
from plant_bench.reports.leaderboard.score_sources import RankingSource, RunSource
from plant_bench.runner.run.speed import read_timings, speed_of
from plant_bench.scoring.metrics import Scores, Spread, Summary
from plant_bench.scoring.metrics_table import RANKED
from plant_bench.sensing.inputs import track_of

UNKNOWN = Spread(math.nan, math.nan)


@dataclass(frozen=True)
class Row:
    """One planner's row.

    Unknown values are nan, empty or None.

    Attributes:
        id: Short unique id of letters, digits and hyphens.
        planner: Display name.
        track: Label of a `Track`; empty if not known.
        inputs: The observation inputs that it used.
        scores: By name of `scoring.metrics_table`; unknown ones may be missing.
        inference_ms: Inference time (IT): time of one forward pass.
        inference_tokens: Number of tokens in a forward pass, aggregated as IT.
        processor: Processor on which IT was measured.
        rfds: Relative filtered driving score in percent.
        ranker: The planner's ranking that RFDS belongs to.
        parameters: Number of parameters of its network.
        date: Day of its newest episode, as in 2026-01-31.
        repetitions: Repetitions of the routes.
        routes: Number of routes driven.
        suite_routes: Number of routes in the suite; 0 if not known.
        episodes: Number of episodes.
        expected: Number of episodes in a complete run.
        agent_checksum: Content hash of its code and weights.
        source: Source of the numbers, as text.
        rates: Infractions per kilometre by kind: total count over total kilometres; for
            OUTSIDE_LANES, kilometres outside per kilometre.
        km: Kilometres driven along the routes.
    """

    id: str
    planner: str
    track: str
    inputs: tuple[str, ...]
    scores: Scores
    inference_ms: float = math.nan
    inference_tokens: float = math.nan
    processor: str = ""
    rfds: Spread = UNKNOWN
    ranker: str = ""
    parameters: int | None = None
    date: str = ""
    repetitions: int = 0
    routes: int = 0
    suite_routes: int = 0
    episodes: int = 0
    expected: int = 0
    agent_checksum: str = ""
    source: str = ""
    rates: Mapping[str, float] = field(default_factory=dict)
    km: float = math.nan

    @property
    def driving_score(self) -> Spread:
        """DS, the score that boards are sorted by."""
        return self.score(RANKED)

    def score(self, name: str) -> Spread:
        """Return a score, `UNKNOWN` if it is missing."""
        return self.scores.get(name, UNKNOWN)


def run_row(
    run: RunSource, summary: Summary, ranking: RankingSource | None, *, id: str, planner: str
) -> Row:
    """Return the row of a plant-bench run."""
    speed = speed_of(read_timings(run.folder, (item.name for item in run.episodes)))
    return Row(
        id=id,
        planner=planner,
        track=track_of(summary.inputs).label,
        inputs=summary.inputs,
        scores=summary.scores,
        inference_ms=speed.inference_ms,
        inference_tokens=speed.inference_tokens,
        processor="; ".join(speed.processors),
        rfds=UNKNOWN if ranking is None else ranking.score.score,
        ranker="" if ranking is None else ranking.ranker,
        parameters=None if run.previous else parameter_count(run.provenance.agent),
        date=_newest_day(run),
        repetitions=len({item.result.repetition for item in run.episodes}),
        routes=len({item.result.route for item in run.episodes}),
        suite_routes=len(run.provenance.routes),
        episodes=summary.episodes,
        expected=summary.expected,
        agent_checksum=summary.agent_checksum,
        source=run.place,
        rates={kind.value: rate for kind, rate in summary.infractions_per_km.items()},
        km=summary.km,
    )


def distinct(names: Sequence[str], fallback: Callable[[int], str]) -> list[str]:
    """Return unique names: duplicates get a suffix, and a number if that is not enough.

    Args:
        names: The names, with duplicates.
        fallback: Returns the suffix of the name at an index.
    """
    suffixed = [
        f"{name} ({fallback(place)})" if names.count(name) > 1 else name
        for place, name in enumerate(names)
    ]
    return [
        f"{name} #{suffixed[: place + 1].count(name)}" if suffixed.count(name) > 1 else name
        for place, name in enumerate(suffixed)
    ]


def _newest_day(run: RunSource) -> str:
    """Return the day on which the newest record file was written; records contain no dates."""
    newest = max(path.stat().st_mtime for path in run.record_files)
    return datetime.fromtimestamp(newest, tz=UTC).date().isoformat()
