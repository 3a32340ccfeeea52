"""The towns: as specified, sound, and reproducible byte for byte."""

import json
from itertools import pairwise

import numpy as np
import pytest

from plant_bench.data_files import networks_dir
from plant_bench.errors import InputError
from plant_bench.towns.drivable import drive_all
from plant_bench.towns.generate import (
    build_town,
    check_town,
    make_town,
    town_names,
    town_spec,
)
from plant_bench.towns.netconvert import sumo_errors
from plant_bench.towns.town_checks import find_dead_lanes, find_missing, find_unreachable
from plant_bench.towns.town_summary import summarise
from plant_bench.towns.unseen_towns import UNSEEN
from plant_bench.world.town import Town, load_town

pytestmark = pytest.mark.sumo

TOWNS = [f"town0{number}" for number in range(1, 7)]
GRADE_MAX = 0.06


@pytest.fixture(scope="module", params=TOWNS)
def name(request):
    return request.param


@pytest.fixture(scope="module")
def town(name):
    return load_town(name)


def test_all_six_towns_are_found():
    assert town_names() == TOWNS


def test_same_spec_and_seed_give_identical_files(name):
    assert check_town(name) == []


@pytest.mark.parametrize("unseen", UNSEEN)
def test_unseen_towns_are_sound_and_reproducible(unseen):
    assert check_town(unseen) == []


def test_sumo_loads_the_network_without_warnings(name):
    net = (networks_dir() / name / "town.net.xml").read_text(encoding="utf-8")
    assert "<!--" not in net
    assert sumo_errors(net) == []


def test_network_is_strongly_connected_without_dead_lanes(town):
    assert find_unreachable(town) == []
    assert find_dead_lanes(town) == []


def test_bicycle_model_can_follow_every_path(town):
    drives = drive_all(town)
    assert len(drives) > len(town.links)
    assert max(drive.error for drive in drives) <= 0.35
    assert min(drive.radius for drive in drives) >= 4.5
    assert max(drive.gap for drive in drives) < 0.1


def test_town_contains_what_its_spec_requires(name, town):
    assert find_missing(town, town_spec(name).requires) == []


def test_roads_are_not_steep(town):
    for lane in town.lanes.values():
        rise, run = np.abs(np.diff(lane.points[:, 2])), np.diff(lane.along)
        assert (rise <= GRADE_MAX * run + 0.03).all(), lane.id


def test_links_and_lanes_are_consistent(town):
    for link in town.links:
        chain = (link.source, *link.via, link.target)
        for here, onward in pairwise(chain):
            assert onward in town.lanes[here].successors
        assert (link.signal is not None) == (link.control == "signal")


def test_stored_town_survives_a_round_trip(name, town):
    text = (networks_dir() / name / "town.json").read_text(encoding="utf-8")
    assert town.to_json() == text
    assert Town.from_json(text).to_json() == text
    assert json.loads(text)["name"] == name


def test_another_seed_gives_a_different_sound_town(name, town):
    _, other = make_town(town_spec(name), town_spec(name).seed + 40)
    assert other.to_json() != town.to_json()


def test_towns_have_their_documented_character():
    found = {name: summarise(load_town(name)) for name in TOWNS}
    assert found["town01"].signalled_t_junctions >= 10
    assert found["town01"].multi_lane_km == 0
    assert found["town02"].signals >= 8
    assert found["town02"].extent[0] < 230
    assert found["town03"].roundabouts == 1
    assert found["town03"].large_junctions == 1
    assert found["town04"].bridges >= 4
    assert min(found["town04"].on_ramps, found["town04"].off_ramps) >= 3
    assert found["town05"].signalled_crossroads >= 3
    assert found["town06"].u_turns == 4
    assert min(found["town06"].on_ramps, found["town06"].off_ramps) >= 6


def test_town_is_built_into_the_given_folder(tmp_path):
    folder = build_town("town02", seed=77, out=tmp_path / "new")
    files = sorted(path.name for path in folder.iterdir())
    assert files == ["picture.png", "town.json", "town.net.xml"]
    assert (folder / "picture.png").stat().st_size < 150_000


def test_unknown_town_is_refused_with_the_known_names():
    with pytest.raises(InputError, match="town01"):
        build_town("town99")


def test_impossible_town_is_refused_and_nothing_is_written(monkeypatch, tmp_path):
    spec = town_spec("town02")
    wanted = spec.requires.model_copy(update={"roundabouts": 1})
    impossible = spec.model_copy(update={"requires": wanted})
    monkeypatch.setattr("plant_bench.towns.generate.town_spec", lambda _: impossible)
    monkeypatch.setattr("plant_bench.towns.generate.ATTEMPTS", 1)
    with pytest.raises(InputError, match="roundabouts"):
        build_town("town02", out=tmp_path / "none")
    assert not (tmp_path / "none").exists()
