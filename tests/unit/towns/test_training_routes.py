from dataclasses import replace

import numpy as np
import pytest

from plant_bench.data.statistics import route_kind
from plant_bench.towns import training_routes
from plant_bench.towns.route_graph import StreetGraph
from plant_bench.towns.route_hazards import METRES_EACH
from plant_bench.towns.training_routes import (
    LONG,
    MAX_COMMON,
    SHORT_KINDS,
    SHORT_LENGTH,
    benchmark_routes,
    training_visits,
)
from plant_bench.towns.training_towns import training_towns
from plant_bench.world.hazard import Hazard, HazardKind
from plant_bench.world.town import load_town
from tests.unit.towns.common_ways import common_share

TOWNS = ("town01", "town02", "town03", "town04", "town05", "town06")


@pytest.fixture
def few_tries(monkeypatch):
    """Draft few paths and place no hazards, to be fast."""
    monkeypatch.setattr(training_routes, "TRIES", 60)
    monkeypatch.setattr(training_routes, "place_hazards", lambda town, route, seed: ())


def all_routes(name, visits=1, seed=0):
    town = load_town(name)
    found = [route for visit in training_visits(town, name, visits, seed) for route in visit]
    for route in found:
        route.check_town(town)
        route.validate()
    return found


def assert_disjoint(routes):
    benchmark = {route.id: route.checksum for route in benchmark_routes()}
    for route in routes:
        assert common_share(route) <= MAX_COMMON, route.id
        assert route.id not in benchmark
        assert route.checksum not in benchmark.values()


@pytest.mark.parametrize("name", ["town02", "town04"])
def test_training_routes_do_not_overlap_benchmark_routes(name, few_tries):
    routes = all_routes(name)
    assert len(routes) >= 4
    assert_disjoint(routes)


@pytest.mark.slow
@pytest.mark.parametrize("name", TOWNS)
def test_routes_of_further_visits_do_not_overlap_benchmark_routes(name):
    assert_disjoint(all_routes(name, visits=5))


def test_benchmark_route_and_a_part_of_it_are_detected_as_overlap():
    route = benchmark_routes()[0]
    driven = training_routes.distance_by_edge(route)
    piece = dict(list(driven.items())[:2])
    assert common_share(route) == 1.0
    assert training_routes.overlap_share(piece, driven) == 1.0 > MAX_COMMON


def test_short_routes_contain_their_manoeuvre(few_tries):
    for route in all_routes("town01"):
        kind = route_kind(route.id)
        if kind == LONG:
            assert 500.0 < route.length < 1150.0
            continue
        assert SHORT_LENGTH[0] * 0.9 < route.length < SHORT_LENGTH[1] * 1.1
        turn, _, signal = kind.partition("_")
        if turn in ("left", "right", "straight"):
            met = [item for item in route.passages if item.turn == turn]
            assert any((item.signal is not None) == bool(signal) for item in met)


def test_each_visit_uses_different_routes(few_tries):
    visits = training_visits(load_town("town02"), "town02", 2, 0)
    driven = [route.edges for visit in visits for route in visit]
    assert len(visits) == 2
    assert len(driven) == len(set(driven))


def test_equal_seeds_give_equal_routes(few_tries, monkeypatch):
    monkeypatch.setattr(training_routes, "TRIES", 15)
    once, again, other = (all_routes("town02", seed=seed) for seed in (3, 3, 4))
    assert [route.checksum for route in once] == [route.checksum for route in again]
    assert [route.checksum for route in once] != [route.checksum for route in other]


def test_hazard_density_equals_that_of_long_routes():
    route = replace(benchmark_routes()[0], id="town01-left-0")
    many = tuple(Hazard(HazardKind.CUT_IN, float(at), 0.0, at) for at in range(40, 1000, 60))
    kept = training_routes._sample_hazards(many, route, 0)
    assert len(kept) == round(route.length / METRES_EACH) < len(many)
    assert [hazard.at for hazard in kept] == sorted(hazard.at for hazard in kept)
    assert training_routes._sample_hazards(many[:2], route, 0) == many[:2]


def test_generated_training_towns_follow_the_benchmark_towns():
    towns = training_towns()
    assert [town.name for town in towns[:6]] == list(TOWNS)
    assert len({town.name for town in towns}) == 18
    assert all(town.base in TOWNS for town in towns)


def test_town_without_a_manoeuvre_has_no_such_routes(few_tries):
    kinds = {route_kind(route.id) for route in all_routes("town02")}
    assert "roundabout" not in kinds
    assert kinds <= {LONG, *SHORT_KINDS}


def test_manoeuvres_are_detected_from_the_streets(few_tries):
    graph = StreetGraph(load_town("town03"))
    rng = np.random.default_rng(0)
    kinds = set()
    for draft in training_routes._pieces(graph, rng):
        kinds |= training_routes.kinds_of(graph, draft)
    assert {"left_signal", "right_signal", "straight_signal", "lane_change"} <= kinds
