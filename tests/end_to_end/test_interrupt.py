"""Ctrl-C during a run, sent as a terminal does: to the command and all of its workers."""

import os
import signal
import subprocess
import sys
import time

import pytest

pytestmark = [
    pytest.mark.sumo,
    pytest.mark.skipif(os.name != "posix", reason="process groups are POSIX"),
]
SCORE = ["score", "--agent", "cruise", "--routes", "3-5,9-11", "--repetitions", "1", "--out", "run"]


def start(cwd):
    return subprocess.Popen(
        [sys.executable, "-m", "plant_bench", *SCORE, "--density", "light", "--workers", "2"],
        cwd=cwd,
        env=os.environ | {"NO_COLOR": "1", "TERM": "dumb"},
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        start_new_session=True,
    )


def test_run_interrupted_by_ctrl_c_resumes_without_loss(tmp_path):
    episodes = tmp_path / "run" / "episodes"
    first = start(tmp_path)
    deadline = time.monotonic() + 120
    while not list(episodes.glob("*.json")) and time.monotonic() < deadline:
        time.sleep(0.05)
    os.killpg(first.pid, signal.SIGINT)
    said, _ = first.communicate(timeout=30)
    kept = {path.name: path.read_bytes() for path in episodes.iterdir()}

    assert first.returncode == 130, said
    assert f"{len(kept)} of 6 episodes are finished" in said
    assert "Traceback" not in said
    assert 1 <= len(kept) < 6

    again, _ = start(tmp_path).communicate(timeout=240)

    done = {path.name: path.read_bytes() for path in episodes.iterdir()}
    assert len(done) == 6, again
    assert kept.items() <= done.items()
    assert sorted(path.name for path in (tmp_path / "run" / "timing").iterdir()) == sorted(done)
