"""Properties of the hazards of every stored route of both suites."""

from collections import Counter
from itertools import pairwise

import pytest

from plant_bench.sim.vehicle_types import RIDER, WALKER
from plant_bench.towns.hazard_image import save_hazard_pictures
from plant_bench.towns.hazard_numbers import crossing_speeds
from plant_bench.towns.hazard_places import MARGIN, possible_places
from plant_bench.towns.route_hazards import SPACING, place_hazards
from plant_bench.towns.routes import SUITES
from plant_bench.world.crossing_distance import FARTHEST_START, meets_at, needed_start
from plant_bench.world.hazard import HazardKind
from plant_bench.world.hazard_table import HAZARDS
from plant_bench.world.route import load_suite
from plant_bench.world.scene import EGO_WIDTH
from plant_bench.world.town import load_town

ROUTES = [route for suite in SUITES for route in load_suite(suite)]
TOWNS = {name: load_town(name) for name in sorted({route.town for route in ROUTES})}
CROSSINGS = (HazardKind.CROSSING, HazardKind.CROSSING_AFTER_TURN)

every_route = pytest.mark.parametrize("route", ROUTES, ids=[route.id for route in ROUTES])


def lane_at(route, at):
    span = next(span for span in route.lanes if span.start <= at < span.end)
    return TOWNS[route.town].lanes[span.lane]


@every_route
def test_route_has_8_to_15_hazards_apart_from_each_other(route):
    places = [hazard.at for hazard in route.hazards]
    assert 8 <= len(places) <= 15
    assert all(after - one >= SPACING for one, after in pairwise(places))
    assert places[0] >= MARGIN
    assert places[-1] <= route.length - MARGIN
    assert all(0.0 <= hazard.arm < hazard.at for hazard in route.hazards)
    most = max(Counter(hazard.kind for hazard in route.hazards).values())
    assert 3 * most <= len(places)


@every_route
def test_crossing_hazards_are_on_slow_kerb_lanes_and_avoidable(route):
    for hazard in route.hazards:
        if hazard.kind in CROSSINGS:
            lane = lane_at(route, hazard.at)
            assert lane.speed_limit < 14.0
            assert lane.right is None
            assert hazard.parameters["side"] < 0 or lane.left is None
            limit = float(route.speed_limits[int(hazard.at)])
            who = RIDER if hazard.parameters["rider"] else WALKER
            fastest = hazard.parameters["speed"] * 1.1
            assert needed_start(fastest, limit, who.length) < FARTHEST_START + 0.5


@every_route
def test_junction_hazards_are_inside_suitable_passages(route):
    turns = {HazardKind.UNPROTECTED_LEFT: "left", HazardKind.RIGHT_TURN: "right"}
    signalled = (HazardKind.UNPROTECTED_LEFT, HazardKind.RED_LIGHT_RUNNER)
    for hazard in route.hazards:
        if hazard.kind in (*signalled, HazardKind.RIGHT_TURN, HazardKind.UNSIGNALLED_CROSSING):
            passage = next(p for p in route.passages if p.entry <= hazard.at <= p.exit)
            assert passage.turn == turns.get(hazard.kind, passage.turn)
            assert hazard.kind not in signalled or passage.signal is not None
            unsignalled = hazard.kind is HazardKind.UNSIGNALLED_CROSSING
            assert not unsignalled or passage.signal is None


@pytest.mark.parametrize("suite", SUITES)
def test_suite_has_about_12_hazards_per_route_of_all_kinds(suite):
    routes = load_suite(suite)
    counts = Counter(hazard.kind for route in routes for hazard in route.hazards)
    assert set(counts) == set(HazardKind)
    assert 11.5 <= counts.total() / len(routes) <= 12.5
    beyond = sum(counts[kind] for kind, facts in HAZARDS.items() if facts.carla is None)
    assert 0.25 < beyond / counts.total() < 0.4
    assert len({hazard.seed for route in routes for hazard in route.hazards}) == counts.total()


def test_hazard_placement_depends_only_on_the_seed():
    route = ROUTES[4]
    seed = SUITES["longest6"].seed
    assert place_hazards(TOWNS[route.town], route, seed) == route.hazards
    assert place_hazards(TOWNS[route.town], route, seed + 1) != route.hazards


def test_possible_places_are_on_the_route():
    route = ROUTES[12]
    places = possible_places(TOWNS[route.town], route)
    assert all(MARGIN < place.at < route.length - MARGIN for place in places)
    assert all(0.0 <= place.arm < place.at for place in places)


def test_crossing_starts_outside_the_stopping_distance_with_reaction():
    assert meets_at(WALKER.length) == pytest.approx(0.5 * (EGO_WIDTH + WALKER.length))
    seconds = 0.5 + 10.0 / 8.0 + 1.5 / 10.0  # reaction, braking with 4 m/s2, 1.5 m left over
    expected = meets_at(RIDER.length) + 2.0 * 1.15 * seconds
    assert needed_start(2.0, 10.0, RIDER.length) == pytest.approx(expected)


def test_crossing_speeds_depend_on_side_and_speed_limit():
    assert (
        crossing_speeds(8.3, rider=False, side=1)[0] > crossing_speeds(8.3, rider=False, side=-1)[0]
    )
    assert crossing_speeds(13.9, rider=True, side=-1)[1] < 4.0
    low, high = crossing_speeds(30.0, rider=True, side=-1)
    assert low > high, "nobody could survive that"


def test_each_kind_has_a_letter_and_a_picture(tmp_path):
    assert set(HAZARDS) == set(HazardKind)
    assert len({facts.letter for facts in HAZARDS.values()}) == len(HAZARDS)
    files = save_hazard_pictures(tmp_path)
    assert len(files) == len(HazardKind)
    assert all(file.stat().st_size > 5000 for file in files)
