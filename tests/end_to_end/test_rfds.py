"""`plant-bench rfds` with SUMO: ordinary runs are compared, and a repeat drives nothing."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

pytestmark = pytest.mark.sumo
RANKERS = ["--ranker", "distance", "--ranker", "none"]
ROUTES = ["--routes", "town02-5", "--repetitions", "2", "--density", "light", "--workers", "1"]


def rfds(cwd: Path) -> str:
    done = subprocess.run(
        [sys.executable, "-m", "plant_bench", "rfds", *RANKERS, *ROUTES, "--out", "runs"],
        cwd=cwd,
        env=os.environ | {"NO_COLOR": "1", "TERM": "dumb"},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def test_rfds_runs_are_scored_as_ordinary_runs_and_resume(tmp_path: Path) -> None:
    said = rfds(tmp_path)
    assert "distance" in said
    runs = {name: tmp_path / "runs" / name for name in ("expert", "distance", "none")}
    agents = {
        name: {json.loads(path.read_text())["agent"] for path in (run / "episodes").glob("*.json")}
        for name, run in runs.items()
    }
    assert agents == {
        "expert": {"expert"},
        "distance": {"expert-filtered@distance"},
        "none": {"expert-filtered@none"},
    }
    scores = json.loads((runs["none"] / "rfds.json").read_text())
    whole = json.loads((runs["expert"] / "summary.json").read_text())["scores"]
    filtered = json.loads((runs["none"] / "summary.json").read_text())["scores"]
    assert scores["episodes"] == 2
    assert scores["whole"]["mean"] == pytest.approx(whole["driving_score"]["mean"])
    assert scores["filtered"]["mean"] == pytest.approx(filtered["driving_score"]["mean"])

    before = {path: path.stat().st_mtime_ns for path in tmp_path.rglob("episodes/*.json")}
    assert rfds(tmp_path) == said
    assert {path: path.stat().st_mtime_ns for path in before} == before
