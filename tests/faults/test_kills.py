"""Runs killed at random instants end with the same bytes as an undisturbed one."""

import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
pytestmark = pytest.mark.sumo


@pytest.mark.parametrize("kills", [2, pytest.param(200, marks=pytest.mark.slow)])
def test_killed_runs_neither_lose_duplicate_nor_change_records(kills: int, tmp_path: Path) -> None:
    command = [sys.executable, str(ROOT / "benchmarks" / "kills.py"), "--kills", str(kills)]

    done = subprocess.run(
        [*command, "--routes", "2"], cwd=tmp_path, capture_output=True, text=True, check=False
    )

    assert done.returncode == 0, done.stdout + done.stderr
    assert "0 lost, 0 duplicated, 0 differing records; 0 other faults" in done.stdout
