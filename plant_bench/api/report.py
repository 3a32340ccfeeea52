"""The leaderboard: find runs, read them, write its files."""

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

RUNS = Path("reports")  # where `plant-bench score` puts runs
PAGE = "leaderboard.html"
FURTHER_STEPS = 3  # differences, files, page

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
    on_step: OnStep | None = None,
    on_replay: OnReplay | None = None,
) -> Leaderboard:
    """Read runs and write the leaderboard.

    Args:
        paths: Runs, folders of `plant-bench rfds`, checkpoint files; all in `RUNS` without any.
        out: The leaderboard's folder.
        penalties: By which infractions become scores.
        paper: Show PlanT's own figures, too.
        replays: Make a replay of each episode that was recorded.
        expert: Replays show whom the expert would brake for.
        workers: Processes that make replays.
        on_step: Told what is begun, and how many steps there are.
        on_replay: Told how many replays are made, and how many there will be.

    Raises:
        InputError: There is nothing to report, or a source cannot be read.
        OSError: The files cannot be written.
    """
    sources = find_sources(paths, below=RUNS)
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
        told = on_replay or _ignore
        told(0, len(shown))
        write_replays(out, shown, workers=workers, progress=told)
    return leaderboard


def _steps(sources: Sources) -> int:
    read = (sources.runs, sources.rankings, sources.checkpoints)
    return sum(map(len, read)) + FURTHER_STEPS


def _ignore(done: int, count: int) -> None:
    del done, count
