"""Writes the leaderboard: reads runs and writes its page, tables, figures and replays."""

from collections.abc import Callable, Sequence
from pathlib import Path

from plant_bench.reports.leaderboard.board import Leaderboard
from plant_bench.reports.leaderboard.board_builder import make_leaderboard
from plant_bench.reports.leaderboard.exports import write_exports
from plant_bench.reports.leaderboard.figures import write_figures
from plant_bench.reports.leaderboard.leaderboard_page import write_page
from plant_bench.reports.leaderboard.replays import replay_sources
from plant_bench.reports.leaderboard.score_sources import Sources, find_sources
from plant_bench.reports.replay.replay_site import write_replays
from plant_bench.runner.review.expert_queries import ask_expert
from plant_bench.scoring.penalties import PenaltyScheme

RUNS = Path("reports")  # default folder of `plant-bench score`
PAGE = "leaderboard.html"
STEPS_AFTER_READING = 3  # differences, files, page

OnStep = Callable[[str, int], None]
OnReplay = Callable[[int, int], None]


def write_report(
    paths: Sequence[Path],
    out: Path,
    *,
    penalties: PenaltyScheme = PenaltyScheme.LB1_0,
    paper: bool = False,
    replays: bool = True,
    expert: bool = False,
    workers: int = 1,
    against_last: bool = False,
    on_step: OnStep | None = None,
    on_replay: OnReplay | None = None,
) -> Leaderboard:
    """Read runs and write the leaderboard.

    Args:
        paths: Runs, folders of `plant-bench rfds` and checkpoint files of the CARLA leaderboard;
            if empty, all runs in `RUNS`.
        out: Folder of the leaderboard.
        penalties: Penalty scheme.
        paper: Also list the results published in the PlanT paper.
        replays: Write a replay of each recorded episode.
        expert: Mark the actors that the expert would brake for in the replays.
        workers: Number of processes that write replays.
        against_last: Also list the previous version of each run's planner, from the run's folder
            `superseded`.
        on_step: Called at the start of each step with its name and the number of steps.
        on_replay: Called with the number of replays written and the total.

    Raises:
        InputError: There are no runs, or a source cannot be read.
        OSError: The files cannot be written.
    """
    sources = find_sources(paths, below=RUNS, against_last=against_last)
    steps = _steps(sources)

    def begin(what: str) -> None:
        if on_step is not None:
            on_step(what, steps)

    leaderboard = make_leaderboard(sources, penalties=penalties, paper=paper, progress=begin)
    begin("files")
    write_exports(leaderboard, out)
    write_figures(leaderboard, out)
    begin("page")
    write_page(leaderboard, out, replays=replays)
    if replays:
        shown = replay_sources(leaderboard, ask_expert if expert else None)
        progress = on_replay or _ignore
        progress(0, len(shown))
        write_replays(out, shown, workers=workers, progress=progress)
    return leaderboard


def _steps(sources: Sources) -> int:
    read = (sources.runs, sources.previous, sources.rankings, sources.checkpoints)
    return sum(map(len, read)) + STEPS_AFTER_READING


def _ignore(done: int, count: int) -> None:
    del done, count
