"""Complete runs with isolated planners: misbehaving ones among others, and one in C++."""

import json
import os
import shutil
import signal
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path

import pytest

from plant_bench.api.planner_project import Kind, write_project
from plant_bench.world.route import ROUTE_FORMAT, load_suite

pytestmark = [
    pytest.mark.sumo,
    pytest.mark.skipif(not sys.platform.startswith("linux"), reason="watched in /proc"),
]
ROOT = Path(__file__).parents[2]
HOSTILE = ROOT / "tests" / "unit" / "agents" / "remote" / "hostile.py"
REASONS = {
    "Hangs": "act raised TimeLimitError: no response within 8 s (--tick-limit).",
    "Leaks": "act raised MemoryLimitError: it uses more than 0.25 GB (--memory-limit).",
    "Segfaults": "act raised ProcessEndedError: its process was ended by SIGSEGV.",
    "ExitsAtOnce": "act raised ProcessEndedError: its process ended with exit code 3.",
    "Raises": "act raised ValueError: no way out of <object object at 0x...> (hostile.py:75)",
    "AnswersNaN": "act: expected finite numbers, got Control(acceleration=nan, steering=0.0).",
    "ClosesItsPipe": "act raised ProcessEndedError: it has closed its pipe.",
    "AnswersGarbage": "act raised ProtocolError: it sent more than one response, or sent before "
    "the request.",
}


def suite(path, names, metres=25):
    """Write a suite of short routes, one for each name."""
    whole = load_suite("longest6")[6]
    cut = slice(metres + 1)
    routes = [
        replace(
            whole,
            id=f"{name}-{number}",
            points=whole.points[cut],
            elevations=whole.elevations[cut],
            speed_limits=whole.speed_limits[cut],
            passages=tuple(passage for passage in whole.passages if passage.exit < metres - 1),
            hazards=(),
        )
        for number, name in enumerate(names)
    ]
    payload = {"format": ROUTE_FORMAT, "routes": [route.to_payload() for route in routes]}
    path.write_text(json.dumps(payload), encoding="utf-8")
    return path


def start(folder, agent, out, *more):
    words = ["score", "--agent", agent, "--suite", "suite.json", "--repetitions", "1"]
    return subprocess.Popen(
        [sys.executable, "-m", "plant_bench", *words, "--density", "light", "--out", out, *more],
        cwd=folder,
        env=os.environ | {"NO_COLOR": "1", "TERM": "dumb", "HOSTILE_PIDS": str(folder / "pids")},
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        start_new_session=True,
    )


def score(*arguments):
    run = start(*arguments)
    said, _ = run.communicate(timeout=280)
    return run.returncode, said


def records(run):
    return {path.name.partition("_")[0]: path for path in sorted((run / "episodes").iterdir())}


def test_misbehaving_isolated_planners_affect_only_their_own_episodes(tmp_path):
    agent = f"{shutil.copy(HOSTILE, tmp_path)}:ByRoute"
    suite(tmp_path / "suite.json", ["Good", *REASONS, "Good"])
    limits = ("--isolate", "--tick-limit", "8", "--memory-limit", "0.25", "--workers", "2")

    code, said = score(tmp_path, agent, "isolated", *limits)
    clean, _ = score(tmp_path, agent, "clean", "--routes", f"0,{len(REASONS) + 1}")

    assert code == 2, said
    assert clean == 0
    assert "Traceback" not in said
    found = {
        name: json.loads(path.read_text()) for name, path in records(tmp_path / "isolated").items()
    }
    bad = {name.partition("-")[0]: record for name, record in found.items()}
    assert {name: bad[name]["reason"] for name in REASONS} == REASONS
    assert {bad[name]["status"] for name in REASONS} == {"Failed - Agent crashed"}
    for part in ("episodes", "recordings"):
        for path in sorted((tmp_path / "clean" / part).iterdir()):
            assert path.read_bytes() == (tmp_path / "isolated" / part / path.name).read_bytes()
    assert len(records(tmp_path / "clean")) == 2
    logs = "".join(path.read_text() for path in (tmp_path / "isolated" / "logs").iterdir())
    assert logs.count('raise ValueError(f"no way out of {object()}")') == 1  # its traceback
    assert "Log: isolated/logs/worker" in said.splitlines()[-1]


def test_ctrl_c_ends_all_planner_processes(tmp_path):
    told = tmp_path / "pids"
    told.touch()
    suite(tmp_path / "suite.json", ["HangsWithADaemon"])
    run = start(tmp_path, f"{HOSTILE}:ByRoute", "run", "--isolate", "--tick-limit", "600")
    deadline = time.monotonic() + 60.0
    while len(told.read_text().split()) < 2 and time.monotonic() < deadline:
        time.sleep(0.05)

    os.killpg(run.pid, signal.SIGINT)
    said, _ = run.communicate(timeout=30)

    processes = told.read_text().split()
    assert len(processes) == 2, said
    assert run.returncode == 130, said
    deadline = time.monotonic() + 10.0
    while any(Path("/proc", process).exists() for process in processes):
        assert time.monotonic() < deadline
        time.sleep(0.02)


@pytest.mark.skipif(shutil.which("g++") is None, reason="no C++ compiler")
def test_cpp_example_drives_a_route(tmp_path):
    source = ROOT / "examples" / "my_planner.cpp"
    build = ["g++", "-O1", "-std=c++17", "-o", tmp_path / "my_planner", source]
    subprocess.run(build, check=True)
    suite(tmp_path / "suite.json", ["short"], metres=120)

    code, said = score(tmp_path, "command:./my_planner 8", "run")

    assert code == 0, said
    (record,) = records(tmp_path / "run").values()
    assert json.loads(record.read_text())["status"] == "Completed"


def test_limits_without_isolate_are_refused(tmp_path):
    code, said = score(tmp_path, "cruise", "run", "--tick-limit", "3")

    assert code == 2
    assert "--tick-limit requires --isolate: it limits a planner in a separate process." in said


@pytest.mark.parametrize("kind", list(Kind))
def test_project_of_new_agent_passes_its_own_test(tmp_path, kind):
    project = write_project("my_planner", tmp_path, kind)

    done = subprocess.run(
        [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider"],
        cwd=project.folder,
        capture_output=True,
        text=True,
        check=False,
    )

    assert done.returncode == 0, done.stdout
