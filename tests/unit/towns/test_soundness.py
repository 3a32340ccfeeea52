"""Small towns made by hand, each with one fault."""

from dataclasses import replace

import numpy as np
import pytest

from plant_bench.towns.drivable import drive_all, find_undrivable
from plant_bench.towns.town_checks import find_dead_lanes, find_missing, find_unreachable
from plant_bench.towns.town_spec import Requirements
from plant_bench.towns.town_summary import summarise
from plant_bench.world.town import Junction, Link, Town
from tests.builders import make_lane

SIDE = 60.0


def arc(radius, begin, finish):
    angles = np.linspace(begin, finish, 200)
    return radius * np.stack([np.cos(angles), np.sin(angles), 0 * angles], axis=1)


def lane(name, points, successors, junction=None):
    return make_lane(
        f"{name}_0", points, speed_limit=13.88, junction=junction, successors=successors
    )


def link(source, target):
    return Link(f"{source}_0", f"{target}_0", (), "j", "straight", "major")


@pytest.fixture
def ring():
    """A circle of two lanes, each leading to the other."""
    lanes = [
        lane("a", arc(SIDE, 0, np.pi), ("b_0",)),
        lane("b", arc(SIDE, np.pi, 2 * np.pi), ("a_0",)),
    ]
    junctions = {"j": Junction("j", "joint", SIDE, 0.0, 2, ())}
    links = (link("a", "b"), link("b", "a"))
    return Town("ring", {x.id: x for x in lanes}, links, junctions, {})


def with_lane(town, name, points):
    lanes = {**town.lanes, f"{name}_0": replace(town.lanes[f"{name}_0"], points=points)}
    return replace(town, lanes=lanes)


def test_circular_road_is_sound(ring):
    assert find_dead_lanes(ring) + find_unreachable(ring) + find_undrivable(ring) == []
    assert min(drive.radius for drive in drive_all(ring)) == pytest.approx(SIDE, rel=0.05)


def test_a_gap_between_lanes_is_found(ring):
    moved = with_lane(ring, "b", arc(SIDE, np.pi, 2 * np.pi) + np.array([0.0, 0.5, 0.0]))
    assert any("gap of 0.50" in fault for fault in find_undrivable(moved))


def test_a_corner_without_a_bend_is_found(ring):
    corner = np.array([[-SIDE, 0, 0], [-SIDE, -SIDE, 0], [SIDE, -SIDE, 0], [SIDE, 0, 0.0]])
    faults = find_undrivable(with_lane(ring, "b", corner))
    assert any("bends with a radius" in fault for fault in faults)
    assert any("cannot be followed" in fault for fault in faults)


def test_dead_end_lane_is_found(ring):
    town = replace(ring, links=ring.links[:1])
    faults = find_dead_lanes(town)
    assert faults == ["lane a_0 has no predecessor", "lane b_0 has no successor"]
    assert len(find_unreachable(town)) == 1


def test_features_required_by_the_spec_are_counted(ring):
    assert find_missing(ring, Requirements()) == []
    assert find_missing(ring, Requirements(roundabouts=1)) == [
        "expected 1 or more roundabouts, got 0"
    ]


def test_edge_above_another_counts_as_a_bridge(ring):
    line = np.array([[-90.0, 10.0, 7.0], [90.0, 10.0, 7.0]])
    above = replace(ring, lanes={**ring.lanes, "c_0": lane("c", line, ())})
    level = replace(ring, lanes={**ring.lanes, "c_0": lane("c", line * [1, 1, 0], ())})
    assert summarise(above).bridges == 1
    assert summarise(level).bridges == 0
