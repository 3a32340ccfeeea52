"""The result of an episode: record and timing; importable without the simulator."""

from dataclasses import dataclass

from plant_bench.runner.episode.timing import Timing
from plant_bench.scoring.results import EpisodeResult


@dataclass(frozen=True)
class Outcome:
    """The record and the timing of a finished episode."""

    result: EpisodeResult
    timing: Timing
