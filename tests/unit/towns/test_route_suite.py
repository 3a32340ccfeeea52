"""Properties of every stored route of both suites."""

import math
import subprocess
import sys
from collections import Counter
from itertools import combinations, pairwise

import numpy as np
import pytest

from plant_bench.data_files import routes_dir
from plant_bench.errors import InputError
from plant_bench.geometry.polyline import Cursor, distance_to
from plant_bench.geometry.pose import wrap_angles
from plant_bench.towns.route_choice import distance_by_edge, overlap_share
from plant_bench.towns.route_making import MANOEUVRES
from plant_bench.towns.routes import SUITES, build_suite, describe_suite
from plant_bench.world.route import load_suite
from plant_bench.world.town import load_town

ROUTES = [route for suite in SUITES for route in load_suite(suite)]
TOWNS = {name: load_town(name) for name in sorted({route.town for route in ROUTES})}

every_route = pytest.mark.parametrize("route", ROUTES, ids=[route.id for route in ROUTES])
every_suite = pytest.mark.parametrize("suite", SUITES)


@every_suite
def test_each_town_has_six_routes_of_the_longest6_lengths(suite):
    routes, wanted = load_suite(suite), SUITES[suite].lengths
    assert [route.id for route in routes] == [f"{town}-{i}" for town in wanted for i in range(6)]
    for name, targets in wanted.items():
        lengths = [route.length for route in routes if route.town == name]
        for length, target in zip(lengths, targets, strict=True):
            assert 0.9 * target < length < 1.01 * target
    assert 52_000 < sum(route.length for route in routes) < 56_500


def test_routes_of_a_town_share_at_most_two_thirds():
    for one, other in combinations(ROUTES, 2):
        if one.town == other.town:
            assert overlap_share(distance_by_edge(one), distance_by_edge(other)) <= 2 / 3


@every_suite
def test_suite_contains_every_manoeuvre(suite):
    counts = Counter[str]()
    for route in load_suite(suite):
        counts.update(route.manoeuvres)
    assert all(counts[kind] > 0 for kind in MANOEUVRES)


@every_route
def test_route_points_are_1_m_apart_and_smooth(route):
    steps = np.diff(route.points, axis=0)
    spacing = np.hypot(*steps.T)
    assert spacing.min() > 0.9
    assert spacing.max() < 1.1
    bends = wrap_angles(np.diff(np.arctan2(steps[:, 1], steps[:, 0])))
    assert np.degrees(np.abs(bends).max()) < 12.0
    assert np.abs(np.diff(route.elevations)).max() < 0.15


@every_route
def test_speed_limits_suit_lanes_and_curves(route):
    town = TOWNS[route.town]
    assert route.speed_limits.min() >= 3.0
    assert route.speed_limits.max() <= max(
        town.lanes[span.lane].speed_limit for span in route.lanes
    )


@every_route
def test_route_lanes_are_linked_and_cover_the_route(route):
    lanes = TOWNS[route.town].lanes
    assert route.lanes[0].start == 0.0
    assert route.lanes[-1].end == pytest.approx(route.length, abs=0.01)
    for span, after in pairwise(route.lanes):
        assert span.end == after.start
        lane = lanes[span.lane]
        assert after.lane in (*lane.successors, lane.left, lane.right)
    edges = [lanes[span.lane].edge for span in route.lanes if lanes[span.lane].junction is None]
    driven = [edge for edge, after in zip(edges, [*edges[1:], ""], strict=True) if edge != after]
    assert list(route.edges[: len(driven)]) == driven
    assert len(driven) == len(set(driven)), "an edge is driven twice"
    assert len(route.edges) > len(driven), "the route must go on beyond its destination"


@every_route
def test_route_edges_are_linked(route):
    town = TOWNS[route.town]
    linked = {(town.lanes[k.source].edge, town.lanes[k.target].edge) for k in town.links}
    assert all(pair in linked for pair in pairwise(route.edges))


@every_route
def test_passages_are_ordered_and_do_not_overlap_lane_changes(route):
    for one, after in pairwise(route.passages):
        assert one.exit <= after.entry
    for passage in route.passages:
        assert 10.0 < passage.entry <= passage.exit < route.length - 10.0
        assert TOWNS[route.town].junctions[passage.junction].kind != "joint"
        assert (passage.signal is None) == (passage.signal_index < 0)
        for change in route.lane_changes:
            assert change.end < passage.entry - 10.0 or change.start > passage.exit + 5.0
    for one, after in pairwise(route.lane_changes):
        assert one.end < after.start - 4.0
    for change in route.lane_changes:
        assert change.end - change.start > 19.5
    counted = route.manoeuvres["lane_change"]
    assert len(route.lane_changes) == counted


@every_route
def test_route_points_are_on_lane_centres_outside_lane_changes(route):
    lanes = TOWNS[route.town].lanes
    for span in route.lanes:
        inside = (route.along > span.start + 0.5) & (route.along < span.end - 0.5)
        for change in route.lane_changes:
            inside &= (route.along < change.start) | (route.along > change.end)
        centre = lanes[span.lane].points[:, :2]
        for x, y in route.points[inside]:
            assert distance_to(centre, float(x), float(y)) < 0.3


@every_route
def test_bicycle_model_can_follow_the_route(route):
    """Pure pursuit with a kinematic bicycle, its reference the box centre."""
    wheelbase, most, speed, tick, reach = 2.86, 0.61, 5.0, 0.05, 4.0
    x, y, yaw = *route.points[0], route.headings[0]
    cursor, worst = Cursor(route.points), 0.0
    for _ in range(int(1.1 * route.length / (speed * tick))):
        cursor.advance(float(x), float(y))
        worst = max(worst, abs(cursor.offset))
        if cursor.progress > route.length - reach:
            break
        at = cursor.progress + reach
        goal_x, goal_y = (np.interp(at, route.along, column) for column in route.points.T)
        rear_x, rear_y = x - 0.5 * wheelbase * math.cos(yaw), y - 0.5 * wheelbase * math.sin(yaw)
        bearing = math.atan2(goal_y - rear_y, goal_x - rear_x) - yaw
        distance = math.hypot(goal_x - rear_x, goal_y - rear_y)
        steering = math.atan2(2.0 * wheelbase * math.sin(bearing), distance)
        steering = min(max(steering, -most), most)
        slip = math.atan(0.5 * math.tan(steering))
        x += speed * tick * math.cos(yaw + slip)
        y += speed * tick * math.sin(yaw + slip)
        yaw += speed * tick * math.cos(slip) * math.tan(steering) / wheelbase
    assert cursor.progress > route.length - reach - 1.0
    assert worst < 0.5


@every_route
def test_stored_routes_equal_the_generated_ones(route):
    again = type(route).from_payload(route.to_payload())
    assert again.checksum == route.checksum


def test_description_has_a_row_per_route():
    table = describe_suite(ROUTES)
    assert list(table["id"]) == [route.id for route in ROUTES]
    assert float(table["max_share"].to_numpy().max()) <= 2 / 3
    assert set(MANOEUVRES) < set(table.columns)


# Building runs in its own process, where types are not checked at every call: ten times faster.
@pytest.mark.parametrize(("suite", "town"), [("longest6", "town02"), ("unseen", "unseen01")])
def test_rebuilding_routes_in_another_process_is_identical(suite, town, tmp_path):
    folder = tmp_path / suite
    code = (
        "import sys; from pathlib import Path; from plant_bench.towns.routes import build_suite; "
        "build_suite(sys.argv[2], towns=[sys.argv[3]], out=Path(sys.argv[1]))"
    )
    subprocess.run([sys.executable, "-c", code, str(folder), suite, town], check=True)
    assert [path.name for path in folder.iterdir()] == [f"{town}.json"]
    stored = routes_dir() / suite / f"{town}.json"
    assert (folder / f"{town}.json").read_bytes() == stored.read_bytes()
    assert [path.name for path in tmp_path.iterdir()] == [suite], "no scratch is left"


@pytest.mark.slow
@every_suite
def test_rebuilding_the_suite_is_identical(suite):
    code = f"from plant_bench.towns.routes import check_suite; print(check_suite('{suite}'))"
    done = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True)
    assert done.stdout == "[]\n"


def test_unknown_suite_and_town_are_refused(tmp_path):
    with pytest.raises(InputError, match="no suite 'longest7'"):
        build_suite("longest7", out=tmp_path)
    with pytest.raises(InputError, match="no town 'town99'"):
        build_suite(towns=["town99"], out=tmp_path)
