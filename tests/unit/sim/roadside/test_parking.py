"""Parked cars depend on the town, keep clear of lanes, and leave room for hazards."""

import numpy as np
import pytest

from plant_bench.sim.roadside.lane_distance import Roadway
from plant_bench.sim.roadside.parked_cars import (
    FROM_LANE,
    ParkedCars,
    parking_places,
)
from plant_bench.sim.scene_builder import join
from plant_bench.world.hazard import Hazard, HazardKind
from plant_bench.world.hazard_table import HAZARDS
from plant_bench.world.route import Scenario
from plant_bench.world.scene import Actors
from plant_bench.world.town import CARS_ONLY, Life, Town
from tests.builders import make_lane, straight_route


def street(parking: float, limit: float = 8.33) -> Town:
    lane = make_lane("s_1", [(0.0, 0.0), (200.0, 0.0)], speed_limit=limit)
    life = Life(CARS_ONLY.mix, 0.0, parking)
    return Town("street", {"s_1": lane}, (), {}, {}, life=life)


def scenario(seed: int, *hazards: Hazard) -> Scenario:
    route = straight_route(199, town="street", lane="s_1", speed_limit=8.0, hazards=hazards)
    return Scenario(route, seed, hazards=True)


def cars(seed: int, *hazards: Hazard) -> Actors:
    town = street(1.0)
    return ParkedCars(parking_places(town, Roadway(town)), scenario(seed, *hazards)).all


@pytest.mark.parametrize("limit", [8.33, 13.89])
def test_parked_cars_are_beside_the_lane_and_away_from_its_ends(limit: float) -> None:
    town = street(1.0, limit)
    places = parking_places(town, Roadway(town))
    assert len(places.poses) > 20
    left = places.poses[:, 1] + 0.5 * places.extents[:, 1]
    assert (left <= -1.75 - FROM_LANE).all()
    assert places.poses[:, 0].min() > 12.0
    assert places.poses[:, 0].max() < 188.0
    order = np.argsort(places.poses[:, 0])
    room = np.diff(places.poses[order, 0]) - places.extents[order, 0].max()
    assert room.min() > -1.0


@pytest.mark.parametrize(("parking", "limit"), [(0.0, 8.33), (1.0, 16.7)])
def test_no_parked_cars_at_zero_share_or_on_fast_roads(parking: float, limit: float) -> None:
    town = street(parking, limit)
    places = parking_places(town, Roadway(town))
    assert len(places.poses) == 0
    assert places.edges == frozenset()


def test_free_parking_places_depend_on_the_seed() -> None:
    town = street(1.0)
    count = len(parking_places(town, Roadway(town)).poses)
    taken = [cars(seed) for seed in range(40)]
    assert 0.6 < np.mean([len(some) for some in taken]) / count < 0.8
    assert not np.array_equal(taken[0].poses, taken[1].poses)
    assert np.array_equal(taken[0].poses, cars(0).poses)


@pytest.mark.parametrize("kind", [kind for kind in HAZARDS if HAZARDS[kind].kept_free])
def test_parked_cars_keep_clear_of_hazards(kind: HazardKind) -> None:
    near = cars(3, Hazard(kind, 100.0, 40.0, 1)).poses[:, 0] - 100.0
    assert np.abs(near).min() > HAZARDS[kind].kept_free
    assert len(near) < len(cars(3).ids)


def test_visible_parked_cars_keep_their_id_and_position() -> None:
    town = street(1.0)
    parked = ParkedCars(parking_places(town, Roadway(town)), scenario(1))
    parked.look(0.0, 0.0, 0.0, 80.0, 4.5)
    first = parked.seen
    parked.look(40.0, 0.0, 0.0, 80.0, 4.5)
    both = np.isin(parked.seen.ids, first.ids)
    assert both.any()
    assert len(first) < len(parked.seen)
    assert first.parked.all()
    facts = parked.facts(20)
    assert len(facts.paths) == len(parked.seen)
    assert (facts.paths == facts.paths[:, :1]).all()
    assert (facts.stopped_for == 1.0).all()
    parked.look(40.0, 0.0, 9.0, 80.0, 4.5)
    assert len(parked.seen) == 0  # the level above


def test_joined_actors_are_sorted_by_id_and_read_only() -> None:
    parked = cars(1)
    whole = join(Actors.none(), parked.only(np.arange(3)), parked.only(np.arange(3, 6)))
    assert whole.ids.tolist() == parked.ids[:6].tolist()
    with pytest.raises(ValueError, match="read-only"):
        whole.poses[0, 0] = 1.0
