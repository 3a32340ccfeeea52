"""Approaches that conflict with the route: where the ego must stop, and which fit a hazard."""

from dataclasses import replace

import numpy as np
import pytest

from plant_bench.world.conflicting_paths import STEP, SWEPT, approaches, clear_place, passage_at
from plant_bench.world.hazard import HazardKind
from plant_bench.world.hazard_table import HAZARDS, load_part
from plant_bench.world.route import load_suite
from plant_bench.world.scene import EGO_WIDTH
from plant_bench.world.town import load_town

FITS = {
    kind: load_part(kind, "fits")
    for kind, row in HAZARDS.items()
    if row.where.endswith(":at_junctions")
}
ROUTES = {route.id: route for route in load_suite("longest6")}
AHEAD = np.arange(101.0)
EAST = replace(
    ROUTES["town01-0"],
    points=np.stack((AHEAD, 0.0 * AHEAD), axis=1),
    elevations=0.0 * AHEAD,
    speed_limits=10.0 + 0.0 * AHEAD,
)


def clear_of(line):
    return clear_place(EAST, 10.0, 90.0, line, range(100))


def test_ego_front_stays_clear_of_a_crossing_vehicle():
    across = np.stack((np.full(101, 60.0), AHEAD - 50.0), axis=1)
    assert clear_of(across) == pytest.approx(60.0 - 0.5 * SWEPT[1], abs=STEP)


def test_merging_vehicle_conflicts_before_the_centre_lines_meet():
    aside = np.maximum(0.1 * (60.0 - AHEAD), 0.0)
    joining = np.stack((AHEAD, aside), axis=1)
    sides_touch = 60.0 - 0.5 * (EGO_WIDTH + SWEPT[1]) / 0.1
    assert sides_touch - 3.0 < clear_of(joining) < sides_touch + 6.0


def test_vehicle_in_the_adjacent_lane_never_conflicts():
    beside = np.stack((AHEAD, np.full(101, 3.5)), axis=1)
    assert clear_of(beside) > 89.0


def test_approaches_are_clear_before_they_meet():
    route = ROUTES["town05-4"]
    passage = passage_at(route, 102.0)
    assert passage is not None
    ways = approaches(load_town(route.town), route, passage)
    assert ways
    assert all(way.clear < way.at for way in ways)


@pytest.mark.parametrize("name", ["town01-0", "town03-3", "town06-3"])
def test_junction_hazards_have_a_long_approach(name):
    route = ROUTES[name]
    town = load_town(route.town)
    found = [hazard for hazard in route.hazards if hazard.kind in FITS]
    assert found
    for hazard in found:
        passage = passage_at(route, hazard.at)
        assert passage is not None
        ways = [way for way in approaches(town, route, passage) if FITS[hazard.kind](way, passage)]
        assert max(way.meets for way in ways) > 60.0, hazard


def test_approaches_fit_the_kind_of_hazard():
    seen = set()
    for name in ("town01-0", "town02-4", "town05-4"):
        route = ROUTES[name]
        town = load_town(route.town)
        for passage in route.passages:
            for way in approaches(town, route, passage):
                kinds = {kind for kind, fits in FITS.items() if fits(way, passage)}
                seen |= kinds
                if HazardKind.RIGHT_TURN in kinds:
                    assert (passage.turn, way.link.turn) == ("right", "straight")
                if HazardKind.RED_LIGHT_RUNNER in kinds:
                    assert passage.signal is not None
                    assert way.link.turn != "right"
                if HazardKind.UNSIGNALLED_CROSSING in kinds:
                    assert passage.signal is None
    assert seen == set(FITS)
    assert len(FITS) == 4
