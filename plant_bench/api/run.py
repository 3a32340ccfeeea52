"""Reads a run from disk: scores, episodes, comparison with another run, causes of infractions."""

import os
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

from plant_bench.errors import InputError
from plant_bench.runner.run.folder import RunFolder, sorted_results
from plant_bench.runner.run.previous_version import previous_records
from plant_bench.runner.run.summary_files import write_summary
from plant_bench.scoring.comparison import PairedDifference, paired_difference
from plant_bench.scoring.metrics import Summary, summarise, summary_frame
from plant_bench.scoring.penalties import PenaltyScheme, penalty_scheme_of
from plant_bench.scoring.results import EpisodeResult

if TYPE_CHECKING:  # heavy imports that most uses of a run do not need
    import pandas as pd

    from plant_bench.api.why import Explanation

PathLike = str | os.PathLike[str]


@dataclass(frozen=True)
class RunSummary:
    """The headline scores of a run: means over all its episodes.

    Attributes:
        planner: Name of the planner.
        protocol: Version of the benchmark's rules.
        penalties: Penalty scheme.
        episodes: Number of episodes.
        km: Distance driven along the routes, kilometres.
        driving_score: Driving score (DS), 0 to 100.
        route_completion: Route completion (RC), percent.
        infraction_score: Infraction score (IS), 0 to 1.
        vehicle_collisions: Collisions with vehicles per kilometre.
        normalised_score: Normalised driving score (NDS), 0 to 100.
        whole: The full summary: standard deviations, scores by town, infractions, further metrics.
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
        """Return the headline scores of a summary."""
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

    Each property reads the records again and so reflects what is on disk now.

    Attributes:
        path: Folder of the run.
        penalties: Penalty scheme.
    """

    path: Path
    penalties: PenaltyScheme = PenaltyScheme.LB1_0

    @property
    def results(self) -> list[EpisodeResult]:
        """The records of the episodes, ordered by route and repetition.

        Raises:
            InputError: A record is invalid.
        """
        return RunFolder(self.path).results()

    @property
    def summary(self) -> RunSummary:
        """The headline scores.

        Raises:
            InputError: There are no records, or they are not all from the same run.
        """
        results = self.results
        return RunSummary.of(summarise(results, expected=len(results), penalties=self.penalties))

    @property
    def episodes(self) -> "pd.DataFrame":
        """One row per episode, as in `summary.csv`: scores, infractions by kind, final status."""
        return summary_frame(self.results, penalties=self.penalties)

    def compare(self, other: "Run | PathLike") -> PairedDifference:
        """Return the paired difference in driving score, this run minus the other.

        Episodes are paired by route and seed, so both planners met the same initial traffic. The
        result's `verdict` says whether the difference is significant, and `by_route` gives the
        differences on each route.

        Args:
            other: The run to compare with, or its folder.

        Raises:
            InputError: The runs share no scenario, or their protocols differ.
        """
        base = other if isinstance(other, Run) else load_run(other)
        return paired_difference(base.results, self.results, penalties=self.penalties)

    def compare_with_previous(self) -> PairedDifference:
        """Return the paired difference from the previous version of the planner.

        The episodes of that version are in the run's folder `superseded`.

        Raises:
            InputError: There are none, or they share no scenario with the run.
        """
        previous = sorted_results(previous_records(RunFolder(self.path)).values())
        return paired_difference(previous, self.results, penalties=self.penalties)

    def report(
        self,
        *others: "Run | PathLike",
        out: PathLike = "reports/leaderboard",
        replays: bool = False,
        workers: int = 1,
    ) -> Path:
        """Write a leaderboard of this run and others; return the path of its page.

        Args:
            others: Runs or their folders, or checkpoint files of the CARLA leaderboard.
            out: Folder of the leaderboard.
            replays: Write a replay of each recorded episode.
            workers: Number of processes that write replays.

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
        """Explain the infractions on a route: what preceded each, and what the expert would do.

        The episodes are simulated again in this process, from their recordings.

        Args:
            route: Id or number of the route. Default: the route with the lowest score.
            repetition: Repetition of the route. Default: all of them.
            before: Time to analyse before each infraction, seconds.

        Returns:
            One explanation for each episode with infractions; `print` shows it as text.

        Raises:
            InputError: The episode or its recording does not exist.
            SimulationError: SUMO fails.
        """
        from plant_bench.api.why import explain, worst_route

        chosen = worst_route(self.results) if route is None else route
        if chosen is None:
            return []
        explanations = explain(RunFolder.open(self.path), chosen, repetition, before)
        return [item for item in explanations if item.findings]

    def write_summary(self) -> Summary:
        """Write `summary.json` and `summary.csv`; return the summary.

        Raises:
            InputError: There are no records, or the folder is not writable.
        """
        return write_summary(RunFolder(self.path), penalties=self.penalties)


def load_run(path: PathLike, *, penalties: str = "lb1.0") -> Run:
    """Return a run that `score` or `plant-bench score` has written.

    Args:
        path: Folder of the run.
        penalties: Penalty scheme: "lb1.0", as in Longest6, or "lb2.1".

    Raises:
        InputError: The folder holds no run, or no episode is finished.
    """
    chosen = penalty_scheme_of(penalties)
    folder = RunFolder.open(Path(path))
    if not folder.record_files():
        provenance = folder.provenance()
        command = "" if provenance is None else f": {provenance.command}"
        message = f"{folder.path} has no finished episode. Continue the run{command}."
        raise InputError(message)
    return Run(folder.path, chosen)
