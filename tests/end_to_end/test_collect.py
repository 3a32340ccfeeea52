"""Data collection by the command line, with SUMO: resumed, described, and with a broken file."""

import json
import os
import subprocess
import sys

import pytest

from plant_bench.data.recording import Recording
from plant_bench.towns.training_routes import MAX_COMMON
from plant_bench.world.route import load_suite
from tests.unit.towns.common_ways import common_share

pytestmark = pytest.mark.sumo


def plant_bench(*arguments, cwd, code=0):
    done = subprocess.run(
        [sys.executable, "-m", "plant_bench", *arguments],
        cwd=cwd,
        env=os.environ | {"NO_COLOR": "1", "TERM": "dumb", "COLUMNS": "200"},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == code, done.stdout + done.stderr
    return done.stdout + done.stderr


def collect(frames, place, *more):
    asked = ["--frames", str(frames), "--density", "light", "--perturb", "1", *more]
    return plant_bench("collect", "--out", "data", *asked, cwd=place)


@pytest.fixture(scope="module")
def place(tmp_path_factory):
    """A folder with about 200 frames."""
    folder = tmp_path_factory.mktemp("place")
    collect(200, folder, "--workers", "2")
    return folder


def episodes(place):
    return {path.name: path.read_bytes() for path in (place / "data" / "episodes").iterdir()}


def test_collect_reaches_the_requested_number_of_frames(place):
    frames = 0
    for path in sorted((place / "data" / "episodes").iterdir()):
        recording = Recording.load(path)
        frames += len(recording.complete_rows)
        assert recording.complete_rows == list(range(0, len(recording), 10))
        assert recording.metadata["agent"] == "expert"
        assert recording.disturbed.mean() < 0.2
    summary = json.loads((place / "data" / "data.json").read_text())
    assert frames >= 200
    assert summary["data"]["frames"] == frames
    assert f"{frames} frames at 2 Hz" in (place / "data" / "README.md").read_text()


def test_collected_frames_are_never_from_benchmark_routes(place):
    routes = {route.id: route for route in load_suite(str(place / "data" / "routes"))}
    for path in (place / "data" / "episodes").iterdir():
        route = routes[str(Recording.load(path).metadata["route"])]
        assert common_share(route) <= MAX_COMMON


def test_repeated_collect_resumes_where_it_stopped(place):
    before = episodes(place)
    assert "Nothing to drive" in collect(200, place)

    there = json.loads((place / "data" / "data.json").read_text())["data"]["frames"]
    said = collect(there + 20, place, "--workers", "1")

    after = episodes(place)
    assert "Driven: " in said
    assert before.items() < after.items()
    assert "valid" in plant_bench("data", "check", "data", cwd=place)


def test_data_is_described_and_a_broken_file_is_reported(place):
    assert "frames at 2 Hz" in plant_bench("data", "describe", "data", cwd=place)
    assert len(list((place / "data" / "plots").glob("*.png"))) == 6

    path = min((place / "data" / "episodes").iterdir(), key=lambda path: path.stat().st_size)
    whole = path.read_bytes()
    path.write_bytes(whole[: len(whole) // 2])
    said = plant_bench("data", "check", "data", cwd=place, code=2)
    assert said.count("plant-bench:") == 1
    assert path.name in said
    path.unlink()
    collect(200, place)
    assert path.read_bytes() == whole


def test_driver_option_is_recorded_in_the_data(tmp_path):
    asked = ["--out", "own", "--frames", "30", "--density", "light", "--driver", "idm"]
    plant_bench("collect", *asked, "--workers", "1", cwd=tmp_path)
    recordings = [Recording.load(path) for path in sorted((tmp_path / "own/episodes").iterdir())]
    assert all(recording.metadata["agent"] == "expert" for recording in recordings)
    assert sum(recording.disturbed.sum() for recording in recordings) > 0
    card = (tmp_path / "own" / "README.md").read_text()
    assert "`idm` drove" in card
    assert "--driver idm`" in card
    said = plant_bench("data", "describe", "own", "--no-plots", cwd=tmp_path)
    assert "`idm` drove" in said
    assert "expert actions, not drives" in said
    said = plant_bench("collect", *asked[:-2], cwd=tmp_path, code=2)
    assert "another origin (driver idm" in said


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["collect", "--out", "x", "--units", "1", "--frames", "5"], "give one of them"),
        (["collect", "--out", "x", "--frames", "5", "--density", "thick"], "no density 'thick'"),
        (["collect", "--out", "x", "--driver", "sumo"], "its inputs include simulator"),
        (["data", "describe", "nowhere"], "There is no data in nowhere"),
        (["data", "check", "nowhere"], "There is no data in nowhere"),
    ],
)
def test_unusable_input_gives_one_message(arguments, words, tmp_path):
    said = plant_bench(*arguments, cwd=tmp_path, code=2)
    assert words in said
    assert "Traceback" not in said
    assert not (tmp_path / "x").exists()
