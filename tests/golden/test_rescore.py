"""A recording is rescored from its scenes alone and gives an identical record."""

import dataclasses

import pytest

from plant_bench.data.recorder import Recorder
from plant_bench.data.recording import Recording
from plant_bench.errors import InputError
from plant_bench.scoring.infractions import Status
from plant_bench.scoring.referee import Referee, result_of
from plant_bench.scoring.rescore_episode import rescore
from plant_bench.scoring.results import RESULT_FORMAT, Crash, EpisodeHeader
from plant_bench.world.scene import ActorKind, Light


@pytest.fixture
def header(stage):
    return EpisodeHeader(
        protocol="longest6-sumo-v2-rc2",
        agent="scripted",
        agent_checksum="0" * 64,
        inputs=("objects", "route"),
        route=stage.route.id,
        town=stage.town.name,
        scenario="0123456789abcdef",
        repetition=0,
        seed=3,
        density="dense",
        town_checksum="1" * 64,
        route_checksum=stage.route.checksum,
    )


@pytest.fixture
def eventful(stage):
    """A drive with one infraction of every kind that does not end the episode."""
    stage.drive(40.0, others=[stage.other(40.123, 1.3, 0.3, 2.0, kind=ActorKind.PEDESTRIAN)])
    stage.drive(80.0, y=3.3, others=[stage.other(80.0, 3.1, id=2), stage.other(70.0, -3.0, id=3)])
    stage.drive(170.0, light=Light.RED)
    return stage.drive(247.0, others=[stage.other(250.0, 0.77, kind=ActorKind.STATIC, id=4)])


def judged(stage, path, header, *, crash=None):
    """Judge and record the episode as the runner does."""
    referee = Referee(stage.town, stage.route)
    recorder = Recorder(path, header.model_dump(mode="json"))
    for scene in stage.scenes:
        referee.judge(scene)
        recorder.add(scene)
    recorder.close(**({} if crash is None else vars(crash)))
    return result_of(referee, header, crash=crash)


def test_rescoring_a_recording_reproduces_the_record(eventful, header, tmp_path):
    eventful.drive(300.0)
    original = judged(eventful, tmp_path / "episode.parquet", header)
    again = rescore(Recording.load(tmp_path / "episode.parquet"), eventful.town, eventful.route)
    assert again.to_json() == original.to_json()
    assert [str(item.kind) for item in again.infractions] == [
        "collision_pedestrian",
        "collision_vehicle",
        "red_light",
        "collision_static",
        "outside_lanes",
    ]
    assert again.status is Status.COMPLETED


def test_rescoring_recomputes_the_episode_metrics(eventful, header, tmp_path):
    eventful.drive(300.0, others=[eventful.other(280.0, -3.5, speed=5.0, id=5)])
    original = judged(eventful, tmp_path / "episode.parquet", header)
    again = rescore(Recording.load(tmp_path / "episode.parquet"), eventful.town, eventful.route)
    assert again.measures == original.measures
    assert again.measures is not None
    assert (again.measures["ttc_vehicle"], again.measures["ttc_vulnerable"]) == (0.0, 0.0)
    assert again.measures["relative_speed"] is not None


def test_format_1_recording_is_rescored_with_episode_metrics(eventful, header, tmp_path):
    eventful.drive(300.0)
    old = header.model_copy(update={"format": 1})
    original = judged(eventful, tmp_path / "episode.parquet", old).as_format(1)
    again = rescore(Recording.load(tmp_path / "episode.parquet"), eventful.town, eventful.route)
    assert again.measures is not None
    assert again.format == RESULT_FORMAT
    assert again.as_format(1).to_json() == original.to_json()


def test_crash_is_read_from_the_metadata(eventful, header, tmp_path):
    crash = Crash(Status.AGENT_CRASHED, "ValueError: no plan")
    original = judged(eventful, tmp_path / "episode.parquet", header, crash=crash)
    again = rescore(Recording.load(tmp_path / "episode.parquet"), eventful.town, eventful.route)
    assert again.to_json() == original.to_json()
    assert again.status is Status.AGENT_CRASHED
    assert again.reason == "ValueError: no plan"


def test_crash_before_the_first_scene_gives_a_record(stage, header, tmp_path):
    crash = Crash(Status.AGENT_CRASHED, "reset failed")
    original = judged(stage, tmp_path / "episode.parquet", header, crash=crash)
    again = rescore(Recording.load(tmp_path / "episode.parquet"), stage.town, stage.route)
    assert again.to_json() == original.to_json()
    assert (again.completion, again.duration, again.infractions) == (0.0, 0.0, ())
    assert again.measures is None


def test_crash_after_termination_does_not_change_the_status(stage, header):
    referee = stage.drive(300.0).verdict()
    result = result_of(referee, header, crash=Crash(Status.SIMULATION_CRASHED, "on closing"))
    assert (result.status, result.reason) == (Status.COMPLETED, "")


def test_unfinished_episode_has_no_result(stage, header):
    with pytest.raises(InputError, match="has not ended"):
        result_of(stage.drive(100.0).verdict(), header)


def test_recording_of_another_route_is_refused(stage, header, tmp_path):
    stage.drive(300.0)
    judged(stage, tmp_path / "episode.parquet", header)
    other = dataclasses.replace(stage.route, id="stage-1")
    with pytest.raises(InputError, match="not of stage-1"):
        rescore(Recording.load(tmp_path / "episode.parquet"), stage.town, other)


def test_recording_without_metadata_is_refused(stage, tmp_path):
    Recorder(tmp_path / "bare.parquet", {}).close()
    with pytest.raises(InputError, match="no valid episode header"):
        rescore(Recording.load(tmp_path / "bare.parquet"), stage.town, stage.route)
