"""Collection while another planner drives (DAgger): the expert's responses are the targets."""

import math
from collections.abc import Callable
from pathlib import Path

import pytest

from plant_bench.agent import Control
from plant_bench.agents.loading.checksum import agent_checksum
from plant_bench.data.recording import Recording
from plant_bench.runner.collect.collect_task import DriveTask, drive_episode
from plant_bench.runner.collect.dagger import PATIENCE, TAKEOVER, DaggerOverride
from plant_bench.runner.collect.data_folder import DataFolder, EpisodeNote
from plant_bench.runner.collect.episode_plan import PlannedEpisode
from plant_bench.runner.episode.jobs import Job
from plant_bench.runner.episode.loop import run_episode
from plant_bench.world.route import Route
from plant_bench.world.scene import TICK, Scene

pytestmark = pytest.mark.sumo

DRIVERS = """
from plant_bench.agent import Control

class Stands:
    inputs = frozenset()
    def reset(self, route): ...
    def act(self, observation):
        return Control(-3.0, 0.125)

class Fails(Stands):
    def act(self, observation):
        if observation.time > 1.0:
            raise ValueError("no idea")
        return Control(1.0, 0.0)
"""


@pytest.fixture
def drivers(tmp_path: Path) -> Path:
    file = tmp_path / "drivers.py"
    file.write_text(DRIVERS)
    return file


def job_on(route: Route) -> Job:
    return Job("expert", agent_checksum("expert"), route, 0, 5, "dense", hazards=False)


class Watched(DaggerOverride):
    """Records the requested and the executed controls."""

    def __init__(self, driver: str, route: Route) -> None:
        super().__init__(driver, route, 0)
        self.ticks: list[tuple[Control, Control]] = []

    def executed(self, scene: Scene, progress: float, offset: float, control: Control) -> Control:
        done = super().executed(scene, progress, offset, control)
        self.ticks.append((control, done))
        return done


def test_data_holds_expert_responses_and_marks_other_controls(
    beginning: Callable[[int], Route], drivers: Path, tmp_path: Path
) -> None:
    route = beginning(60)
    wheel = Watched(f"{drivers}:Stands", route)
    file = tmp_path / "episode.parquet"
    run_episode(job_on(route), recording=file, thinning=10, override=wheel)
    recording = Recording.load(file)
    asked = [control for control, _ in wheel.ticks]
    done = [control for _, control in wheel.ticks]
    assert len(recording) == len(wheel.ticks) + 1  # no decision at the last scene
    answers = {row: action for row, action in enumerate(recording.actions) if action is not None}
    assert answers
    assert all(recording.reasons[row] is not None for row in answers)
    assert all(action == asked[row] for row, action in answers.items())
    assert Control(-3.0, 0.125) not in asked
    differs = [one != other for one, other in zip(asked, done, strict=True)]
    assert recording.disturbed.tolist() == [*differs, False]
    patience, relief = round(PATIENCE / TICK), round(TAKEOVER / TICK)
    assert all(differs[:patience])
    assert differs[patience:].count(False) >= relief
    moved = [math.hypot(*(place - recording.egos[0, :2])) for place in recording.egos[:, :2]]
    assert moved[patience] == 0.0
    assert max(moved) > 5.0  # relieved


def collected(route: Route, driver: str, folder: DataFolder) -> tuple[EpisodeNote, Path]:
    for name in ("episodes", "unfinished"):
        (folder.path / name).mkdir(parents=True, exist_ok=True)
    episode = PlannedEpisode(job_on(route), perturbed=False, driver=driver)
    note, _ = drive_episode(DriveTask(episode, folder), lambda _share: None)
    assert not list((folder.path / "unfinished").iterdir())
    return note, folder.episode(episode.name)


def test_episodes_with_collisions_are_kept(
    beginning: Callable[[int], Route], tmp_path: Path
) -> None:
    note, file = collected(beginning(250), "cruise", DataFolder(tmp_path / "data"))
    assert note.collisions > 0
    assert note.left_out == ""
    assert file.is_file()


def test_episode_of_a_failing_driver_is_left_out(
    beginning: Callable[[int], Route], drivers: Path, tmp_path: Path
) -> None:
    note, file = collected(beginning(60), f"{drivers}:Fails", DataFolder(tmp_path / "data"))
    assert note.left_out == "Agent crashed: the driver's act raised ValueError: no idea"
    assert not file.exists()
