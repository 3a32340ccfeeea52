"""A new input needs one row and one function: this adds one to a copy of the package.

The copy has nothing else changed. A planner that steers its speed by the new image then drives in
worker processes, in a process of its own, on a Ray cluster and in the environment: all the same.
"""

import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
ROUTE = "town01-5"  # the shortest
pytestmark = pytest.mark.sumo


def block(name: str) -> str:
    """Return the code of docs/how-to/add-a-sensor-input.md that is marked with a name."""
    page = (ROOT / "docs" / "how-to" / "add-a-sensor-input.md").read_text(encoding="utf-8")
    (code,) = re.findall(rf"<!-- {name} -->\n```python\n(.*?)```", page, re.DOTALL)
    return code


FUNCTION = f"\n{block('function')}\n\n"
ROW = block("row").splitlines(keepends=True)[1]
PLANNER = f"\n{block('planner')}"

GYM = '''
import json

import gymnasium
import numpy as np

import plant_bench.gym
from looker import Looker


class Seen:
    """What the planner sees, and nothing that is learned from."""

    inputs = Looker.inputs
    space = gymnasium.spaces.Box(0, 255, (3, 8, 16), np.uint8)

    def reset(self, town):
        pass

    def encode(self, observation):
        return observation.sensors["shade"]


def main():
    env = gymnasium.make(
        plant_bench.gym.ENV_ID, observation=Seen(), frame_skip=4, density="light",
        action="plan",
        disable_env_checker=True,
    ).unwrapped
    planner = Looker()
    env.reset(options={"route": "ROUTE", "repetition": 0})
    over = False
    while not over:
        plan = planner.act(env.observation)
        over = any(env.step(plan.waypoints)[2:4])
    print(env.result.to_json())


main()
'''

CLUSTER = """
import os
import subprocess
import sys

from ray.cluster_utils import Cluster

STORE = 80 * 2**20

os.environ["RAY_worker_niceness"] = "0"
head = {"num_cpus": 1, "object_store_memory": STORE, "include_dashboard": False}
cluster = Cluster(initialize_head=True, head_node_args=head)
try:
    done = subprocess.run([*sys.argv[1:], "--executor", "ray", "--address", cluster.address])
finally:
    cluster.shutdown()
sys.exit(done.returncode)
"""


@pytest.fixture(scope="module")
def copied(tmp_path_factory) -> Path:
    """A folder with the package, an additional input, and a planner that uses it."""
    folder = tmp_path_factory.mktemp("copied")
    ignored = shutil.ignore_patterns("__pycache__")
    shutil.copytree(ROOT / "plant_bench", folder / "plant_bench", ignore=ignored)
    for name in ("networks", "routes", "models"):
        (folder / name).symlink_to(ROOT / name)
    table = folder / "plant_bench" / "sensing" / "inputs.py"
    text = table.read_text()
    assert "shade" not in text
    text = text.replace("_ROWS = (\n", f"_ROWS = (\n{ROW}", 1)
    table.write_text(text.replace("\n_REALS", f"{FUNCTION}_REALS", 1))
    (folder / "looker.py").write_text(PLANNER)
    (folder / "cluster.py").write_text(CLUSTER)
    (folder / "drive.py").write_text(GYM.replace("ROUTE", ROUTE))
    return folder


def run(folder: Path, *words: str) -> str:
    environment = os.environ | {"PYTHONPATH": str(folder)}
    done = subprocess.run(
        [sys.executable, *words],
        cwd=folder,
        env=environment,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def score(folder: Path, out: str, *, by: tuple[str, ...] = (), more: tuple[str, ...] = ()) -> dict:
    planner = f"{folder / 'looker.py'}:Looker"
    wanted = ["--agent", planner, "--routes", ROUTE, "--repetitions", "1", "--density", "light"]
    command = ["-m", "plant_bench", "score", *wanted, "--workers", "1", "--out", out, *more]
    run(folder, *by, *command)
    (record,) = (folder / out / "episodes").glob("*.json")
    return json.loads(record.read_text()) | {"name": record.name}


def test_new_input_works_everywhere_with_one_row_and_one_function(copied):
    local = score(copied, "local")
    isolated = score(copied, "isolated", more=("--isolate",))
    cluster = score(copied, "cluster", by=("cluster.py", sys.executable))
    driven = json.loads(run(copied, "drive.py"))

    assert local["inputs"] == ["route", "shade"]
    assert "crashed" not in local["status"]
    assert isolated == local
    assert cluster == local
    named = {"agent", "agent_checksum", "name"}
    assert {name: value for name, value in driven.items() if name not in named} == {
        name: value for name, value in local.items() if name not in named
    }


def test_image_only_planner_is_listed_under_sensors(copied):
    code = (
        "from plant_bench.sensing.inputs import track_of\n"
        "print(track_of(['route', 'shade']).label, track_of(['shade', 'objects']).label)"
    )

    assert run(copied, "-c", code).split() == ["sensors", "objects"]
