"""A tiny made-up folder of data, counted by hand."""

import json

import numpy as np
import pytest

from plant_bench.data.recorder import Recorder
from plant_bench.data.statistics import describe_data, find_data_faults
from plant_bench.errors import InputError
from plant_bench.reports.data_card import data_card
from plant_bench.reports.data_plots import save_data_plots
from plant_bench.runner.collect.data_folder import EpisodeNote
from plant_bench.runner.collect.request import CollectRequest
from plant_bench.world.route import ROUTE_FORMAT, LaneSpan, Route
from plant_bench.world.scene import Actors, EgoState, Scene
from plant_bench.world.town import load_town


def save_routes(path, *names):
    lane = next(iter(load_town("town01").edges.values()))[0]
    routes = [
        Route(
            id=name,
            town="town01",
            points=np.stack([np.arange(41.0), np.zeros(41)], axis=1),
            elevations=np.zeros(41),
            speed_limits=np.full(41, 8.0),
            edges=(lane.edge,),
            lanes=(LaneSpan(lane.id, 0.0, 40.0),),
            passages=(),
            lane_changes=(),
            manoeuvres={"left": 1, "right": 0},
        ).to_payload()
        for name in names
    ]
    path.parent.mkdir(parents=True)
    path.write_text(json.dumps({"format": ROUTE_FORMAT, "routes": routes}))


HAZARDS = [{"kind": "cut_in", "phase": "done"}, {"kind": "crossing", "phase": "void"}]


def record(path, route, *, speed, **told):
    """21 ticks, 3 frames: two actors near the ego, one out of reach; disturbed from tick 10 on."""
    about = {"route": route, "town": "town01", "hazards": HAZARDS} | told
    recorder = Recorder(path, about, every=10)
    for tick in range(21):
        x = tick * 0.05 * speed
        poses = np.array([[x + 10, 0, 0], [x, -29, 0], [x, 31, 0]], np.float32)
        actors = Actors(
            np.arange(3),
            poses,
            np.zeros(3, np.float32),
            np.ones((3, 2), np.float32),
            np.zeros(3, np.uint8),
        )
        scene = Scene(tick, EgoState(x, 0.0, 0.0, speed), actors, np.zeros(0, np.uint8))
        recorder.add(scene, disturbed=tick >= 10)
    recorder.close()


@pytest.fixture
def folder(tmp_path):
    data = tmp_path / "data"
    save_routes(data / "routes" / "town01.json", "town01-long-0", "town01-left-0")
    record(data / "episodes" / "a.parquet", "town01-long-0", speed=10.0)
    record(data / "episodes" / "b.parquet", "town01-left-0", speed=0.0)
    return data


def test_it_counts_what_is_there(folder):
    data = describe_data(folder)
    assert (data.episodes, data.frames) == (2, 6)
    assert data.hours == pytest.approx(3 / 3600, abs=1e-3)
    assert data.km == pytest.approx(0.01)
    assert data.standing_share == 0.5
    assert data.nearby_mean == 2.0
    assert data.nearby[2] == 6
    assert (data.speeds[0], data.speeds[7]) == (3, 3)  # 36 km/h
    assert data.turns == {"left": 2}
    assert data.hazards == {"cut_in": 2}
    assert data.towns == {"town01": 6}
    assert data.routes == {"left": 3, "long": 3}
    assert data.disturbed_episodes == 2
    assert data.disturbed_share == pytest.approx(4 / 6, abs=1e-4)


def test_the_card_tells_whose_drives_they_are(folder):
    data, notes = describe_data(folder), [EpisodeNote(route="a", status="Completed", collisions=3)]
    card = data_card(data, CollectRequest(6, seed=2, perturb=0.3), notes, "mine")
    command = "`plant-bench collect --out mine --frames 6 --seed 2 --density dense --perturb 0.3`"
    assert command in card
    assert "the expert, an algorithm" in card
    assert "not for training" in card
    assert "Collisions caused by other actors, in the included episodes: 3." in card
    assert "frames during a perturbation" in card


def test_the_card_of_answers_tells_who_drove(folder):
    data, notes = describe_data(folder), [EpisodeNote(route="a", status="Completed", collisions=3)]
    request = CollectRequest(6, driver="plant@/home/me/models/mine")
    card = data_card(data, request, notes, "own")
    assert "--density dense --driver plant@mine`" in card
    assert "`plant@mine` drove" in card
    assert "expert actions, not drives" in card
    assert "--targets expert-action" in card
    assert "including those caused by the driver, in the included episodes: 3." in card
    assert "| frames not driven as the expert | 66.7% |" in card
    for word in ("perturbation", "caused by other actors", "not for training", "/home"):
        assert word not in card


def test_plots_are_saved(folder, tmp_path):
    paths = save_data_plots(describe_data(folder), tmp_path / "plots")
    assert len(paths) == 6
    assert all(path.stat().st_size > 2000 for path in paths)


def test_sound_data_has_no_faults(folder):
    assert find_data_faults(folder) == []


def test_a_cut_file_is_found_and_named(folder):
    path = folder / "episodes" / "b.parquet"
    path.write_bytes(path.read_bytes()[:-200])
    assert [str(path) in fault for fault in find_data_faults(folder)] == [True]
    with pytest.raises(InputError, match=r"Not a recording: .*b\.parquet.* Remove it"):
        describe_data(folder)


def test_an_episode_on_an_unknown_route_is_found(folder):
    record(folder / "episodes" / "c.parquet", "town09-long-0", speed=1.0)
    assert ["town09-long-0 is in none" in fault for fault in find_data_faults(folder)] == [True]


@pytest.mark.parametrize(
    "told", [{"hazards": 5}, {"hazards": [["cut_in"]]}, {"hazards": "ab"}, {"town": []}]
)
def test_a_recording_that_does_not_say_what_it_is_of_is_named(folder, told):
    record(folder / "episodes" / "c.parquet", "town01-left-0", speed=1.0, **told)

    with pytest.raises(InputError, match=r"Not a recording: .*c\.parquet") as caught:
        describe_data(folder)

    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(("speed", "place"), [(-3.0, 0), (1e30, -1)])
def test_speeds_that_no_car_has_are_counted_in_the_outer_bins(folder, speed, place):
    record(folder / "episodes" / "a.parquet", "town01-long-0", speed=speed)

    assert describe_data(folder).speeds[place] >= 3


def test_an_empty_folder_is_an_input_error(tmp_path):
    for look in (describe_data, find_data_faults):
        with pytest.raises(InputError, match="There is no data in"):
            look(tmp_path)
