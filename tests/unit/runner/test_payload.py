import shutil
import subprocess
from dataclasses import replace
from pathlib import Path

import pytest

from plant_bench.agents.loading.checksum import PlannerComponents, agent_checksum
from plant_bench.agents.remote.launch_command import LaunchCommand
from plant_bench.agents.remote.planner_connection import Profile, end_processes
from plant_bench.agents.remote.process import Limits
from plant_bench.errors import InputError
from plant_bench.runner.episode.jobs import make_jobs
from plant_bench.runner.ray import payload
from plant_bench.runner.ray.payload import NodePaths, Requirements, differences, pack, unpack
from plant_bench.runner.run.episode_queue import _Task
from plant_bench.runner.workers.isolation import Isolation

AGENT = """
from pathlib import Path
import near
from plant_bench.agent import Control


class Mine:
    inputs = frozenset()

    def __init__(self, weights):
        self.files = [Path(weights)]
        self.gain = float(Path(weights).read_text())

    def reset(self, route): ...

    def act(self, observation):
        return Control(self.gain, near.STEERING)
"""


@pytest.fixture
def mine(tmp_path, monkeypatch):
    """A planner of two modules and a weights file in its own folder."""
    folder = tmp_path / "mine"
    folder.mkdir()
    (folder / "mine.py").write_text(AGENT)
    (folder / "near.py").write_text("STEERING = 0.0\n")
    (folder / "weights.txt").write_text("1.0")
    monkeypatch.chdir(folder)
    return f"{folder / 'mine.py'}:Mine@{folder / 'weights.txt'}"


@pytest.fixture
def task(route):
    def task_of(agent: str) -> _Task:
        jobs = make_jobs(
            agent, agent_checksum(agent), [route("a")], repetitions=1, seed=0, density="dense"
        )
        return _Task(jobs[0], Path("run/recordings/a.parquet"), "x:y")

    return task_of


@pytest.fixture
def place(tmp_path):
    return NodePaths(tmp_path / "node" / "files", tmp_path / "node" / "output")


def test_code_and_weights_are_unpacked_unchanged(mine, task, place):
    sent = pack([task(mine)])
    unpack(sent, place)

    names = sorted(path.name for path in place.root.rglob("*") if path.is_file())
    assert names == ["mine.py", "near.py", "weights.txt"]
    assert place.on_node(str(Path.cwd())).is_dir()
    assert sent.towns.keys() == {"town01"}


def test_unpacked_program_is_executable(tmp_path, task, place, monkeypatch):
    program = Path(shutil.copy(shutil.which("true") or "", tmp_path / "planner"))
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(
        payload, "components_of", lambda *_: PlannerComponents(frozenset({Path("planner")}))
    )

    unpack(pack([task("cruise")]), place)

    assert subprocess.run([place.on_node(str(program))], check=False).returncode == 0


def test_files_of_plant_bench_are_not_packed(task):
    assert not pack([task("cruise")]).files


def test_paths_in_a_planner_name_point_to_unpacked_files(mine, task, place):
    unpack(pack([task(mine)]), place)

    moved = place.planner(f"expert-filtered@masking:{mine}")

    assert moved.count(str(place.root)) == 2
    assert moved.startswith(f"expert-filtered@masking:{place.root}")
    assert place.planner("plant@/no/such/weights") == "plant@/no/such/weights"
    assert place.planner("mine.py:Mine@weights.txt") == "mine.py:Mine@weights.txt"


def test_record_names_the_planner_as_requested(mine, task, place):
    one = task(mine)
    unpack(pack([one]), place)

    there = one.with_paths(place)

    assert there.job.planner.startswith(str(place.root))
    assert there.job.header(frozenset()) == one.job.header(frozenset())
    assert there.recording == place.output / "recordings" / "a.parquet"
    assert task("cruise").with_paths(place).job.planner == ""


def test_file_changed_in_transit_is_refused(mine, task, place):
    sent = pack([task(mine)])
    path = next(path for path in sent.files if path.endswith("near.py"))
    broken = payload.replace(sent, files={**sent.files, path: b"STEERING = 1.0\n"})

    with pytest.raises(InputError, match=r"near\.py was changed in transit"):
        unpack(broken, place)


def test_different_planner_or_town_with_the_same_name_is_refused(mine, task, place):
    sent = pack([task(mine)])
    unpack(sent, place)
    payload.check_payload(sent, place)

    place.on_node(next(path for path in sent.files if path.endswith("weights.txt"))).write_text("2")
    with pytest.raises(InputError, match=r"differs from the planner of the run: weights\.txt"):
        payload.check_payload(sent, place)
    with pytest.raises(InputError, match="The town 'town01' differs"):
        payload.check_payload(payload.replace(sent, towns={"town01": "0"}), place)


def test_town_outside_the_package_is_packed(tmp_path):
    town = tmp_path / "towns" / "mytown"
    town.mkdir(parents=True)
    for name in ("town.json", "town.net.xml"):
        (town / name).write_text(name)

    class Task:
        requirements = Requirements(towns=frozenset({town}))

        def with_paths(self, paths):
            return self

    sent = pack([Task()])

    assert sorted(Path(path).name for path in sent.files) == ["town.json", "town.net.xml"]
    assert sent.town_folders == (str(town.parent),)


def test_isolated_planner_drives_from_the_unpacked_files(mine, task, place, route):
    here = Profile(frozenset(), 1, ranks=False, files=(Path("mine.py"),))
    asked = LaunchCommand(mine, ("/python/of/another/machine",), agent=mine)
    unpack(pack([task(mine)]), place)

    there = replace(task(mine), isolation=Isolation(asked, Limits(), here)).with_paths(place)
    planner = there.isolation.planner(there.job.planner)
    try:
        planner.reset(route("a"))
        assert place.root in planner.files[0].parents
    finally:
        end_processes()


def test_files_too_large_to_pack_are_refused(mine, task, monkeypatch):
    monkeypatch.setattr(payload, "MAX_BYTES", 10)

    with pytest.raises(InputError, match="can be sent to other machines"):
        pack([task(mine)])


def test_equal_installations_do_not_differ():
    assert differences(payload.environment(), payload.environment()) == ""
    assert "unknown there" in differences({"numpy": "2"}, {})
