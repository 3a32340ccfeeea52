"""Episodes of a data folder that are there twice, missing or impossible."""

import json
import shutil
from pathlib import Path

import pytest
from typer.testing import CliRunner

from plant_bench.cli import app
from plant_bench.data.completeness import incompleteness
from plant_bench.data.recorder import Recorder
from plant_bench.data.statistics import episode_files, find_data_faults
from plant_bench.errors import InputError
from tests.builders import make_ego, make_scene, straight_route


def record(path: Path, *, speed: float = 10.0, jump: float = 0.0) -> None:
    """21 ticks on route "one"; the ego jumps at tick 7."""
    recorder = Recorder(path, {"route": "one", "scenario": f"scenario of {path.stem}"}, every=10)
    for tick in range(21):
        x = tick * 0.05 * speed + (jump if tick >= 7 else 0.0)
        recorder.add(make_scene(tick, ego=make_ego(speed, x=x)))
    recorder.close()


@pytest.fixture
def data(tmp_path: Path) -> Path:
    folder = tmp_path / "data"
    for name in ("episodes", "records", "routes"):
        (folder / name).mkdir(parents=True)
    routes = [straight_route(name="one").to_payload()]
    (folder / "routes" / "a.json").write_text(json.dumps({"format": 1, "routes": routes}))
    for name in "abc":
        record(folder / "episodes" / f"{name}.parquet")
        note(folder, name)
    note(folder, "excluded", "collision")
    (folder / "data.json").write_text(json.dumps({"data": {"episodes": 3}}))
    return folder


def note(folder: Path, name: str, left_out: str = "") -> None:
    (folder / "records" / f"{name}.json").write_text(json.dumps({"left_out": left_out}))


def problems(folder: Path) -> list[str]:
    return incompleteness(folder, episode_files(folder))


def test_complete_data_has_no_problem(data: Path) -> None:
    assert problems(data) == []


def test_copy_of_an_episode_is_found(data: Path) -> None:
    shutil.copy(data / "episodes" / "b.parquet", data / "episodes" / "b_copy.parquet")

    (text,) = problems(data)
    assert (
        "4 recordings, of which two are of the same episode: b.parquet and b_copy.parquet" in text
    )


def test_missing_episode_is_named(data: Path) -> None:
    (data / "episodes" / "b.parquet").unlink()

    (text,) = problems(data)
    assert "1 of 3 episodes that records/ and data.json tell of is missing: b." in text


def test_missing_episode_is_counted_without_records(data: Path) -> None:
    shutil.rmtree(data / "records")
    (data / "episodes" / "b.parquet").unlink()

    (text,) = problems(data)
    assert "1 of 3 episodes that data.json tells of is missing." in text


@pytest.mark.parametrize(
    ("motion", "words"),
    [({"jump": 500.0}, "jumps by 500 m at 0.35 s"), ({"speed": 400.0}, "drives at 400 m/s")],
)
def test_impossible_motion_is_found(data: Path, motion: dict[str, float], words: str) -> None:
    assert [fault for fault in find_data_faults(data) if "impossible" in fault] == []
    record(data / "episodes" / "b.parquet", **motion)

    (fault,) = [fault for fault in find_data_faults(data) if "impossible" in fault]
    assert "b.parquet: the ego" in fault
    assert words in fault


def test_check_command_refuses_incomplete_data(data: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("plant_bench.data.statistics.find_data_faults", lambda _folder: [])
    (data / "episodes" / "b.parquet").unlink()

    done = CliRunner().invoke(app, ["data", "check", str(data)])

    assert isinstance(done.exception, InputError)
    assert "is missing: b." in str(done.exception)
