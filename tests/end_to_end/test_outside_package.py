"""An external package with an agent and a learner is trained, scored and verified."""

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
pytestmark = [pytest.mark.sumo, pytest.mark.slow]

METADATA = "Metadata-Version: 2.1\nName: their-pixels\nVersion: 1.0\n"
ENTRIES = """
[plant_bench.agents]
their-pixels = their_pixels.pixels:Pixels

[plant_bench.learners]
their-pixels = their_pixels.pixels:PixelLearner
"""


@pytest.fixture
def installed(tmp_path: Path) -> Path:
    """A folder with an installed package that has an agent and a learner on rasters."""
    package = tmp_path / "site" / "their_pixels"
    package.mkdir(parents=True)
    (package / "__init__.py").write_text("")
    source = (ROOT / "tests" / "outside" / "pixels.py").read_text()
    source = source.replace(
        'agent = f"{Path(__file__).resolve()}:Pixels"', 'agent = "their-pixels"'
    )
    (package / "pixels.py").write_text(source)
    about = tmp_path / "site" / "their_pixels-1.0.dist-info"
    about.mkdir()
    (about / "METADATA").write_text(METADATA)
    (about / "entry_points.txt").write_text(ENTRIES)
    return tmp_path


def plant_bench(place: Path, *words: str, code: int = 0) -> str:
    paths = [str(place / "site"), str(ROOT), os.environ.get("PYTHONPATH", "")]
    done = subprocess.run(
        [sys.executable, "-m", "plant_bench", *words],
        cwd=place,
        env=os.environ | {"PYTHONPATH": os.pathsep.join(paths), "COLUMNS": "200"},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == code, done.stdout + done.stderr
    return done.stdout + done.stderr


def test_installed_learner_trains_scores_and_is_verified(installed: Path) -> None:
    before = {path: path.stat().st_mtime_ns for path in (ROOT / "plant_bench").rglob("*.py")}
    collecting = ["--frames", "200", "--density", "light", "--workers", "2"]
    plant_bench(installed, "collect", "--out", "data", *collecting)
    training = ["--epochs", "1", "--batch", "16", "--held-out", "0", "--accelerator", "cpu"]
    plant_bench(
        installed, "train", "their-pixels", "--data", "data", "--out", "model", *training,
        "--loaders", "1", "--full-precision",
    )  # fmt: skip
    assert json.loads((installed / "model" / "config.json").read_text())["network"] == "pixels"

    agent = "their-pixels@model"
    driving = ["--routes", "town01-5", "--repetitions", "1", "--density", "light"]
    plant_bench(installed, "score", "--agent", agent, *driving, "--workers", "1", "--out", "run")
    (record,) = (installed / "run" / "episodes").glob("*.json")
    assert "crashed" not in json.loads(record.read_text())["status"]
    told = plant_bench(installed, "score", "--agent", agent, *driving, "--out", "run")
    assert "Nothing to drive" in told
    told = plant_bench(
        installed, "verify", "run", "--agent", agent, "--routes", "town01-5",
        "--repetitions", "1", "--sample", "1", "--workers", "1",
    )  # fmt: skip
    assert "confirmed" in told.lower()

    after = {path: path.stat().st_mtime_ns for path in (ROOT / "plant_bench").rglob("*.py")}
    assert after == before
    shutil.rmtree(installed / "run")
