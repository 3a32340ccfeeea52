"""Tasks and nodes on a fake Ray cluster; a real one is in tests/end_to_end."""

import shutil
import socket
import sys
import time
from pathlib import Path
from types import ModuleType

import pytest

from plant_bench.data_files import networks_dir
from plant_bench.errors import InputError, SimulationError
from plant_bench.runner.ray import executor as ray_executor
from plant_bench.runner.ray import node as ray_node
from plant_bench.runner.ray.executor import RayExecutor
from plant_bench.runner.ray.node import NodeWorker
from plant_bench.runner.ray.payload import Requirements, pack
from plant_bench.runner.workers.executors import Finished, Lost, Retried
from plant_bench.runner.workers.worker import Failed, Ready

A, B = "a" * 56, "b" * 56  # nodes


@pytest.fixture
def scripted(monkeypatch):
    """The module that workers import by name, in processes that are no child of pytest's main."""
    monkeypatch.syspath_prepend(str(Path(__file__).parent))
    monkeypatch.setitem(sys.modules, "__main__", ModuleType("__main__"))
    import scripted_work

    return scripted_work


@pytest.fixture
def cluster(scripted, monkeypatch):
    """Two nodes of one CPU."""
    pytest.importorskip("ray.util.scheduling_strategies")  # loaded before its parent is replaced
    from fake_ray import FakeRay

    fake = FakeRay({A: 1, B: 1})
    monkeypatch.setitem(sys.modules, "ray", fake)
    monkeypatch.setattr(ray_executor, "POLL_INTERVAL", 0.0)
    monkeypatch.setattr(ray_node, "REPLY_TIMEOUT", 0.1)
    return fake


class Told:
    """The events and results of a run."""

    def __init__(self):
        self.events, self.said, self.kept = [], [], {}

    def of(self, kind):
        return [event for event in self.events if isinstance(event, kind)]

    def values(self):
        return {event.task: event.value for event in self.of(Finished)}


def run(scripted, steps, tmp_path, told=None, **settings) -> Told:
    told = told or Told()
    RayExecutor(on_message=told.said.append, **settings).run_tasks(
        steps,
        scripted.do,
        on_event=told.events.append,
        logs=tmp_path,
        save_file=told.kept.__setitem__,
    )
    return told


def test_values_and_files_are_returned(cluster, scripted, tmp_path):
    told = run(scripted, [scripted.Step("write", number) for number in range(3)], tmp_path)

    assert told.values() == {0: 0, 1: 1, 2: 2}
    assert told.kept == {f"recordings/{number}.parquet": b"ticks" for number in range(3)}
    assert len(cluster.actors) == 2
    assert not any(actor.made._folder.exists() for actor in cluster.actors)


def test_concurrency_does_not_exceed_the_request(cluster, scripted, tmp_path):
    run(scripted, [scripted.Step("give")] * 3, tmp_path, workers=1)

    assert len(cluster.actors) == 1


@pytest.mark.parametrize(
    ("act", "reason"),
    [
        ("kill", "The worker process was ended by SIGKILL."),
        ("simulation-error", "the ego was lost"),
    ],
)
def test_failures_are_reported_as_in_a_local_run(cluster, scripted, tmp_path, act, reason):
    told = run(scripted, [scripted.Step(act), scripted.Step("give", 1)], tmp_path, workers=1)

    assert [event.reason for event in told.of(Retried)] == [reason]
    assert [event.reason for event in told.of(Lost)] == [reason]
    assert told.values() == {1: 1}
    assert not told.said


def test_output_of_remote_workers_is_in_the_local_log(cluster, scripted, tmp_path):
    run(scripted, [scripted.Step("print")], tmp_path)

    assert (tmp_path / "worker0.log").read_text() == "seen in the log\n"


def test_lost_node_does_not_count_as_a_task_failure(cluster, scripted, tmp_path):
    def lose(actor, method, given):
        if actor.node == A and method == "step":
            cluster.gone.add(actor.node)
            from ray.exceptions import RayActorError

            raise RayActorError

    cluster.on_call = lose
    told = run(scripted, [scripted.Step("give", 7), scripted.Step("give", 8)], tmp_path)

    assert told.values() == {0: 7, 1: 8}
    assert not told.of(Retried)
    assert told.said == ["A worker on node host-a (aaaaaaaa) was lost; its episode is run again."]


def test_task_that_always_loses_its_worker_is_dropped_unrecorded(
    cluster, scripted, tmp_path, monkeypatch
):
    def lose(actor, method, given):
        if method == "step" and given[0] is not None and given[0].value == 7:
            from ray.exceptions import RayActorError

            raise RayActorError

    cluster.on_call = lose
    monkeypatch.setattr(ray_executor, "MAX_LOST_WORKERS", 2)
    told = Told()
    with pytest.raises(SimulationError, match="1 episodes lost their node 2 times"):
        run(scripted, [scripted.Step("give", 7), scripted.Step("give", 8)], tmp_path, told)

    assert told.values() == {1: 8}
    assert not told.of(Lost)


def test_node_with_other_versions_is_refused_and_the_others_work(cluster, scripted, tmp_path):
    cluster.facts[A] = {**ray_node.environment(), "libsumo": "1.27.0"}

    told = run(scripted, [scripted.Step("give", 1)] * 2, tmp_path)

    assert told.values() == {0: 1, 1: 1}
    assert told.said == ["Node host-a (aaaaaaaa) is excluded: libsumo 1.27.0 there, 1.28.0 here"]


def test_run_ends_if_all_nodes_have_other_versions(cluster, scripted, tmp_path):
    cluster.facts |= {name: {"plant-bench": "0.0.1"} for name in cluster.cpus}

    with pytest.raises(InputError, match="All nodes of the Ray cluster are excluded: host-a"):
        run(scripted, [scripted.Step("give")], tmp_path)


def test_a_cluster_without_cpus_ends_the_run(cluster, scripted, tmp_path, monkeypatch):
    cluster.gone |= set(cluster.cpus)
    monkeypatch.setattr(ray_executor, "NO_NODE_TIMEOUT", 0.0)

    with pytest.raises(SimulationError, match="has had no CPU"):
        run(scripted, [scripted.Step("give")], tmp_path)


def test_error_common_to_all_tasks_ends_the_run(cluster, scripted, tmp_path):
    with pytest.raises(InputError, match="no such town"):
        run(scripted, [scripted.Step("input-error")], tmp_path)


def test_missing_cluster_gives_one_line(cluster, scripted, tmp_path):
    with pytest.raises(InputError, match="There is no Ray cluster at 'nowhere'"):
        run(scripted, [scripted.Step("give")], tmp_path, address="nowhere")


def test_unreachable_address_is_reported_at_once(scripted, tmp_path):
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        address = f"ray://127.0.0.1:{taken.getsockname()[1]}"
        start = time.monotonic()
        with pytest.raises(InputError, match="No response at the --address"):
            run(scripted, [scripted.Step("give")], tmp_path, address=address)

    assert time.monotonic() - start < 5.0


def test_ctrl_c_ends_all_workers_and_cleans_the_nodes(cluster, scripted, tmp_path):
    def interrupt(actor, method, given):
        if method == "step" and given[0] is None:
            raise KeyboardInterrupt

    cluster.on_call = interrupt
    with pytest.raises(KeyboardInterrupt):
        run(scripted, [scripted.Step("sleep")] * 2, tmp_path)

    assert all(actor.killed for actor in cluster.actors)
    assert not any(actor.made._folder.exists() for actor in cluster.actors)


@pytest.fixture
def node(scripted):
    worker = NodeWorker()
    yield worker
    worker.close()


def test_packed_town_is_found_on_the_node(node, scripted, tmp_path):
    towns = tmp_path / "towns"
    shutil.copytree(networks_dir() / "town01", towns / "mytown")
    file = towns / "mytown" / "town.json"
    file.write_text(file.read_text().replace('"town01"', '"mytown"'))
    sent = pack(
        [scripted.Step("give", requirements=Requirements(towns=frozenset({towns / "mytown"})))]
    )
    shutil.rmtree(towns)

    assert isinstance(node.start(sent, scripted.do).message, Ready)


def test_worker_that_does_not_restart_is_a_task_failure(node, scripted, monkeypatch):
    step = scripted.Step("give")
    node.start(pack([step]), scripted.do)
    node._kill_process()
    monkeypatch.setattr(ray_node, "START_TIMEOUT", 0.0)

    assert node.step(step).message == Failed("The worker does not start.")
