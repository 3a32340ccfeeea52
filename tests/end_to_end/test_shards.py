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


def array_environment(tmp_path: Path, task: int, numbers: list[int], step: int) -> dict[str, str]:
    """Return the variables that Slurm sets, and a `plant-bench` that prints its arguments."""
    command = tmp_path / "plant-bench"
    command.write_text('#!/bin/sh\necho "$@"\n')
    command.chmod(0o755)
    values = {"ID": task, "MIN": min(numbers), "MAX": max(numbers), "STEP": step}
    values["COUNT"] = len(numbers)
    return {
        **os.environ,
        **{f"SLURM_ARRAY_TASK_{name}": str(value) for name, value in values.items()},
        "PATH": os.pathsep.join([str(tmp_path), os.environ["PATH"]]),
    }


@pytest.mark.parametrize(
    ("numbers", "step"),
    [(range(1, 9), 1), (range(8), 1), (range(1, 9, 2), 2), (range(5, 6), 1), (range(0, 10, 3), 3)],
)
def test_tasks_of_an_array_drive_each_shard_once(tmp_path, numbers, step):
    said = [
        subprocess.run(
            [str(SCRIPT), "--agent", "x"],
            env=array_environment(tmp_path, task, list(numbers), step),
            capture_output=True,
            text=True,
            check=True,
        ).stdout
        for task in numbers
    ]
    count = len(numbers)
    assert said == [
        f"score --shard {shard}/{count} --workers 1 --agent x\n" for shard in range(1, count + 1)
    ]


@pytest.mark.parametrize("step", [1, 3])
@pytest.mark.parametrize("task", [1, 4, 9])
def test_array_that_is_no_range_is_refused(tmp_path, task, step):
    done = subprocess.run(
        [str(SCRIPT), "--agent", "x"],
        env=array_environment(tmp_path, task, [1, 4, 9], step),
        capture_output=True,
        text=True,
        check=False,
    )
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr == (
        "slurm_array.sh: expected one range such as --array=1-8 or --array=1-15:2, got 3 tasks "
        f"from 1 to 9 with step {step}.\n"
    )


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
