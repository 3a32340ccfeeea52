"""Fuzzing of reports: an untrusted run next to a valid one."""

import shutil
from pathlib import Path

from fuzzing.drives import drive_seeds
from fuzzing.form import Format
from fuzzing.runs import put_run, run_files
from plant_bench.errors import InputError
from plant_bench.reports.comparison_table import print_difference
from plant_bench.reports.leaderboard.board_builder import make_leaderboard
from plant_bench.reports.leaderboard.exports import write_exports
from plant_bench.reports.leaderboard.leaderboard_page import write_page
from plant_bench.reports.leaderboard.score_sources import find_sources
from plant_bench.reports.replay.replay_episode import load_episode, replay_script
from plant_bench.reports.replay.replay_source import ReplaySource
from plant_bench.reports.tables import print_summary
from plant_bench.runner.run.folder import RunFolder
from plant_bench.runner.run.summary_files import write_summary
from plant_bench.scoring.comparison import paired_difference
from plant_bench.scoring.penalties import penalty_scheme_of
from plant_bench.scoring.results import EpisodeResult


def _replay(box: Path) -> None:
    result = EpisodeResult.load(box / "record.json")
    source = ReplaySource("run/fuzzed", "stranger", result.agent, box / "r.parquet", result)
    replay_script(load_episode(source))


def _first_record() -> str:
    return min(name for name in run_files() if "/episodes/" in name)


def _put_runs(box: Path) -> None:
    put_run(box)
    shutil.copytree(box / "run", box / "other")
    (box / "r.parquet").write_bytes(drive_seeds()[0])


def _use_report(box: Path) -> None:
    """Summarise, compare, report and replay a run; one of them at least must work."""
    shutil.copyfile(box / "record.json", box / _first_record())
    refusals = []
    for use in (_summarise, _compare, _report, _replay):
        try:
            use(box)
        except InputError as error:
            refusals.append(error)
    if len(refusals) == 4:
        raise refusals[0]


def _summarise(box: Path) -> None:
    print_summary(write_summary(RunFolder.open(box / "run")))


def _compare(box: Path) -> None:
    runs = [RunFolder.open(box / name).results() for name in ("run", "other")]
    penalties = penalty_scheme_of("lb1.0")
    print_difference(
        paired_difference(*runs, penalties=penalties), "run", "other", penalties=penalties
    )


def _report(box: Path) -> None:
    sources = find_sources([box / "run", box / "other"], below=box)
    board = make_leaderboard(
        sources, penalties=penalty_scheme_of("lb1.0"), paper=False, progress=lambda _: None
    )
    write_exports(board, box / "out")
    write_page(board, box / "out", replays=False)


def _seeds() -> list[bytes]:
    return [run_files()[_first_record()]]


FORMATS = (Format("report", "json", "record.json", _seeds, _use_report, _put_runs),)
