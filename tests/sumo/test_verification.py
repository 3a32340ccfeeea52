"""Episodes of a run verified with SUMO, by the agent and by the recorded controls."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest

from plant_bench.agents.loading.checksum import agent_checksum
from plant_bench.agents.remote.planner_connection import end_processes
from plant_bench.agents.remote.process import Limits
from plant_bench.data.recorder import Recorder
from plant_bench.data.recording import Recording
from plant_bench.runner.episode.jobs import Job
from plant_bench.runner.episode.loop import run_episode
from plant_bench.runner.review.differences import Difference
from plant_bench.runner.review.verification import Task, check_episode
from plant_bench.runner.workers.isolation import isolation_of
from plant_bench.scoring.results import EpisodeResult
from plant_bench.world.route import Route

pytestmark = pytest.mark.sumo
AGENT = "cruise"


@pytest.fixture(scope="module")
def driven(
    beginning: Callable[[int], Route], tmp_path_factory: pytest.TempPathFactory
) -> tuple[Job, Path, EpisodeResult]:
    job = Job(AGENT, agent_checksum(AGENT), beginning(120), 0, 5, "dense")
    file = tmp_path_factory.mktemp("driven") / "episode.parquet"
    return job, file, run_episode(job, recording=file).result


def difference(job: Job, record: EpisodeResult, recording: Path | None) -> Difference | None:
    return check_episode(Task("name", job, record, recording), lambda _: None).difference


def test_unchanged_record_is_confirmed_by_agent_and_by_controls(
    driven: tuple[Job, Path, EpisodeResult],
):
    job, file, record = driven

    assert difference(job, record, None) is None
    assert difference(job, record, file) is None


@pytest.mark.parametrize("way", ["agent", "controls"])
def test_record_with_a_removed_infraction_is_not_confirmed(
    driven: tuple[Job, Path, EpisodeResult], way: str
):
    job, file, record = driven
    better = record.model_copy(update={"distance": record.distance + 1.0})

    found = difference(job, better, file if way == "controls" else None)

    assert found is not None
    assert (found.field, found.again) == ("distance", str(record.distance))


def test_forged_recording_is_not_confirmed(driven: tuple[Job, Path, EpisodeResult], tmp_path: Path):
    job, file, record = driven
    recording = Recording.load(file)
    recorder = Recorder(tmp_path / "forged.parquet", recording.metadata)
    for scene in list(recording)[20:]:  # the start is skipped
        recorder.add(scene)
    recorder.close()

    found = difference(job, record, tmp_path / "forged.parquet")

    assert found is not None
    assert found.field == "recording, tick 20"


def test_episode_without_a_recording_is_not_confirmed(
    driven: tuple[Job, Path, EpisodeResult], tmp_path: Path
):
    job, _, record = driven

    found = difference(job, record, tmp_path / "none.parquet")

    assert found is not None
    assert found.told == "none"


HANGS = """
import time
class Hangs:
    inputs = frozenset()
    def reset(self, route): ...
    def act(self, observation):
        time.sleep(600)
"""


@pytest.mark.parametrize("hangs", [False, True])
def test_isolated_agent_verifies_or_is_ended_at_its_limit(
    driven: tuple[Job, Path, EpisodeResult], tmp_path: Path, hangs: bool
):
    job, _, record = driven
    file = tmp_path / "hangs.py"
    file.write_text(HANGS)
    agent = f"{file}:Hangs" if hangs else AGENT
    isolation = isolation_of(agent, Limits(tick=0.5))

    task = Task("name", replace(job, agent=agent), record, None, isolation)
    found = check_episode(task, lambda _: None).difference
    end_processes()

    assert (found is not None and found.field == "status") is hangs
