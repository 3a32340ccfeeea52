import numpy as np
import pytest

from plant_bench.towns.highway import Branch, Carriageway, exit_shape, u_turn_shape
from plant_bench.towns.street_plan import Edge, StreetPlan
from plant_bench.towns.street_shapes import Pose, end_pose, tightest_radius
from plant_bench.towns.town_spec import RoadClass

RADIUS = 200.0


def ring(*branches):
    angles = np.linspace(0, 2 * np.pi, 1258)
    line = np.stack([RADIUS * np.cos(angles), RADIUS * np.sin(angles), 0 * angles], axis=1)
    road = RoadClass(lanes=3, speed_kmh=80.0)
    return Carriageway("ring", line, 2.0, road, 3.5, list(branches))


ON = Branch("on", 300.0, "right", "in", 100.0)
OFF = Branch("off", 900.0, "right", "out", 100.0)


def test_cut_of_a_ring_follows_the_offset_across_its_end():
    way = ring()
    piece = way.cut(way.total - 20, 20.0, left=-3.5)
    assert np.hypot(*piece[:, :2].T) == pytest.approx(RADIUS + 2.0 + 3.5, abs=0.02)


def test_an_extra_lane_exists_only_beside_its_ramp():
    way, plan = ring(ON, OFF), StreetPlan()
    way.add_to(plan)
    assert {e.id: e.lanes for e in plan.edges.values()} == {
        "ring_on": 4,
        "ring_on_end": 3,
        "ring_off_begin": 4,
        "ring_off": 3,
    }


def test_through_lanes_continue_and_the_acceleration_lane_ends():
    way, plan = ring(ON, OFF), StreetPlan()
    way.add_to(plan)
    for branch, ends in ((ON, ("ring_off", "ring_on")), (OFF, ("ring_off", "ring_on"))):
        plan.add_edge(Edge(branch.edge, *ends, 1, 10.0, np.eye(2), "ramp"))
    way.connect(plan)
    found = {(c.start, c.start_lane, c.end, c.end_lane) for c in plan.connections}
    assert {("ring_on", k + 1, "ring_on_end", k) for k in range(3)} <= found
    assert not any(start == "ring_on" and lane == 0 for start, lane, *_ in found)
    assert ("on", 0, "ring_on", 0) in found
    assert ("ring_off_begin", 0, "off", 0) in found


def test_exit_follows_the_bend_before_it_diverges():
    way = ring()
    shape = exit_shape(way, 100.0, Pose(0.0, 320.0, np.pi))
    away = np.hypot(*shape[:, :2].T)
    assert away[0] == pytest.approx(RADIUS + 2 + 3.5 * 3.5, abs=0.05)
    assert (np.diff(away[:40]) > -1e-6).all()
    assert tuple(shape[-1][:2]) == pytest.approx((0, 320))


def test_u_turn_returns_parallel_to_itself():
    shape = u_turn_shape(Pose(0.0, 0.0, 0.0), Pose(0.0, 14.0, np.pi), 14.0)
    assert end_pose(shape).heading == pytest.approx(np.pi, abs=0.05)
    assert tightest_radius(shape) == pytest.approx(7, rel=0.1)
