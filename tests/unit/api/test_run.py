"""A run from `load_run`, compared with the command line's output for the same folder."""

from pathlib import Path

import pytest
from typer.testing import CliRunner

import plant_bench as pb
from plant_bench.cli import app
from plant_bench.scoring.comparison import PairedDifference
from plant_bench.scoring.penalties import PenaltyScheme
from tests.conftest import RunWriter

COLUMNS = ["agent", "town", "route", "repetition", "seed", "status", "driving_score"]
COLUMNS += ["route_completion", "infraction_score", "collision_vehicle", "red_light", "reason"]


def test_summary_is_computed_from_the_records(tmp_path: Path, write_run: RunWriter) -> None:
    run = pb.load_run(write_run(tmp_path / "a", "mine"))

    summary = run.summary
    assert (summary.planner, summary.episodes, summary.penalties) == ("mine", 12, "lb1.0")
    assert summary.driving_score == summary.whole.scores["driving_score"].mean
    assert summary.driving_score == pytest.approx(run.episodes["driving_score"].mean())
    assert "whole" not in repr(summary)


def test_episodes_have_one_row_each(tmp_path: Path, write_run: RunWriter) -> None:
    run = pb.load_run(str(write_run(tmp_path / "a")))

    frame = run.episodes
    assert len(frame) == 12
    assert set(COLUMNS) <= set(frame.columns)
    assert set(frame["collision_vehicle"]) == {0, 1}


@pytest.mark.parametrize("penalties", ["lb1.0", "lb2.1"])
def test_compare_equals_the_command(
    tmp_path: Path, write_run: RunWriter, monkeypatch: pytest.MonkeyPatch, penalties: str
) -> None:
    base = write_run(tmp_path / "a", "base", routes=12)
    new = write_run(tmp_path / "b", "new", routes=12, worse=40, checksum="b" * 64)
    said: list[PairedDifference] = []

    def say(
        difference: PairedDifference, *_names: str, penalties: PenaltyScheme, routes: int | None
    ) -> None:
        del penalties, routes
        said.append(difference)

    monkeypatch.setattr("plant_bench.reports.comparison_table.print_difference", say)
    done = CliRunner().invoke(app, ["compare", str(base), str(new), "--penalties", penalties])

    assert done.exit_code == 0
    run = pb.load_run(new, penalties=penalties)
    assert run.compare(base) == run.compare(pb.load_run(base)) == said[0]
    assert said[0].mean > 0


def test_report_covers_several_runs(tmp_path: Path, write_run: RunWriter) -> None:
    runs = [write_run(tmp_path / name, name, checksum=name * 64) for name in ("a", "b")]

    page = pb.load_run(runs[0]).report(runs[1], out=tmp_path / "out")

    assert page == tmp_path / "out" / "leaderboard.html"
    assert page.is_file()


def test_why_is_empty_without_infractions(tmp_path: Path, write_run: RunWriter) -> None:
    run = pb.load_run(write_run(tmp_path / "a", worse=100, routes=2))
    for path in (run.path / "episodes").glob("*_r0_00000000.json"):
        path.unlink()  # the only one with a collision

    assert run.why() == []


def test_why_refuses_an_episode_without_a_recording(tmp_path: Path, write_run: RunWriter) -> None:
    run = pb.load_run(write_run(tmp_path / "a"))

    with pytest.raises(pb.InputError, match="has no recording of"):
        run.why()


def test_unusable_run_folder_is_refused(tmp_path: Path, write_run: RunWriter) -> None:
    with pytest.raises(pb.InputError, match=r"nowhere is not a run of plant-bench: it has no run"):
        pb.load_run(tmp_path / "nowhere")
    with pytest.raises(pb.InputError, match=r"Unknown penalty scheme 'lb9'"):
        pb.load_run(write_run(tmp_path / "a"), penalties="lb9")
    empty = write_run(tmp_path / "b", routes=0)
    with pytest.raises(pb.InputError, match=r"no finished episode\. Continue the run"):
        pb.load_run(empty)


def test_broken_record_is_refused(tmp_path: Path, write_run: RunWriter) -> None:
    run = pb.load_run(write_run(tmp_path / "a"))
    next((run.path / "episodes").iterdir()).write_text("{")

    with pytest.raises(pb.InputError, match="Not an episode record"):
        _ = run.summary
