from pathlib import Path

import pytest
from typer.testing import CliRunner

from plant_bench.cli import app
from plant_bench.errors import InputError

FILES = {
    *(f"leaderboard.{kind}" for kind in ("csv", "html", "json", "md", "parquet", "png", "svg")),
    "leaderboard.tex",
    "episodes.csv",
    "episodes.parquet",
}


def report(*arguments):
    return CliRunner().invoke(app, ["report", *map(str, arguments)])


def test_report_writes_all_files_and_prints_the_order(tmp_path, write_run):
    runs = [
        write_run(tmp_path / name, name, worse=worse, routes=12, checksum=name * 64)
        for name, worse in (("a", 1), ("b", 40))
    ]
    done = report(*runs, "--no-replays", "--out", tmp_path / "out")
    assert done.exit_code == 0, done.output
    assert "DS b 98.3, a 60.0" in done.output
    assert "  b against a: +38.3 DS, 95 % interval" in done.output
    assert {path.name for path in (tmp_path / "out").iterdir()} == FILES


def test_report_without_arguments_uses_the_working_folder(tmp_path, write_run, monkeypatch):
    write_run(tmp_path / "reports" / "a", "a")
    monkeypatch.chdir(tmp_path)
    assert report("--no-replays").exit_code == 0
    assert Path("reports/leaderboard/leaderboard.html").is_file()
    assert report("--no-replays").exit_code == 0, "the leaderboard itself is no run"


def test_folder_that_is_not_a_run_raises_input_error(tmp_path):
    done = report(tmp_path, "--out", tmp_path / "out")
    assert isinstance(done.exception, InputError)
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("penalties", ["lb1.0", "lb2.1"])
def test_penalty_scheme_is_named_in_the_report(tmp_path, write_run, penalties):
    done = report(
        write_run(tmp_path / "a"),
        "--no-replays",
        "--penalties",
        penalties,
        "--out",
        tmp_path / "out",
    )
    assert done.exit_code == 0
    assert f'"penalties": "{penalties}"' in (tmp_path / "out" / "leaderboard.json").read_text(
        encoding="utf-8"
    )
