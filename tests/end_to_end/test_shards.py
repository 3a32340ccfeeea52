"""Array tasks that write into one folder concurrently, as examples/slurm_array.sh starts them."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
SCRIPT = ROOT / "examples" / "slurm_array.sh"
pytestmark = [
    pytest.mark.sumo,
    pytest.mark.skipif(os.name != "posix", reason="the script is for bash"),
]
WANTED = ["--agent", "cruise", "--routes", "3-4", "--repetitions", "1", "--density", "light"]


@pytest.fixture
def path_to_command(tmp_path) -> str:
    """A search path on which `plant-bench` is the one under test."""
    command = tmp_path / "bin" / "plant-bench"
    command.parent.mkdir()
    command.write_text(f'#!/bin/sh\nexec {sys.executable} -m plant_bench "$@"\n')
    command.chmod(0o755)
    return os.pathsep.join([str(command.parent), os.environ["PATH"]])


def contents(folder: Path) -> dict[str, bytes]:
    names = [
        *(path for part in ("episodes", "recordings") for path in (folder / part).iterdir()),
        folder / "summary.json",
        folder / "summary.csv",
    ]
    return {path.name: path.read_bytes() for path in names}


def test_two_concurrent_shards_equal_one_command(tmp_path, path_to_command):
    subprocess.run(["bash", "-n", str(SCRIPT)], check=True)
    array = {"SLURM_ARRAY_TASK_MIN": "0", "SLURM_ARRAY_TASK_COUNT": "2", "PATH": path_to_command}
    tasks = [
        subprocess.Popen(
            [str(SCRIPT), *WANTED, "--out", "shared"],
            cwd=tmp_path,
            env=os.environ | array | {"SLURM_ARRAY_TASK_ID": str(number)},
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
        )
        for number in range(2)
    ]
    said = [task.communicate(timeout=240)[0] for task in tasks]
    assert [task.returncode for task in tasks] == [0, 0], said

    plain = [sys.executable, "-m", "plant_bench", "score", *WANTED, "--out", "plain"]
    subprocess.run([*plain, "--workers", "2"], cwd=tmp_path, check=True, capture_output=True)

    assert contents(tmp_path / "shared") == contents(tmp_path / "plain")
    assert not (tmp_path / "shared" / "claims").exists()
    assert not list((tmp_path / "shared").rglob("*.part"))
