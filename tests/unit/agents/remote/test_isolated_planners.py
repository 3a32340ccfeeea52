"""Isolated planners: well-behaved ones, and those that misbehave."""

import os
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from plant_bench.agent import Cause, Control, Observation, Plan, Ranker, Reason
from plant_bench.agent_check import check_action
from plant_bench.agents.loading.checksum import agent_checksum, agent_files
from plant_bench.agents.loading.registry import load_agent
from plant_bench.agents.remote.launch_command import launch_command_of
from plant_bench.agents.remote.planner_connection import end_processes
from plant_bench.agents.remote.process import Limits
from plant_bench.agents.remote.remote_agent import remote_agent
from plant_bench.errors import AgentError, InputError
from plant_bench.inference_timing import listen_to_passes
from plant_bench.runner.workers.isolation import isolation_of, loader_of
from plant_bench.world.scene import Actors, EgoState

pytestmark = pytest.mark.skipif(not sys.platform.startswith("linux"), reason="watched in /proc")
HOSTILE = Path(__file__).with_name("hostile.py")
LIMITS = Limits(tick=60.0, start_up=60.0, memory=0.25)
SHORT = Limits(tick=0.5, start_up=60.0, memory=0.25)
EGO = EgoState(0.0, 0.0, 0.0, 5.0)


@pytest.fixture(autouse=True)
def no_process_is_left():
    yield
    end_processes()


@pytest.fixture
def processes(tmp_path, monkeypatch):
    """Return the processes whose ids planners have written."""
    told = tmp_path / "pids"
    told.touch()
    monkeypatch.setenv("HOSTILE_PIDS", str(told))
    return lambda: [int(line) for line in told.read_text().split()]


def planner(name, limits=LIMITS):
    return remote_agent(launch_command_of(f"{HOSTILE}:{name}"), limits)


def drive(agent, decisions=4):
    agent.reset(None)
    return [check_action(agent.act(Observation(0.0, EGO, 8.0))) for _ in range(decisions)]


def all_gone(processes, patience=10.0):
    deadline = time.monotonic() + patience
    while any(Path(f"/proc/{process}").exists() for process in processes):
        if time.monotonic() > deadline:
            return False
        time.sleep(0.02)
    return True


@pytest.mark.parametrize(
    ("name", "error", "reason"),
    [
        ("Hangs", "TimeLimitError", "no response within 0.5 s (--tick-limit)."),
        ("Leaks", "MemoryLimitError", "it uses more than 0.25 GB (--memory-limit)."),
        ("LeaksInAChild", "MemoryLimitError", "it uses more than 0.25 GB (--memory-limit)."),
        ("WantsAll", "MemoryLimitError", "it uses more than 0.25 GB (--memory-limit)."),
        ("Segfaults", "ProcessEndedError", "its process was ended by SIGSEGV."),
        ("ExitsAtOnce", "ProcessEndedError", "its process ended with exit code 3."),
        ("DiesAtReset", "ProcessEndedError", "its process ended with exit code 5."),
        ("Exits", "SystemExit", "4"),
        ("Raises", "ValueError", "no way out of <object object at 0x...> (hostile.py:75)"),
        ("ClosesItsPipe", "ProcessEndedError", "it has closed its pipe."),
        ("AnswersGarbage", "ProtocolError", "it sent more than one response"),
        ("AnnouncesTooMuch", "ProtocolError", "it announced a message of more than"),
        ("PrintsForEver", "TimeLimitError", "no response within 0.5 s (--tick-limit)."),
        ("AnswersNaN", "AgentError", "expected finite numbers"),
        ("AnswersNothing", "AgentError", "expected a Plan or a Control"),
    ],
)
def test_misbehaving_planner_is_ended_with_a_reason(name, error, reason):
    with pytest.raises(AgentError) as caught:
        drive(planner(name, SHORT if error == "TimeLimitError" else LIMITS))

    assert type(caught.value).__name__ == error
    assert reason in str(caught.value)


def test_printed_output_is_kept_up_to_a_limit(capfd):
    with pytest.raises(AgentError):
        drive(planner("PrintsForEver", SHORT))
    end_processes()

    printed = capfd.readouterr().err
    assert 200_000 < len(printed) < 300_000
    assert "the rest is dropped" in printed


def test_well_behaved_planners_reuse_a_process(processes):
    drives = [drive(planner("Good")) for _ in range(2)]

    assert drives[0] == drives[1] == drive(load_agent(f"{HOSTILE}:Good"))


def test_planner_drives_after_another_one_failed():
    agent = planner("ByRoute")
    with pytest.raises(AgentError, match="AttributeError|NoneType"):
        agent.reset(None)

    assert len(drive(planner("Good"))) == 4


def test_isolated_planner_keeps_interval_reason_and_ranks():
    agent, passes = planner("Explains"), listen_to_passes()
    seen = Observation(0.0, EGO, 8.0, actors=Actors.none())

    assert agent.interval == 3
    (*_, plan) = drive(agent, 3)

    assert isinstance(plan, Plan)
    assert np.array_equal(plan.waypoints, np.ones((4, 2)))
    assert agent.interval == 7
    assert agent.explain() == Reason(Cause.LEADER, 11)
    assert [item.tokens for item in passes] == [5]
    assert isinstance(agent, Ranker)
    assert agent.rank(seen).shape == (0,)
    assert not isinstance(planner("Good"), Ranker)


def test_daemons_of_a_planner_are_killed_with_it(processes):
    with pytest.raises(AgentError, match="exit code 0"):
        drive(planner("LeavesADaemon"))

    assert len(processes()) == 1
    assert all_gone(processes())


def test_killed_worker_leaves_no_planner_process(processes):
    code = (
        "from plant_bench.agent import Observation\n"
        "from plant_bench.world.scene import EgoState\n"
        "from plant_bench.agents.remote.remote_agent import remote_agent\n"
        "from plant_bench.agents.remote.launch_command import launch_command_of\n"
        "from plant_bench.agents.remote.process import Limits\n"
        f"agent = remote_agent(launch_command_of('{HOSTILE}:HangsWithADaemon'), Limits(600.0))\n"
        "agent.reset(None)\n"
        "for _ in range(3): agent.act(Observation(0.0, EgoState(0.0, 0.0, 0.0, 0.0), 8.0))\n"
    )
    worker = subprocess.Popen([sys.executable, "-c", code])
    deadline = time.monotonic() + 60.0
    while len(processes()) < 2 and time.monotonic() < deadline:
        time.sleep(0.02)
    os.kill(worker.pid, signal.SIGKILL)
    worker.wait()

    assert len(processes()) == 2
    assert all_gone(processes())


def test_isolation_does_not_change_the_checksum(tmp_path):
    spec = f"{shutil.copy(HOSTILE, tmp_path)}:Good"
    within = agent_files(spec)
    isolation = isolation_of(spec, LIMITS)
    assert agent_files(spec, loader_of(isolation)) == within
    assert agent_checksum(spec, loader_of(isolation)) == agent_checksum(spec)
    assert isinstance(loader_of(isolation)(spec).act, type(planner("Good").act))
    assert drive(isolation.planner(spec), 1) == [Control(1.0, 0.0)]


@pytest.mark.parametrize(
    ("spec", "message"),
    [
        (f"{HOSTILE}:Goood", "Did you mean 'Good'"),
        ("expart", "Did you mean 'expert'"),
        ("command:", "Expected a program"),
        ("command:'", "is not a valid command"),
        ("command:./no_such_program", "does not exist"),
        (f"command:{HOSTILE}", "is not executable"),
        ("command:true", "does not start: ProcessEndedError: its process ended with exit code 0"),
        ("command:echo hello", "does not start: ProtocolError"),
    ],
)
def test_planner_that_does_not_start_raises_input_error(spec, message):
    with pytest.raises(InputError, match=message):
        isolation_of(spec, LIMITS)


@pytest.mark.slow
def test_leaking_planner_is_ended_at_its_memory_limit():
    with pytest.raises(AgentError, match="more than 10 GB"):
        drive(planner("Leaks", Limits(tick=300.0, memory=10.0)))
