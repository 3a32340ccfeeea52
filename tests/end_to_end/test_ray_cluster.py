"""A real Ray cluster of several nodes on this machine, one of which is lost during the run."""

import json
import os
import random
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

from plant_bench.runner.ray.executor import RayExecutor
from plant_bench.runner.run.episode_queue import EpisodeEnded, EpisodeRetried, run_suite
from plant_bench.runner.run.score_run import Run, ScoreRequest, open_run
from plant_bench.world.route import ROUTE_FORMAT
from tests.shortened import first_metres

ROOT = Path(__file__).parents[2]
STORE = 80 * 2**20  # bytes; the least that Ray takes is 75 MB
pytestmark = [
    pytest.mark.sumo,
    pytest.mark.filterwarnings("ignore::ResourceWarning"),  # Ray's own files and sockets
    pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning"),
    pytest.mark.filterwarnings("ignore::DeprecationWarning:ray"),
    pytest.mark.filterwarnings("ignore::FutureWarning:ray"),
]


@contextmanager
def several_nodes(count: int) -> Iterator[tuple[Any, list[Any]]]:
    """Start a cluster with a head node that runs no tasks and `count` nodes with one CPU.

    Yields:
        The cluster, and its nodes.
    """
    paths = [str(ROOT), os.environ.get("PYTHONPATH", "")]
    settings = {
        "PYTHONPATH": os.pathsep.join(filter(None, paths)),
        "RAY_worker_niceness": "0",  # 15 by Ray's default, after all other work on this machine
        "RAY_prestart_worker_first_driver": "0",  # they would be unused
        "RAY_ACCEL_ENV_VAR_OVERRIDE_ON_ZERO": "0",
    }
    before = {name: os.environ.get(name) for name in settings}
    os.environ.update(settings)
    from ray.cluster_utils import Cluster

    cluster = Cluster(
        initialize_head=True,
        head_node_args={
            "num_cpus": 0,
            "object_store_memory": STORE,
            "include_dashboard": False,
        },
    )
    try:
        nodes = [cluster.add_node(num_cpus=1, object_store_memory=STORE) for _ in range(count)]
        yield cluster, nodes
    finally:
        cluster.shutdown()
        for name, value in before.items():
            if value is None:
                os.environ.pop(name, None)
            else:
                os.environ[name] = value


@pytest.fixture
def request_of(tmp_path):
    """Request short routes driven by the example agent, which no node has installed."""

    def wanted(metres: list[int]) -> ScoreRequest:
        routes = [first_metres(length, f"first-{length}").to_payload() for length in metres]
        suite = tmp_path / "suite.json"
        suite.write_text(json.dumps({"format": ROUTE_FORMAT, "routes": routes}), encoding="utf-8")
        agent = tmp_path / "elsewhere" / "my_agent.py"
        agent.parent.mkdir()
        agent.write_text((ROOT / "examples" / "my_agent.py").read_text(), encoding="utf-8")
        return ScoreRequest(f"{agent}:MyAgent", str(suite), repetitions=1)

    return wanted


def contents(run: Run) -> dict[str, bytes]:
    parts = ("episodes", "recordings")
    files = [path for part in parts for path in (run.folder.path / part).iterdir()]
    return {f"{path.parent.name}/{path.name}": path.read_bytes() for path in files}


def test_losing_a_node_does_not_change_the_results(request_of, tmp_path):
    request = request_of([20, 25, 30, 35, 40])
    here = open_run(request, tmp_path / "here")
    run_suite(here.missing, here.folder, workers=1, on_event=lambda event: None)
    there = open_run(request, tmp_path / "there")
    events, said = [], []

    with several_nodes(3) as (cluster, nodes):

        def listen(event):
            events.append(event)
            if sum(isinstance(one, EpisodeEnded) for one in events) == 1 and len(nodes) == 3:
                cluster.remove_node(nodes.pop(), allow_graceful=False)

        executor = RayExecutor(cluster.address, on_message=said.append)
        run_suite(there.missing, there.folder, workers=1, on_event=listen, executor=executor)

    assert len(nodes) == 2
    assert contents(there) == contents(here)
    assert len(contents(there)) == 10
    assert not any(isinstance(event, EpisodeRetried) for event in events)


@pytest.mark.slow
def test_full_routes_complete_when_a_random_node_is_lost(tmp_path):
    wanted = ["score", "--agent", "rule-based", "--routes", "3-5,15-17", "--repetitions", "1"]
    command = [sys.executable, "-m", "plant_bench", *wanted]
    subprocess.run([*command, "--workers", "2", "--out", "here"], cwd=tmp_path, check=True)

    with several_nodes(3) as (cluster, nodes):
        asked = [*command, "--executor", "ray", "--address", cluster.address, "--out", "there"]
        driving = subprocess.Popen(asked, cwd=tmp_path)
        while not list(tmp_path.glob("there/episodes/*.json")):
            assert driving.poll() is None
            time.sleep(0.5)
        time.sleep(random.uniform(0.0, 5.0))
        cluster.remove_node(nodes.pop(), allow_graceful=False)
        assert driving.wait(600) == 0

    for part in ("episodes", "recordings"):
        for path in (tmp_path / "here" / part).iterdir():
            assert path.read_bytes() == (tmp_path / "there" / part / path.name).read_bytes()
    summaries = [(tmp_path / name / "summary.json").read_bytes() for name in ("here", "there")]
    assert summaries[0] == summaries[1]
