import math

import numpy as np
import pytest

from plant_bench.scoring.infractions import Status
from plant_bench.scoring.lanes import lane_map
from plant_bench.scoring.referee import ON_ROUTE_OFFSET, Referee
from plant_bench.world.route import Route, load_suite
from plant_bench.world.scene import Light
from plant_bench.world.town import load_town
from tests.builders import make_ego, make_scene

ROUTES = {route.id: route for route in load_suite("longest6")}
ONE_PER_TOWN = list({route.town: route for route in ROUTES.values()}.values())


def segments(route: Route, step: int):
    """Yield x, y, heading and height, every so many metres."""
    delta = np.diff(route.points, axis=0)
    yaw = np.arctan2(delta[:, 1], delta[:, 0])
    for index in range(0, len(delta), step):
        x, y = route.points[index].tolist()
        yield x, y, float(yaw[index]), float(route.elevations[index])


@pytest.mark.parametrize("name", list(ROUTES))
def test_positions_near_the_route_are_on_a_lane(name):
    """This is why the referee's shortcut cannot change a verdict."""
    route = ROUTES[name]
    lanes = lane_map(load_town(route.town))
    for x, y, yaw, z in segments(route, 20):
        for aside in (-ON_ROUTE_OFFSET, 0.0, ON_ROUTE_OFFSET):
            place = (x - aside * math.sin(yaw), y + aside * math.cos(yaw))
            assert not lanes.outside(*place, z, yaw), (x, y, aside)


@pytest.mark.parametrize("route", ONE_PER_TOWN, ids=lambda route: route.town)
def test_following_the_route_exactly_gives_no_infraction(route):
    referee = Referee(load_town(route.town), route)
    lights = np.full(len(route.signal_passages), Light.GREEN, np.uint8)
    for tick, (x, y, yaw, _) in enumerate(segments(route, 1)):
        referee.judge(make_scene(tick, ego=make_ego(20.0, x=x, y=y, yaw=yaw), lights=lights))
    referee.finish()
    assert referee.status is Status.COMPLETED
    assert referee.infractions == []


@pytest.mark.parametrize("route", ONE_PER_TOWN, ids=lambda route: route.town)
def test_driving_through_every_red_light_counts_each_one(route):
    referee = Referee(load_town(route.town), route)
    lights = np.full(len(route.signal_passages), Light.RED, np.uint8)
    for tick, (x, y, yaw, _) in enumerate(segments(route, 1)):
        referee.judge(make_scene(tick, ego=make_ego(20.0, x=x, y=y, yaw=yaw), lights=lights))
    assert len(referee.infractions) == len(lights) > 0
