"""Both careful drivers among pedestrians, parked cars, cyclists and buses on a straight road.

The road is y = 0, the ego's lane 3.2 m wide, the kerb 1.6 m to the right of it.
"""

import math
from dataclasses import replace

import numpy as np
import pytest

from plant_bench.agent import Control, Observation
from plant_bench.agents.careful.driver import CarefulDriver
from plant_bench.agents.careful.forecast import along_true_lanes, straight_on
from plant_bench.world.route import Passage, Route
from plant_bench.world.scene import TICK, ActorKind, Actors
from tests.builders import make_actors, observation_on, straight_lane_facts, straight_route

LIMIT = 8.3  # m/s, 30 km/h
KERB = -1.6
EXTENTS = {
    ActorKind.CAR: (4.5, 1.8),
    ActorKind.BUS: (10.0, 2.5),
    ActorKind.TRUCK: (8.0, 2.4),
    ActorKind.BICYCLE: (1.6, 0.65),
    ActorKind.MOTORCYCLE: (2.2, 0.9),
    ActorKind.PEDESTRIAN: (0.3, 0.5),
}
BOTH = pytest.mark.parametrize("forecaster", [along_true_lanes, straight_on])
Row = tuple[ActorKind, float, float, float, float]


def route(*passages: Passage) -> Route:
    return straight_route(400, speed_limit=LIMIT, passages=passages)


def street(*rows: Row) -> Actors:
    """Return actors of the given kind, x, y, yaw and speed."""
    return make_actors(
        [row[1:4] for row in rows],
        speeds=[row[4] for row in rows],
        extents=[EXTENTS[row[0]] for row in rows],
        kinds=[row[0] for row in rows],
    )


def observe(actors: Actors, at: float, speed: float) -> Observation:
    """All drive straight on; those who are stationary have to stay so."""
    stops = np.where(actors.speeds < 0.1, 0.0, math.inf)
    facts = straight_lane_facts(actors, desired_speeds=LIMIT, stop_distances=stops)
    return observation_on(route(), at, speed=speed, actors=actors, privileged=facts)


def drive(
    driver: CarefulDriver, actors: Actors, seconds: float, speed: float = LIMIT, wobble: float = 0.0
) -> tuple[np.ndarray, np.ndarray]:
    """Drive among actors at constant velocity; return the ego's positions and accelerations."""
    driver.reset(route())
    place, places, pulls = 20.0, [], []
    control = Control(0.0, 0.0)
    for tick in range(round(seconds / TICK)):
        if tick % 2 == 0:
            time = tick * TICK
            poses = actors.poses.copy()
            poses[:, 0] += time * actors.speeds * np.cos(actors.poses[:, 2])
            poses[:, 1] += time * actors.speeds * np.sin(actors.poses[:, 2])
            poses[:, 2] += wobble * math.sin(3.0 * time)
            control = driver.act(observe(replace(actors, poses=poses), place, speed))
            assert isinstance(control, Control)
        speed = max(0.0, speed + control.acceleration * TICK)
        place += speed * TICK
        places.append(place)
        pulls.append(control.acceleration)
    return np.array(places), np.array(pulls)


@BOTH
@pytest.mark.parametrize(
    "row",
    [
        (ActorKind.CAR, 45.0, KERB - 0.25 - 0.9, 0.0, 0.0),
        (ActorKind.BUS, 50.0, KERB - 0.25 - 1.25, 0.0, 0.0),
        (ActorKind.PEDESTRIAN, 50.0, KERB - 0.4, math.pi / 2, 0.0),
        (ActorKind.PEDESTRIAN, 40.0, KERB - 0.8, 0.0, 1.4),
        (ActorKind.PEDESTRIAN, 55.0, KERB - 0.8, math.pi, 1.4),
        (ActorKind.BICYCLE, 70.0, 3.2, math.pi, 5.0),
        (ActorKind.BUS, 80.0, 3.2, math.pi, LIMIT),
    ],
    ids=["parked", "parked bus", "at the kerb", "walks along", "walks back", "rider", "bus"],
)
def test_actors_beside_the_lane_are_passed_at_full_speed(forecaster, row: Row) -> None:
    places, pulls = drive(CarefulDriver(forecaster), street(row), 6.0)
    assert places[-1] > 20.0 + 5.9 * LIMIT
    assert pulls.min() > -0.5


@BOTH
def test_a_row_of_parked_cars_is_passed(forecaster) -> None:
    side = KERB - 0.25 - 0.9
    parked = street(*((ActorKind.CAR, x, side, 0.0, 0.0) for x in range(30, 120, 6)))
    assert drive(CarefulDriver(forecaster), parked, 10.0)[0][-1] > 20.0 + 9.9 * LIMIT


@BOTH
def test_ego_waits_for_a_crossing_pedestrian_and_drives_on(forecaster) -> None:
    walker = street((ActorKind.PEDESTRIAN, 50.0, -4.5, math.pi / 2, 1.3))
    places, _ = drive(CarefulDriver(forecaster), walker, 15.0)
    ticks = np.arange(len(places)) * TICK
    side = -4.5 + 1.3 * ticks
    near = np.abs(side) < 1.065 + 0.3
    ego_front = places + 2.45
    assert (ego_front[near] < 50.0 - 0.5).all()
    assert places[-1] > 80.0


@BOTH
def test_ego_waits_for_a_pedestrian_standing_on_the_crossing(forecaster) -> None:
    walker = street((ActorKind.PEDESTRIAN, 50.0, 0.3, math.pi / 2, 0.0))
    places, _ = drive(CarefulDriver(forecaster), walker, 20.0)
    assert 44.0 < places[-1] + 2.45 < 49.5


@BOTH
def test_ego_enters_a_junction_with_a_pedestrian_beyond_it(forecaster) -> None:
    passage = Passage("j", 40.0, 55.0, "right", "priority")
    walker = street((ActorKind.PEDESTRIAN, 54.0, -1.0, math.pi / 2, 1.3))
    driver = CarefulDriver(forecaster)
    driver.reset(route(passage))
    halted = driver.act(observe(walker, 37.0, 0.0))
    assert halted.acceleration > 0.2


@BOTH
@pytest.mark.parametrize("kind", [ActorKind.BICYCLE, ActorKind.MOTORCYCLE, ActorKind.BUS])
def test_ego_follows_a_cyclist_without_hard_braking(forecaster, kind: ActorKind) -> None:
    rider = street((kind, 45.0, -0.9 if kind is ActorKind.BICYCLE else 0.0, 0.0, 4.5))
    places, pulls = drive(CarefulDriver(forecaster), rider, 22.0, wobble=0.08)
    gap = 45.0 + 4.5 * 22.0 - places[-1]
    settled = pulls[400:]
    assert 4.0 < gap < 16.0
    assert np.abs(settled).max() < 0.6
    assert pulls.min() > -3.5


@BOTH
def test_ego_stops_for_a_long_bus_across_the_road(forecaster) -> None:
    bus = street((ActorKind.BUS, 60.0, 1.0, math.pi / 2, 0.0))
    places, _ = drive(CarefulDriver(forecaster), bus, 15.0)
    assert places[-1] + 2.45 < 60.0 - 1.25


def test_forecast_pedestrians_stop_where_they_wait() -> None:
    walker = street((ActorKind.PEDESTRIAN, 50.0, -4.0, math.pi / 2, 1.4))
    observation = observe(walker, 20.0, LIMIT)
    assert observation.privileged is not None
    free = along_true_lanes(observation, np.array([0]))
    assert free.lengths[0] == pytest.approx(0.3)
    waits = replace(observation.privileged, stop_distances=np.array([0.1]))
    kerb = along_true_lanes(replace(observation, privileged=waits), np.array([0]))
    assert kerb.poses[0, -1, 1] == pytest.approx(-3.9, abs=1e-4)
