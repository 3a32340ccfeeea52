"""Lane choice on hand-made towns: a feeder, a road of several lanes, and two ways on."""

import numpy as np
import pytest

from plant_bench.towns.route_graph import StreetGraph
from plant_bench.towns.route_lanes import change_spans, plan_lanes
from plant_bench.towns.route_line import trace_line
from plant_bench.towns.route_making import count_manoeuvres, make_route
from plant_bench.world.town import Junction, Link, Town
from tests.builders import make_lane

WIDTH = 3.5


def lane(edge, index, lanes, start, end, *, across=0.0, speed=13.89, acceleration=False):
    y = across + index * WIDTH
    return make_lane(
        f"{edge}_{index}",
        [(start, y), (end, y)],
        width=WIDTH,
        speed_limit=speed,
        left=f"{edge}_{index + 1}" if index + 1 < lanes else None,
        right=f"{edge}_{index - 1}" if index > 0 else None,
        acceleration=acceleration,
    )


def link(source, target, junction, turn="straight", control="major"):
    return Link(source, target, (), junction, turn, control)


def make_town(length=120.0, lanes=2, *, acceleration=False):
    """Feeder -> road -> `ahead` from its rightmost lane, `aside` from its leftmost."""
    road = [
        lane("road", i, lanes, 100.0, 100.0 + length, acceleration=acceleration and i == 0)
        for i in range(lanes)
    ]
    feeder = lane("feeder", 0, 1, 0.0, 100.0)
    ahead = lane("ahead", 0, 1, 100.0 + length, 300.0 + length)
    aside = lane("aside", 0, 1, 100.0 + length, 300.0 + length, across=(lanes - 1) * WIDTH)
    links = [
        link("feeder_0", "road_0", "joint"),
        link(f"road_{lanes - 1}", "aside_0", "fork", "left", "minor"),
    ]
    if not acceleration:
        links.append(link("road_0", "ahead_0", "fork"))
    junctions = {
        "joint": Junction("joint", "joint", 100.0, 0.0, 2, ()),
        "fork": Junction("fork", "priority", 100.0 + length, 0.0, 3, ()),
    }
    found = {item.id: item for item in (feeder, *road, ahead, aside)}
    return Town("hand_made", found, tuple(links), junctions, {})


def test_no_lane_change_is_planned_if_none_is_needed():
    plan = plan_lanes(StreetGraph(make_town()), ("feeder", "road", "ahead"))
    assert plan is not None
    assert plan.left == plan.entered == ("feeder_0", "road_0", "ahead_0")


def test_one_lane_change_is_planned_if_the_next_edge_requires_it():
    graph = StreetGraph(make_town())
    plan = plan_lanes(graph, ("feeder", "road", "aside"))
    assert plan is not None
    assert (plan.entered[1], plan.left[1]) == ("road_0", "road_1")
    assert count_manoeuvres(graph, plan)["lane_change"] == 1
    assert count_manoeuvres(graph, plan)["merge"] == 0


def test_the_start_is_on_the_lane_that_needs_no_change():
    plan = plan_lanes(StreetGraph(make_town()), ("road", "aside"))
    assert plan is not None
    assert plan.entered == ("road_1", "aside_0")


@pytest.mark.parametrize(("length", "found"), [(42.9, False), (43.1, True)])
def test_lane_change_needs_enough_length(length, found):
    graph = StreetGraph(make_town(length))
    assert (plan_lanes(graph, ("feeder", "road", "aside")) is not None) == found


def test_lane_changes_do_not_overlap():
    first, second = change_spans(make_town(90.0).lanes["road_0"], 2) or []
    assert first.start == 8.0
    assert second.start - first.end == pytest.approx(5.0)
    assert second.end == pytest.approx(90.0 - 15.0)
    assert first.end - first.start >= 20.0


def test_lane_changes_on_long_edges_end_before_the_queue():
    road = make_town(400.0).lanes["road_0"]
    (span,) = change_spans(road, 1) or []
    assert span.start > 8.0
    assert span.end <= 340.0
    assert span.end - span.start == pytest.approx(3.0 * road.speed_limit)


def test_an_acceleration_lane_is_left_in_its_middle():
    graph = StreetGraph(make_town(120.0, acceleration=True))
    (span,) = change_spans(graph.town.lanes["road_0"], 1) or []
    assert span.start >= 20.0
    assert span.end <= 105.0
    assert span.start - 20.0 == pytest.approx(105.0 - span.end)
    plan = plan_lanes(graph, ("feeder", "road", "aside"))
    assert plan is not None
    assert count_manoeuvres(graph, plan)["merge"] == 1


def test_route_line_moves_smoothly_between_lanes():
    town = make_town(120.0, lanes=3)
    plan = plan_lanes(StreetGraph(town), ("feeder", "road", "aside"))
    assert plan is not None
    line = trace_line(town, plan, 10.0, 100.0)
    x, y = line.points[:, 0], line.points[:, 1]
    assert x[0] == 10.0
    assert x[-1] == 320.0
    assert y[0] == 0.0
    assert y[-1] == 2 * WIDTH
    assert np.all(np.diff(y) >= -1e-9)
    assert np.all(np.diff(x) > 0.9)
    assert [change.direction for change in line.changes] == ["left", "left"]
    assert [span.lane for span in line.spans] == [
        "feeder_0", "road_0", "road_1", "road_2", "aside_0",
    ]  # fmt: skip
    middle = np.interp(line.changes[0].end, np.hypot(x - 10.0, 0.0), y)
    assert middle == pytest.approx(WIDTH, abs=0.05)


def test_route_has_its_passages_and_edges_past_its_end():
    graph = StreetGraph(make_town())
    plan = plan_lanes(graph, ("feeder", "road"))
    assert plan is not None
    route = make_route(graph, plan, name="x", start=10.0, end=60.0)
    assert route.passages == ()
    assert route.edges == ("feeder", "road", "ahead")
    plan = plan_lanes(graph, ("feeder", "road", "ahead"))
    assert plan is not None
    route = make_route(graph, plan, name="x", start=10.0, end=60.0)
    route.validate()
    assert [(p.junction, p.turn) for p in route.passages] == [("fork", "straight")]
    assert route.passages[0].entry == pytest.approx(210.0, abs=0.05)
    assert route.length == pytest.approx(270.0, abs=0.05)
    assert set(route.speed_limits) == {13.89}
