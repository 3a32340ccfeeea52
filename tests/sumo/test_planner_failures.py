"""Complete runs with planners that fail, change the working folder or leave threads behind."""

import json
import os
import subprocess
import sys

import pytest

from plant_bench.world.route import ROUTE_FORMAT
from tests.shortened import first_metres

pytestmark = pytest.mark.sumo
METRES = 25
PLANNER = '''
import multiprocessing
import os
import threading

from plant_bench.agent import Control, Input

class Mine:
    """Does at its third decision, or in `reset`, what the route's name says."""

    inputs = frozenset({Input.ROUTE})

    def __init__(self):
        os.chdir("away")
        threading.Thread(target=threading.Event().wait).start()

    def reset(self, route):
        self.kind, self.decisions = route.id.partition("-")[0], 0
        if self.kind == "moves":
            os.chdir("/")
        if self.kind == "pools":
            multiprocessing.Pool(1)  # line 22

    def act(self, observation):
        self.decisions += 1
        if self.decisions == 3 and self.kind == "raises":
            raise ValueError("my mistake")  # line 27
        if self.decisions == 3 and self.kind == "exits":
            os._exit(3)
        if self.decisions == 3:
            os.chdir("/")
        return Control(1.0, 0.0)
'''


def write_suite(path, names):
    routes = [first_metres(METRES, name).to_payload() for name in names]
    path.write_text(json.dumps({"format": ROUTE_FORMAT, "routes": routes}), encoding="utf-8")


def score(folder, *more):
    words = ["score", "--agent", "mine.py:Mine", "--suite", "suite.json", "--repetitions", "1"]
    words += ["--density", "light", "--workers", "1"]
    return subprocess.run(
        [sys.executable, "-m", "plant_bench", *words, *more],
        cwd=folder,
        env=os.environ | {"NO_COLOR": "1", "TERM": "dumb", "COLUMNS": "400"},
        capture_output=True,
        text=True,
        timeout=280,
        check=False,
    )


def reasons(run):
    records = [json.loads(path.read_text()) for path in sorted((run / "episodes").iterdir())]
    return {record["route"]: (record["status"], record["reason"]) for record in records}


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "mine.py").write_text(PLANNER)
    (tmp_path / "away").mkdir()
    return tmp_path


def test_failures_say_where_and_side_effects_harm_no_other_episode(folder):
    write_suite(folder / "suite.json", ["raises", "pools", "exits", "moves"])

    done = score(folder)

    run = folder / "reports" / "mine.py_Mine-suite-light"
    found = reasons(run)
    assert done.returncode == 2, done.stderr
    crashed = "Failed - Agent crashed"
    assert found["raises"] == (crashed, "act raised ValueError: my mistake (mine.py:27)")
    assert found["pools"][1].startswith("reset raised AssertionError: daemonic processes are not")
    assert found["pools"][1].endswith("`plant-bench score --isolate` allows them (mine.py:22)")
    assert found["exits"] == (crashed, "The worker process ended with exit code 3.")
    assert found["moves"][1] == ""
    assert len(list((run / "recordings").iterdir())) == 3  # of all that have not exited
    assert sorted(path.name for path in folder.iterdir()) == [
        "away",
        "mine.py",
        "reports",
        "suite.json",
    ]
    assert not list((folder / "away").iterdir())
    log = (run / "logs" / "worker0.log").read_text()
    assert 'raise ValueError("my mistake")  # line 27' in log
    last = done.stderr.strip().splitlines()[-1]
    assert last.endswith("Log: reports/mine.py_Mine-suite-light/logs/worker0.log")
    assert "Traceback" not in done.stdout + done.stderr


def test_planner_that_ends_its_worker_is_told_to_isolate(folder):
    write_suite(folder / "suite.json", ["exits"])

    done = score(folder, "--out", "run")

    assert done.returncode == 2
    last = done.stderr.strip().splitlines()[-1]
    assert last.endswith(
        "The worker process ended with exit code 3. If the planner ended it (os._exit), use "
        "--isolate. Log: run/logs"
    )


def test_isolated_planner_may_change_the_working_folder_and_start_processes(folder):
    write_suite(folder / "suite.json", ["raises", "pools", "moves"])

    done = score(folder, "--out", "run", "--isolate")

    found = reasons(folder / "run")
    assert found["raises"][1] == "act raised ValueError: my mistake (mine.py:27)"
    assert found["pools"][1] == found["moves"][1] == ""
    log = (folder / "run" / "logs" / "worker0.log").read_text()
    assert 'raise ValueError("my mistake")  # line 27' in log
    last = done.stderr.strip().splitlines()[-1]
    assert last.endswith("(mine.py:27). Log: run/logs/worker0.log")
