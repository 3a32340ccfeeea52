"""Scores the recordings of a run again, without the simulator, and compares the records."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from plant_bench.runner.run.folder import RunFolder
from plant_bench.runner.run.rescore_run import Rescored, rescore_folder
from plant_bench.runner.run.summary_files import write_rescored_summary
from plant_bench.scoring.metrics import Summary
from plant_bench.scoring.penalties import PenaltyScheme


@dataclass(frozen=True)
class RescoredRun:
    """Result of rescoring a run.

    Attributes:
        total: Number of episodes.
        equal: Number of episodes whose new record equals the original one.
        absent: Number of episodes without a recording.
        summary: Summary of the new records; None if there are none.
    """

    total: int
    equal: int
    absent: int
    summary: Summary | None

    @property
    def agrees(self) -> bool:
        """Whether all new records equal the original ones."""
        return self.equal + self.absent == self.total


def rescore_run(
    path: Path, *, penalties: PenaltyScheme, on_episode: Callable[[Rescored], None]
) -> RescoredRun:
    """Score a run's recordings again; write the new records and their summary to `rescored/`.

    Args:
        path: The run's folder.
        penalties: Penalty scheme of the summary.
        on_episode: Called with each rescored episode.

    Raises:
        InputError: The run does not exist, or its suite, towns or recordings cannot be read.
    """
    folder = RunFolder.open(path)
    episodes = []
    for episode in rescore_folder(folder):
        episodes.append(episode)
        on_episode(episode)
    again = [episode.again for episode in episodes if episode.again is not None]
    absent = len(episodes) - len(again)
    summary = (
        write_rescored_summary(folder, again, missing=absent, penalties=penalties)
        if again
        else None
    )
    return RescoredRun(len(episodes), sum(episode.equal for episode in episodes), absent, summary)
