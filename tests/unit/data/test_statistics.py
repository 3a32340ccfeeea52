"""Statistics of a small hand-made data folder, counted by hand."""

import json

import pytest

from plant_bench.data.recorder import Recorder
from plant_bench.data.statistics import describe_data, find_data_faults
from plant_bench.errors import InputError
from plant_bench.reports.data_card import data_card
from plant_bench.reports.data_plots import save_data_plots
from plant_bench.runner.collect.data_folder import EpisodeNote
from plant_bench.runner.collect.request import CollectRequest
from plant_bench.world.route import ROUTE_FORMAT
from tests.builders import first_lane, make_actors, make_ego, make_scene, straight_route


def save_routes(path, *names):
    about = {
        "town": "town01",
        "lane": first_lane("town01"),
        "speed_limit": 8.0,
        "manoeuvres": {"left": 1, "right": 0},
    }
    routes = [straight_route(40, name=name, **about).to_payload() for name in names]
    path.parent.mkdir(parents=True)
    path.write_text(json.dumps({"format": ROUTE_FORMAT, "routes": routes}))


HAZARDS = [{"kind": "cut_in", "phase": "done"}, {"kind": "crossing", "phase": "void"}]


def record(path, route, *, speed, **told):
    """21 ticks, 3 frames: two actors near the ego, one out of reach; perturbed from tick 10 on."""
    about = {"route": route, "town": "town01", "hazards": HAZARDS} | told
    recorder = Recorder(path, about, every=10)
    for tick in range(21):
        x = tick * 0.05 * speed
        actors = make_actors([(x + 10, 0), (x, -29), (x, 31)], extents=(1.0, 1.0))
        scene = make_scene(tick, ego=make_ego(speed, x=x), actors=actors)
        recorder.add(scene, disturbed=tick >= 10)
    recorder.close()


@pytest.fixture
def folder(tmp_path):
    data = tmp_path / "data"
    save_routes(data / "routes" / "town01.json", "town01-long-0", "town01-left-0")
    record(data / "episodes" / "a.parquet", "town01-long-0", speed=10.0)
    record(data / "episodes" / "b.parquet", "town01-left-0", speed=0.0)
    return data


def test_statistics_count_frames_actors_and_hazards(folder):
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


def test_data_card_says_that_the_expert_drove(folder):
    data, notes = describe_data(folder), [EpisodeNote(route="a", status="Completed", collisions=3)]
    card = data_card(data, CollectRequest(6, seed=2, perturb=0.3), notes, "mine")
    command = "`plant-bench collect --out mine --frames 6 --seed 2 --density dense --perturb 0.3`"
    assert command in card
    assert "the expert, an algorithm" in card
    assert "not for training" in card
    assert "Collisions caused by other actors, in the included episodes: 3." in card
    assert "frames during a perturbation" in card


def test_data_card_names_the_driver_of_a_dagger_collection(folder):
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


def test_plots_of_the_statistics_are_saved(folder, tmp_path):
    paths = save_data_plots(describe_data(folder), tmp_path / "plots")
    assert len(paths) == 6
    assert all(path.stat().st_size > 2000 for path in paths)


def test_check_of_sound_data_finds_no_faults(folder):
    assert find_data_faults(folder) == []


def test_check_names_a_truncated_file(folder):
    path = folder / "episodes" / "b.parquet"
    path.write_bytes(path.read_bytes()[:-200])
    assert [str(path) in fault for fault in find_data_faults(folder)] == [True]
    with pytest.raises(InputError, match=r"Not a recording: .*b\.parquet.* Remove it"):
        describe_data(folder)


def test_check_finds_an_episode_on_an_unknown_route(folder):
    record(folder / "episodes" / "c.parquet", "town09-long-0", speed=1.0)
    assert [
        "its route town09-long-0 is missing" in fault for fault in find_data_faults(folder)
    ] == [True]


@pytest.mark.parametrize(
    "told", [{"hazards": 5}, {"hazards": [["cut_in"]]}, {"hazards": "ab"}, {"town": []}]
)
def test_recording_with_incomplete_metadata_is_refused_by_name(folder, told):
    record(folder / "episodes" / "c.parquet", "town01-left-0", speed=1.0, **told)

    with pytest.raises(InputError, match=r"Not a recording: .*c\.parquet") as caught:
        describe_data(folder)

    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(("speed", "place"), [(-3.0, 0), (1e30, -1)])
def test_out_of_range_speeds_are_counted_in_the_outer_bins(folder, speed, place):
    record(folder / "episodes" / "a.parquet", "town01-long-0", speed=speed)

    assert describe_data(folder).speeds[place] >= 3


def test_empty_folder_raises_input_error(tmp_path):
    for look in (describe_data, find_data_faults):
        with pytest.raises(InputError, match="There is no data in"):
            look(tmp_path)
