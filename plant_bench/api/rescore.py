"""Scoring a run's recordings again, without the simulator."""

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
    """What came of it.

    Attributes:
        total: Number of episodes.
        equal: Of them, those whose two records are the same.
        absent: Of them, those without a recording.
        summary: Of the new records; None without any.
    """

    total: int
    equal: int
    absent: int
    summary: Summary | None

    @property
    def agrees(self) -> bool:
        """Whether no record differs."""
        return self.equal + self.absent == self.total


def rescore_run(
    path: Path, *, penalties: PenaltyScheme, on_episode: Callable[[Rescored], None]
) -> RescoredRun:
    """Score a run's recordings again, and write the records and their summary into `rescored/`.

    Args:
        path: The run's folder.
        penalties: By which infractions become scores, in the summary.
        on_episode: Told of each episode.

    Raises:
        InputError: There is no such run, or its suite, towns or recordings cannot be read.
    """
    folder = RunFolder.open(path)
    found = []
    for episode in rescore_folder(folder):
        found.append(episode)
        on_episode(episode)
    again = [episode.again for episode in found if episode.again is not None]
    absent = len(found) - len(again)
    summary = (
        write_rescored_summary(folder, again, missing=absent, penalties=penalties)
        if again
        else None
    )
    return RescoredRun(len(found), sum(episode.equal for episode in found), absent, summary)
