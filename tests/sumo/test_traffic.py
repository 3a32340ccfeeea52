"""Mixed traffic: each town's own mix, on suitable roads, without overlaps."""

import math
from collections import Counter
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from plant_bench.data_files import networks_dir
from plant_bench.geometry.box import overlap
from plant_bench.sim.entry_lanes import StreetGrid
from plant_bench.sim.sumo import Sumo, VehicleState
from plant_bench.sim.traffic import MANAGE_INTERVAL, Traffic
from plant_bench.sim.vehicle_types import VehicleType
from plant_bench.world.route import load_suite
from plant_bench.world.scene import ActorKind
from plant_bench.world.town import Life, Town, load_town

pytestmark = pytest.mark.sumo
Look = list[tuple[VehicleType, VehicleState]]


@cache
def watch(town: Town, seed: int, ticks: int = 300) -> list[Look]:
    """Return the vehicles around an ego that stands at the start of a route, every 3 s."""
    routes = [route for route in load_suite("longest6") if route.town == town.name]
    route, looks = routes[seed], []
    x, y = route.points[0].tolist()
    with Sumo(networks_dir() / town.name / "town.net.xml", seed) as sumo:
        traffic = Traffic(sumo, StreetGrid(town), 20.0, seed)
        sumo.add_ego(route.edges, x, y, float(route.headings[0]))
        traffic.fill(x, y)
        for tick in range(ticks):
            if tick % MANAGE_INTERVAL == 0:
                traffic.manage(x, y)
            sumo.move_ego(x, y, float(route.headings[0]), 0.0)
            sumo.step()
            if tick % 60 == 0:
                states = {vehicle: sumo.state_of(vehicle) for vehicle in sumo.vehicles()}
                looks.append([(traffic.types[v], state) for v, state in states.items() if state])
    return looks


@cache
def city() -> list[Look]:
    town = load_town("town03")
    return [look for seed in range(6) for look in watch(town, seed)]


def shares(looks: list[Look]) -> dict[ActorKind, float]:
    kinds = Counter(row.kind for look in looks for row, _ in look)
    return {kind: count / kinds.total() for kind, count in kinds.items()}


def test_city_traffic_has_its_own_mix() -> None:
    seen = shares(city())
    for name, share in load_town("town03").life.mix.items():
        assert seen[ActorKind[name.upper()]] == pytest.approx(share, abs=0.05), name


def test_bicycles_are_slower_than_cars() -> None:
    top: dict[ActorKind, float] = {}
    for row, state in (seen for look in city() for seen in look):
        top[row.kind] = max(top.get(row.kind, 0.0), state.speed)
    assert 4.0 < top[ActorKind.BICYCLE] < 7.1
    assert top[ActorKind.CAR] > 9.0


def test_vehicles_do_not_overlap() -> None:
    for look in city():
        extents = np.array([(row.length, row.width) for row, _ in look])
        poses = np.array(
            [
                (
                    s.x - 0.5 * t.length * math.cos(s.yaw),
                    s.y - 0.5 * t.length * math.sin(s.yaw),
                    s.yaw,
                )
                for t, s in look
            ]
        )
        one, other = np.triu_indices(len(look), 1)
        hit = overlap(poses[one], extents[one], poses[other], extents[other])
        assert not hit.any(), [
            (look[i], look[j]) for i, j in zip(one[hit], other[hit], strict=True)
        ]


def test_highway_traffic_has_trucks_and_few_bicycles() -> None:
    seen = shares(watch(load_town("town06"), 0))
    assert seen[ActorKind.TRUCK] == pytest.approx(0.19, abs=0.06)
    assert seen.get(ActorKind.BICYCLE, 0.0) < 0.06


def test_town_with_cars_only_has_no_other_vehicles() -> None:
    town = replace(load_town("town02"), life=Life({"car": 1.0}))
    assert shares(watch(town, 0, 61)) == {ActorKind.CAR: 1.0}
