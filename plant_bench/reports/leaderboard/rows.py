"""A line of a leaderboard: what every table tells of a planner, whoever has scored it."""

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
class Line:
    """One planner's line.

    What is not known is not a number, empty or None.

    Attributes:
        id: Short, of letters, digits and hyphens; unlike any other on the leaderboard.
        planner: Its name, as shown.
        track: A `Track` in words; empty where not known.
        inputs: What it was given.
        scores: By name of `scoring.metrics_table`; those not known may be missing.
        inference_ms: IT, time of one forward pass.
        inference_tokens: As IT, of the tokens of a pass.
        processor: What IT was measured on.
        rfds: Relative filtered driving score in percent.
        ranker: By which of the planner's rankings.
        parameters: Of its network.
        date: Day of its newest episode, as in 2026-01-31.
        repetitions: Of the routes.
        episodes: How many there are.
        expected: How many there should be.
        agent_checksum: Content hash of its code and weights.
        source: Where its numbers are from, in words.
        rates: Infractions per kilometre by kind, all counts over all kilometres; for lanes left
            kilometres outside per kilometre.
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
    episodes: int = 0
    expected: int = 0
    agent_checksum: str = ""
    source: str = ""
    rates: Mapping[str, float] = field(default_factory=dict)
    km: float = math.nan

    @property
    def driving_score(self) -> Spread:
        """DS, by which boards are sorted."""
        return self.score(RANKED)

    def score(self, name: str) -> Spread:
        """Return a score, `UNKNOWN` where it is not known."""
        return self.scores.get(name, UNKNOWN)


def run_line(
    run: RunSource, summary: Summary, ranking: RankingSource | None, *, id: str, planner: str
) -> Line:
    """Return the line of a run of ours."""
    speed = speed_of(read_timings(run.folder, (item.name for item in run.episodes)))
    return Line(
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
        parameters=parameter_count(run.provenance.agent),
        date=_newest_day(run),
        repetitions=len({item.result.repetition for item in run.episodes}),
        episodes=summary.episodes,
        expected=summary.expected,
        agent_checksum=summary.agent_checksum,
        source=run.folder.path.name,
        rates={kind.value: rate for kind, rate in summary.infractions_per_km.items()},
        km=summary.km,
    )


def distinct(names: Sequence[str], fallback: Callable[[int], str]) -> list[str]:
    """Return names of which none is there twice: those that are get a further word, then a number.

    Args:
        names: What they are called.
        fallback: The further word of the name at a place.
    """
    worded = [
        f"{name} ({fallback(place)})" if names.count(name) > 1 else name
        for place, name in enumerate(names)
    ]
    return [
        f"{name} #{worded[: place + 1].count(name)}" if worded.count(name) > 1 else name
        for place, name in enumerate(worded)
    ]


def _newest_day(run: RunSource) -> str:
    """Return the day on which the newest record was written; records themselves hold no clock."""
    newest = max(path.stat().st_mtime for path in run.folder.record_files())
    return datetime.fromtimestamp(newest, tz=UTC).date().isoformat()
