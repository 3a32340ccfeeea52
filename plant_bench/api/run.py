"""A run on disk, to be looked at: its scores, its episodes, against another, and why."""

import os
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

from plant_bench.errors import InputError
from plant_bench.runner.run.folder import RunFolder
from plant_bench.runner.run.summary_files import write_summary
from plant_bench.scoring.comparison import PairedDifference, paired_difference
from plant_bench.scoring.metrics import Summary, summarise, summary_frame
from plant_bench.scoring.penalties import PenaltyScheme, penalty_scheme_of
from plant_bench.scoring.results import EpisodeResult

if TYPE_CHECKING:  # both draw, which most looks at a run do not need
    import pandas as pd

    from plant_bench.api.why import Explanation

PathLike = str | os.PathLike[str]


@dataclass(frozen=True)
class RunSummary:
    """The headline of a run: means over all its episodes.

    Attributes:
        planner: Its name.
        protocol: The rules it was scored under.
        penalties: By which infractions became scores.
        episodes: How many there are.
        km: Kilometres driven along the routes.
        driving_score: DS, 0 to 100.
        route_completion: RC in percent.
        infraction_score: IS, 0 to 1.
        vehicle_collisions: Collisions with vehicles per kilometre.
        normalised_score: NDS, 0 to 100.
        whole: The same with spreads, towns, infractions and all that is measured besides.
    """

    planner: str
    protocol: str
    penalties: str
    episodes: int
    km: float
    driving_score: float
    route_completion: float
    infraction_score: float
    vehicle_collisions: float
    normalised_score: float
    whole: Summary = field(repr=False)

    @classmethod
    def of(cls, summary: Summary) -> "RunSummary":
        """Return the headline of a summary."""
        scores = summary.scores
        return cls(
            planner=summary.agent,
            protocol=summary.protocol,
            penalties=summary.penalties.value,
            episodes=summary.episodes,
            km=summary.km,
            driving_score=scores["driving_score"].mean,
            route_completion=scores["route_completion"].mean,
            infraction_score=scores["infraction_score"].mean,
            vehicle_collisions=scores["vehicle_collisions"].mean,
            normalised_score=scores["normalised_score"].mean,
            whole=summary,
        )


@dataclass(frozen=True)
class Run:
    """A run of one planner on one suite: what `score` returns and `load_run` reads.

    All of it is read from the records at each look, so that it is what is on disk now.

    Attributes:
        path: The run's folder.
        penalties: By which infractions become scores.
    """

    path: Path
    penalties: PenaltyScheme = PenaltyScheme.LB1_0

    @property
    def results(self) -> list[EpisodeResult]:
        """The records, by route and repetition.

        Raises:
            InputError: One is broken.
        """
        return RunFolder(self.path).results()

    @property
    def summary(self) -> RunSummary:
        """The scores.

        Raises:
            InputError: There are no records, or they do not belong together.
        """
        results = self.results
        return RunSummary.of(summarise(results, expected=len(results), penalties=self.penalties))

    @property
    def episodes(self) -> "pd.DataFrame":
        """A row for each episode: scores, infractions by kind, how it ended; as `summary.csv`."""
        return summary_frame(self.results, penalties=self.penalties)

    def compare(self, other: "Run | PathLike") -> PairedDifference:
        """Return by how much this run's driving score is above another's.

        Episodes are paired by route and seed: both have driven in the same traffic.

        Args:
            other: The run to compare with, or its folder.

        Raises:
            InputError: They share no scenario, or are of two protocols.
        """
        base = other if isinstance(other, Run) else load_run(other)
        return paired_difference(base.results, self.results, penalties=self.penalties)

    def report(
        self,
        *others: "Run | PathLike",
        out: PathLike = "reports/leaderboard",
        replays: bool = False,
        workers: int = 1,
    ) -> Path:
        """Write a leaderboard of this run and others, and return its page.

        Args:
            others: Runs, or their folders; checkpoint files of the CARLA leaderboard.
            out: The leaderboard's folder.
            replays: Make a replay of each episode that was recorded.
            workers: Processes that make them.

        Raises:
            InputError: A run cannot be read.
        """
        from plant_bench.api.report import PAGE, write_report

        paths = [item.path if isinstance(item, Run) else Path(item) for item in (self, *others)]
        write_report(paths, Path(out), penalties=self.penalties, replays=replays, workers=workers)
        return Path(out) / PAGE

    def why(
        self, route: str | None = None, repetition: int | None = None, *, before: float = 4.0
    ) -> "list[Explanation]":
        """Say why it went wrong: the seconds before each infraction, and what the expert would do.

        The episodes are simulated again in this process, from their recordings.

        Args:
            route: Id or number; the one with the lowest score without it.
            repetition: The only one that is wanted; all of the route without it.
            before: Seconds to look at before each infraction.

        Returns:
            One for each episode of the route with infractions; `print` one to read it.

        Raises:
            InputError: There is no such episode, or no recording of it.
            SimulationError: SUMO fails.
        """
        from plant_bench.api.why import explain, worst_route

        chosen = worst_route(self.results) if route is None else route
        if chosen is None:
            return []
        found = explain(RunFolder.open(self.path), chosen, repetition, before)
        return [item for item in found if item.findings]

    def write_summary(self) -> Summary:
        """Write `summary.json` and `summary.csv`, and return what is in them.

        Raises:
            InputError: There are no records, or the folder cannot be written to.
        """
        return write_summary(RunFolder(self.path), penalties=self.penalties)


def load_run(path: PathLike, *, penalties: str = "lb1.0") -> Run:
    """Return a run that `score` or `plant-bench score` has made.

    Args:
        path: Its folder.
        penalties: Makes infractions a score: "lb1.0", as Longest6, or "lb2.1".

    Raises:
        InputError: There is no run, or it has no finished episode.
    """
    chosen = penalty_scheme_of(penalties)
    folder = RunFolder.open(Path(path))
    if not folder.record_files():
        told = folder.provenance()
        again = "" if told is None else f" ({told.command})"
        message = f"{folder.path} has no finished episode: drive it again{again}."
        raise InputError(message)
    return Run(folder.path, chosen)
