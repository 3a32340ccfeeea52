import json
from dataclasses import replace

import numpy as np
import pytest

from plant_bench.data.recording import Recording
from plant_bench.errors import InputError
from plant_bench.reports.replay.attention import Attention
from plant_bench.reports.replay.replay_episode import load_episode, replay_script
from plant_bench.reports.replay.replay_source import ReplaySource, load_recording
from tests.unit.reports.replay.drives import HIT_AT, SPEED, drive, some_route
from tests.unit.reports.replay.unpacking import facts_of, unpack

HALF_CM, HALF_MRAD = 0.0051, 0.00051


@pytest.fixture
def facts(source):
    return facts_of(replay_script(load_episode(source)))


def test_a_replay_holds_the_drive_to_the_centimetre(source, facts):
    columns = unpack(facts["columns"], facts["data"])
    recording = Recording.load(source.recording)
    egos = recording.egos[::2]
    for place, (name, least) in enumerate({"x": HALF_CM, "y": HALF_CM, "yaw": HALF_MRAD}.items()):
        scale = facts["scales"]["angle" if name == "yaw" else "length"]
        apart = np.unwrap(egos[:, place]) if name == "yaw" else egos[:, place]
        assert np.abs(columns[f"ego.{name}"] / scale - apart).max() < least
    poses = np.stack([columns["pose.x"], columns["pose.y"]], axis=1) / facts["scales"]["length"]
    start = int(columns["track.count"][: list(columns["track.id"]).index(5)].sum())
    recorded = [recording[row].actors for row in range(0, len(recording), 2)]
    fifth = [actors.poses[actors.ids == 5][0, :2] for actors in recorded]
    assert np.abs(poses[start : start + len(fifth)] - fifth).max() < HALF_CM
    assert columns["lights"].tolist()[:20] == [1] * 15 + [2] * 5
    np.testing.assert_allclose(columns["plan.0"] / 100.0, SPEED / 2.0)
    assert columns["plan.tick"].tolist() == list(range(0, 81, 2))


def test_replay_holds_the_place_and_time_of_infractions(facts):
    hit, light = facts["infractions"]
    assert (hit["kind"], hit["time"], hit["actor"]) == ("collision_vehicle", HIT_AT, 1)
    assert (hit["actorKind"], hit["cause"], hit["factor"]) == ("car", "ego", 0.6)
    assert light["speed"] == SPEED
    route = some_route()
    np.testing.assert_allclose(facts["hazards"][0]["place"][:2], route.points[30], atol=0.5)
    assert facts["hazards"][0]["letter"] == "C"
    assert len(facts["signals"]) == len(route.signal_passages)


def test_reasons_are_kept_where_recorded(tmp_path):
    facts = facts_of(replay_script(load_episode(drive(tmp_path, plans=False))))
    columns = unpack(facts["columns"], facts["data"])
    assert facts["causes"][columns["reason.cause"][7] - 1] == "leader"
    assert columns["reason.actor"][7] - 1 == 1
    assert len(columns["plan.tick"]) == 0
    quiet = facts_of(replay_script(load_episode(drive(tmp_path))))
    assert "reason.cause" not in {name for name, *_ in quiet["columns"]}


def test_five_minutes_with_50_actors_stay_below_1_mb(tmp_path):
    script = replay_script(load_episode(drive(tmp_path, seconds=300.0, actors=50)))
    assert len(script) < 1_000_000


def test_untrusted_titles_and_reasons_stay_text(tmp_path):
    hostile = "</script><img src=x onerror=alert(1)>\u2028" + "🚗" * 10_000
    script = replay_script(load_episode(drive(tmp_path, title=hostile, reason=hostile)))
    assert "<" not in script
    assert script.count("\n") == 1
    assert facts_of(script)["title"] == hostile
    assert facts_of(script)["result"]["reason"] == hostile


@pytest.mark.parametrize("time", [1e308, -1e308])
def test_infraction_outside_the_recording_is_placed_at_its_end(source, time):
    hit = source.result.infractions[0].model_copy(update={"time": time})
    result = source.result.model_copy(update={"infractions": (hit,)})

    script = replay_script(load_episode(replace(source, result=result)))

    assert facts_of(script)["infractions"][0]["speed"] == pytest.approx(SPEED, abs=0.01)


@pytest.mark.parametrize("bad", ["../out/x", "run", "run/../x", "a/b/c", "run/<x>", ".x/y", ""])
def test_replay_ids_with_path_traversal_are_refused(source, bad):
    with pytest.raises(InputError, match="Replay id"):
        ReplaySource(bad, "t", "cruise", source.recording, source.result)


def test_unusable_recording_is_refused_with_the_reason(tmp_path, source):
    with pytest.raises(InputError, match="is thinned: .* score --recordings"):
        load_recording(drive(tmp_path, run="thin", every=10))
    other = drive(tmp_path, run="other", town_checksum="1" * 64)
    with pytest.raises(InputError, match="town town01 has changed"):
        load_episode(other)
    other = drive(tmp_path, run="routes", route_checksum="1" * 64)
    with pytest.raises(InputError, match="has changed since the episode was driven: no suite"):
        load_episode(other)
    source.recording.write_bytes(b"broken")
    with pytest.raises(InputError, match="Not a recording"):
        load_recording(source)
    source.recording.unlink()
    with pytest.raises(InputError, match="scored without recordings"):
        load_recording(source)


def test_a_recording_of_another_scenario_is_refused(tmp_path, source):
    other = drive(tmp_path, run="other", scenario="f" * 16)
    mixed = ReplaySource(source.id, "t", "cruise", other.recording, source.result)
    with pytest.raises(InputError, match="is of scenario ffff"):
        load_recording(mixed)


def test_missing_attention_is_explained(facts):
    assert facts["attentionNote"] == "The planner does not rank actors."
    assert len(Attention.absent("x").ticks) == 0
    assert json.dumps(facts)  # all of it is plain JSON
