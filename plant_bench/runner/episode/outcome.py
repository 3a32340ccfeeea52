"""The result of an episode: record and timing; importable without the simulator."""

from dataclasses import dataclass

from plant_bench.runner.episode.timing import Timing
from plant_bench.scoring.results import EpisodeResult


@dataclass(frozen=True)
class Outcome:
    """An episode that has ended."""

    result: EpisodeResult
    timing: Timing
