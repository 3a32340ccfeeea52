import importlib
import multiprocessing
import os
import signal
import threading
import time
from functools import partial
from pathlib import Path

import pytest

from plant_bench.errors import InputError, SimulationError
from plant_bench.runner.workers import executors
from plant_bench.runner.workers.executors import (
    Event,
    Finished,
    LocalExecutor,
    Lost,
    Retried,
    Started,
    run_tasks,
)


@pytest.fixture
def scripted(monkeypatch):
    """The module that workers import by name."""
    monkeypatch.syspath_prepend(str(Path(__file__).parent))
    import scripted_work

    return scripted_work


def run(scripted, steps, *, workers=2, logs=None) -> list[Event]:
    events: list[Event] = []
    run_tasks(steps, scripted.do, workers=workers, on_event=events.append, logs=logs)
    return events


def values(events: list[Event]) -> dict[int, int]:
    return {event.task: event.value for event in events if isinstance(event, Finished)}


def test_all_tasks_return_values_from_reused_workers(scripted):
    events = run(scripted, [scripted.Step("give", value) for value in range(5)])

    assert values(events) == {task: task for task in range(5)}
    assert {event.worker for event in events if isinstance(event, Started)} <= {0, 1}


def test_tasks_start_in_the_given_order(scripted):
    events = run(scripted, [scripted.Step("give")] * 4, workers=1)

    assert [event.task for event in events if isinstance(event, Started)] == [0, 1, 2, 3]


def test_no_worker_is_started_without_tasks(scripted):
    assert run(scripted, []) == []


@pytest.mark.parametrize("act", ["exit once", "kill once", "simulation-error once", "bug once"])
def test_task_that_fails_once_is_retried(scripted, tmp_path, act):
    steps = [scripted.Step(act, 5, tmp_path / "tried"), scripted.Step("give", 6)]

    events = run(scripted, steps)

    assert values(events) == {0: 5, 1: 6}
    assert [event.task for event in events if isinstance(event, Retried)] == [0]


@pytest.mark.parametrize(
    ("act", "reason"),
    [
        ("exit", "The worker process ended with exit code 7."),
        ("kill", "The worker process was ended by SIGKILL."),
        ("simulation-error", "the ego was lost"),
        ("bug", "ZeroDivisionError: of a bug (scripted_work.py:"),
    ],
)
def test_task_that_fails_twice_is_lost_and_the_others_continue(scripted, tmp_path, act, reason):
    steps = [scripted.Step(act)] + [scripted.Step("give", 1)] * 3

    events = run(scripted, steps, logs=tmp_path)

    lost = [event for event in events if isinstance(event, Lost)]
    assert [event.task for event in lost] == [0]
    assert lost[0].reason.startswith(reason)
    assert values(events) == {1: 1, 2: 1, 3: 1}


@pytest.mark.parametrize(
    ("act", "words"), [("input-error", "no such town"), ("disk", "No space left on device")]
)
def test_error_common_to_all_tasks_ends_the_run(scripted, tmp_path, act, words):
    with pytest.raises(InputError, match=words):
        run(scripted, [scripted.Step(act), scripted.Step("sleep")], logs=tmp_path)

    assert not multiprocessing.active_children()


def test_input_error_of_a_worker_without_a_log_prints_no_traceback(scripted, capfd):
    with pytest.raises(InputError, match="no such town"):
        run(scripted, [scripted.Step("input-error")])

    assert capfd.readouterr().err == ""


def test_bug_of_a_worker_without_a_log_prints_its_traceback(scripted, capfd):
    run(scripted, [scripted.Step("bug")])

    assert "ZeroDivisionError: of a bug" in capfd.readouterr().err


def test_ctrl_c_ends_all_workers_at_once(scripted):
    timer = threading.Timer(1.5, os.kill, (os.getpid(), signal.SIGINT))
    timer.start()
    start = time.monotonic()

    with pytest.raises(KeyboardInterrupt):
        run(scripted, [scripted.Step("sleep")] * 3)

    assert time.monotonic() - start < 20
    assert not multiprocessing.active_children()


def test_workers_use_one_thread_and_the_parent_is_unchanged(scripted, monkeypatch):
    monkeypatch.setenv("OMP_NUM_THREADS", "3")

    assert values(run(scripted, [scripted.Step("threads")])) == {0: 1}
    assert os.environ["OMP_NUM_THREADS"] == "3"


def test_output_of_workers_is_in_the_log(scripted, tmp_path):
    run(scripted, [scripted.Step("print")], logs=tmp_path)

    assert (tmp_path / "worker0.log").read_text() == "seen in the log\n"


def test_workers_that_cannot_start_end_the_run(tmp_path, monkeypatch):
    (tmp_path / "gone_for_workers.py").write_text("def do(task, report):\n    return task\n")
    monkeypatch.syspath_prepend(str(tmp_path))
    work = importlib.import_module("gone_for_workers").do
    monkeypatch.undo()

    with pytest.raises(SimulationError, match="Worker processes do not start"):
        run_tasks([1], work, workers=1, on_event=lambda event: None, logs=tmp_path)

    assert not multiprocessing.active_children()


def test_standby_processes_run_the_tasks_and_end_afterwards(scripted, tmp_path):
    executor = LocalExecutor(2, partial(importlib.import_module, "no_such_module"))
    events: list[Event] = []
    with executor.connected():
        waiting = {child.pid for child in multiprocessing.active_children()}
        steps = [scripted.Step("pid")] * 4
        executor.run_tasks(
            steps, scripted.do, on_event=events.append, logs=tmp_path, save_file=lambda *_: None
        )
    assert len(values(events)) == 4
    assert set(values(events).values()) <= waiting
    assert not waiting & {child.pid for child in multiprocessing.active_children()}


def test_standby_process_has_loaded_its_modules(scripted, tmp_path):
    executor = LocalExecutor(1, partial(importlib.import_module, "http.cookies"))
    events: list[Event] = []
    with executor.connected():
        executor.run_tasks(
            [scripted.Step("known", 0, tmp_path / "told")], scripted.do, on_event=events.append,
            logs=tmp_path, save_file=lambda *_: None,
        )  # fmt: skip
    assert (tmp_path / "told").read_text() == "True"


def test_standby_processes_without_a_task_are_ended(scripted, tmp_path):
    executor = LocalExecutor(8)
    begun: list[int] = []
    with executor.connected():
        before = len(multiprocessing.active_children())
        executor.run_tasks(
            [scripted.Step("give")], scripted.do, logs=tmp_path, save_file=lambda *_: None,
            on_event=lambda _: begun.append(len(multiprocessing.active_children())),
        )  # fmt: skip
    assert (before, begun[0]) == (2, 1)


def test_death_of_a_standby_process_does_not_count_as_a_failure(scripted, tmp_path, monkeypatch):
    monkeypatch.setattr(executors, "STANDBY_WORKERS", executors.MAX_FAILED_STARTS + 1)
    executor = LocalExecutor(executors.MAX_FAILED_STARTS + 1)
    events: list[Event] = []
    with executor.connected():
        for child in multiprocessing.active_children():
            child.kill()
            child.join()
        executor.run_tasks(
            [scripted.Step("give", 3)] * 5, scripted.do, on_event=events.append, logs=tmp_path,
            save_file=lambda *_: None,
        )  # fmt: skip
    assert values(events) == dict.fromkeys(range(5), 3)
    assert not [event for event in events if isinstance(event, Retried)]


def test_unused_standby_processes_are_ended():
    before = set(multiprocessing.active_children())
    executor = LocalExecutor(2)
    with executor.connected():
        with executor.connected():  # as a command does that has its workers begin early
            pass
        assert len(set(multiprocessing.active_children()) - before) == 2
    assert set(multiprocessing.active_children()) <= before
