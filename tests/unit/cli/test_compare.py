"""`plant-bench compare`: one rule for text, exit code and report; routes; previous versions."""

import os
from pathlib import Path

import pytest
from typer.testing import CliRunner

import plant_bench as pb
from plant_bench.cli import app
from plant_bench.errors import InputError
from plant_bench.reports.leaderboard.board_builder import make_leaderboard
from plant_bench.reports.leaderboard.score_sources import find_sources
from plant_bench.runner.run.folder import RunFolder
from plant_bench.scoring.comparison import Verdict
from plant_bench.scoring.penalties import PenaltyScheme
from tests.conftest import RunWriter


def compare(*arguments: object) -> tuple[int, str]:
    done = CliRunner().invoke(app, ["compare", *map(str, arguments)])
    return done.exit_code, " ".join(done.output.split())


def significant_on_the_page(*paths: Path) -> bool:
    board = make_leaderboard(
        find_sources(paths, below=Path("nowhere")),
        penalties=PenaltyScheme.LB1_0,
        paper=False,
        progress=lambda _: None,
    ).boards[0]
    return board.differences[0].significant


def test_three_differing_routes_of_seven_are_no_regression(
    tmp_path: Path, write_run: RunWriter
) -> None:
    good = write_run(tmp_path / "good", "good", worse=100, routes=7, repetitions=1)
    facts = {"routes": 7, "repetitions": 1, "checksum": "b" * 64}
    bad = write_run(tmp_path / "bad", "bad", worse=2, **facts)

    code, said = compare(good, bad)

    assert code == 0
    assert "p = 0.2500" in said
    assert "No significant difference: p is above 0.05" in said
    assert pb.load_run(bad).compare(good).high < 0.0
    assert pb.load_run(bad).compare(good).verdict is Verdict.NOT_SIGNIFICANT
    assert not significant_on_the_page(good, bad)


def test_regression_has_the_same_verdict_everywhere(tmp_path: Path, write_run: RunWriter) -> None:
    good = write_run(tmp_path / "good", "good", worse=100, routes=12)
    bad = write_run(tmp_path / "bad", "bad", worse=1, routes=12, checksum="b" * 64)

    code, said = compare(good, bad)

    assert code == 1
    assert "Worse: p is at most 0.05, and the interval is below zero." in said
    assert pb.load_run(bad).compare(good).verdict is Verdict.WORSE
    assert significant_on_the_page(good, bad)


def test_routes_are_listed_with_what_happened(tmp_path: Path, write_run: RunWriter) -> None:
    good = write_run(tmp_path / "good", "good", worse=100)
    bad = write_run(tmp_path / "bad", "bad", worse=1, checksum="b" * 64)

    _, said = compare(good, bad, "--top", 1)
    _, everything = compare(good, bad, "--all")
    _, nothing = compare(good, bad, "--top", 0)

    assert "town01-2 100.0 60.0 -40.0 no infraction 2 x collision with a vehicle" in said
    assert "and 5 routes with smaller differences (--all lists them)" in said
    assert "town02-3" not in said
    assert all(f"town0{1 + route % 2}-{route}" in everything for route in range(6))
    assert "town01-2" not in nothing


def superseded(path: Path, write_run: RunWriter, **versions: tuple[int, str, int]) -> Path:
    """A run with superseded versions: `worse`, checksum, and time of writing."""
    run = write_run(path / "run", "mine", worse=100, checksum="c" * 64)
    for name, (worse, checksum, time) in versions.items():
        old = write_run(path / name, "mine", worse=worse, checksum=checksum * 64)
        for record in RunFolder(old).record_files():
            target = run / "superseded" / "episodes" / f"{record.stem}{name}.json"
            target.parent.mkdir(parents=True, exist_ok=True)
            record.rename(target)
            os.utime(target, (time, time))
    return run


def test_run_is_compared_with_the_last_version_of_its_planner(
    tmp_path: Path, write_run: RunWriter
) -> None:
    run = superseded(
        tmp_path, write_run, oldest=(100, "a", 100), last=(1, "b", 200), rules=(2, "c", 300)
    )

    code, said = compare(run, "--against-last")

    assert code == 0
    assert f"{run} minus {run} (previous)" in said
    assert pb.load_run(run).compare_with_previous().mean == pytest.approx(40.0 * 11 / 12)
    sources = find_sources([run], below=Path("nowhere"), against_last=True)
    board = make_leaderboard(
        sources, penalties=PenaltyScheme.LB1_0, paper=False, progress=lambda _: None
    ).boards[0]
    assert [row.planner for row in board.rows] == ["mine", "mine (previous)"]
    assert [row.driving_score.mean for row in board.rows] == pytest.approx(
        [100.0 - 40.0 / 12, 60.0]
    )
    assert board.rows[1].source == "run/superseded"


def test_run_without_a_previous_version_is_refused(tmp_path: Path, write_run: RunWriter) -> None:
    run = superseded(tmp_path, write_run, rules=(2, "c", 300))

    with pytest.raises(InputError, match="has no episodes of a previous version of its planner"):
        pb.load_run(run).compare_with_previous()
    with pytest.raises(InputError, match="has no episodes of a previous version of its planner"):
        find_sources([run], below=Path("nowhere"), against_last=True)


@pytest.mark.parametrize("options", [[], ["other", "--against-last"]])
def test_one_run_needs_against_last_and_two_refuse_it(tmp_path: Path, options: list[str]) -> None:
    done = CliRunner().invoke(app, ["compare", str(tmp_path), *options])

    assert isinstance(done.exception, InputError)
    assert "against-last" in str(done.exception)
