"""Routes of each vehicle kind: endless, and only on roads it may use."""

import random
from functools import cache
from itertools import pairwise

import numpy as np
import pytest

from plant_bench.sim.entry_lanes import BICYCLE_LIMIT, ROUTE_AHEAD, SIZES, StreetGrid
from plant_bench.sim.long_vehicles import fits
from plant_bench.world.scene import ActorKind
from plant_bench.world.town import load_town


@cache
def streets(name: str) -> StreetGrid:
    return StreetGrid(load_town(name))


def walks(name: str, kind: ActorKind, count: int = 60) -> list[tuple[str, ...]]:
    """Walks from places open to a kind, each continued once."""
    grid, draw = streets(name), random.Random(5)
    found = []
    for place in draw.choices(np.flatnonzero(grid.open_to(kind)).tolist(), k=count):
        walk = grid.walk_from(grid.lanes[grid.lane_of[place]], kind, draw)
        found.append((*walk, *grid.walk(walk[-1], kind, draw)))
    return found


@pytest.mark.parametrize("name", ["town02", "town04", "town06"])
def test_bicycles_keep_to_slow_roads(name: str) -> None:
    town = streets(name).town
    for walk in walks(name, ActorKind.BICYCLE):
        assert all(lane.speed_limit <= BICYCLE_LIMIT for edge in walk for lane in town.edges[edge])


@pytest.mark.parametrize("kind", [ActorKind.TRUCK, ActorKind.BUS])
@pytest.mark.parametrize("name", ["town02", "town03"])
def test_long_vehicles_avoid_tight_turns(name: str, kind: ActorKind) -> None:
    town = streets(name).town
    edge_of = {lane.id: lane.edge for lane in town.lanes.values()}
    tight = {
        (edge_of[link.source], edge_of[link.target])
        for link in town.links
        if not fits(town, link, *SIZES[kind])
    }
    assert tight
    for walk in walks(name, kind):
        assert tight.isdisjoint(pairwise(walk))


@pytest.mark.parametrize("kind", list(SIZES))
@pytest.mark.parametrize("name", ["town02", "town04"])
def test_random_routes_are_long_enough_and_follow_links(name: str, kind: ActorKind) -> None:
    town = streets(name).town
    edge_of = {lane.id: lane.edge for lane in town.lanes.values()}
    steps = {(edge_of[link.source], edge_of[link.target]) for link in town.links}
    for walk in walks(name, kind, 20):
        assert sum(town.edges[edge][0].length for edge in walk) > 2 * ROUTE_AHEAD
        assert steps.issuperset(pairwise(walk))


def test_bicycle_on_a_highway_still_has_a_route() -> None:
    grid = streets("town04")
    fast = [edge for edge, lanes in grid.town.edges.items() if lanes[0].speed_limit > 20.0]
    assert grid.walk(fast[0], ActorKind.BICYCLE, random.Random(1))


def test_cars_may_enter_everywhere() -> None:
    assert streets("town02").open_to(ActorKind.CAR).all()
    assert 0.0 < streets("town04").open_to(ActorKind.BICYCLE).mean() < 0.5
