"""Junction and merge hazards: they hit a blind driver and never the oracle."""

import numpy as np
import pytest

from plant_bench.agent import Control
from plant_bench.sim.hazards.arrival import ACCELERATION, speed_to_arrive, time_to_go
from plant_bench.sim.hazards.merge_pressure import place_inside
from plant_bench.sim.simulation import Simulation
from plant_bench.world.conflicting_paths import Approach, approaches, passage_at
from plant_bench.world.hazard import Hazard, HazardKind, Phase
from plant_bench.world.route import Scenario
from plant_bench.world.town import Link, load_town
from tests.builders import make_ego, suite_route
from tests.sumo.oracle import drive

pytestmark = pytest.mark.sumo

# Kind, route, arc length of the hazard, metres before it at which it is armed.
CASES = [
    pytest.param(HazardKind.RED_LIGHT_RUNNER, "town01-0", 423, 85, marks=pytest.mark.slow),
    pytest.param(HazardKind.UNPROTECTED_LEFT, "town02-4", 598, 85, marks=pytest.mark.slow),
    (HazardKind.RIGHT_TURN, "town01-0", 205, 85),
    (HazardKind.UNSIGNALLED_CROSSING, "town01-4", 96, 80),
    (HazardKind.MERGE_PRESSURE, "town04-0", 793, 130),
]
SEEDS = range(2)


@pytest.mark.parametrize(("kind", "name", "at", "before"), CASES)
def test_junction_hazard_hits_a_blind_driver_and_never_the_oracle(
    kind: HazardKind, name: str, at: float, before: float
) -> None:
    whole = suite_route(name)
    hazards = [Hazard(kind, float(at), float(at - before), seed) for seed in SEEDS]
    blind = [drive(whole, hazard, hazard.seed, blind=True) for hazard in hazards]
    knowing = [drive(whole, hazard, hazard.seed, blind=False) for hazard in hazards]
    assert any(run.committed and run.hit for run in blind), blind
    assert all(run.committed or run.phase is Phase.VOID for run in blind), blind
    assert all(run.reason for run in (*blind, *knowing) if run.phase is Phase.VOID)
    assert not any(run.hit for run in knowing), knowing


@pytest.mark.parametrize(
    ("kind", "name", "at"),
    [
        (HazardKind.RED_LIGHT_RUNNER, "town01-4", 96),  # no signal
        (HazardKind.RIGHT_TURN, "town02-4", 598),  # a left turn
        (HazardKind.UNSIGNALLED_CROSSING, "town02-4", 598),  # a signal
    ],
)
def test_junction_hazard_is_void_without_a_conflicting_way(
    kind: HazardKind, name: str, at: float
) -> None:
    run = drive(suite_route(name), Hazard(kind, float(at), at - 80.0, 0), 0, blind=True)
    assert run.phase is Phase.VOID
    assert run.reason == "no conflicting approach here"


def test_merge_hazard_is_void_if_the_route_keeps_its_lane() -> None:
    hazard = Hazard(HazardKind.MERGE_PRESSURE, 423.0, 340.0, 0)
    run = drive(suite_route("town01-0"), hazard, 0, blind=True)
    assert (run.phase, run.reason) == (Phase.VOID, "the route has no lane change here")


def test_junction_traffic_yields_only_to_an_ego_in_its_own_lane() -> None:
    line = np.stack((np.arange(101.0), np.zeros(101)), axis=1)
    link = Link("a_0", "a_0", (), "", "straight", "major")
    way = Approach(link, line, {"a_0": 0.0}, ("a",), 100.0, 50.0, 50.0, 40.0, 0.0)
    assert place_inside(make_ego(10.0, x=50.0, y=-3.5, yaw=0.0), way) is None
    assert place_inside(make_ego(10.0, x=50.0, y=-2.0, yaw=0.1), way) == pytest.approx(
        47.5, abs=1.0
    )


def test_time_to_green_is_known_in_advance() -> None:
    whole = suite_route("town02-4")
    passage = whole.signal_passages[0]
    assert passage.signal is not None
    with Simulation(Scenario(whole, 1, "empty")) as simulation:
        signals, told = simulation._sumo.signals, {}
        for tick in range(3000):
            told[tick] = signals.time_to_green(passage.signal, passage.signal_index)
            if tick and told[tick] == 0.0 < told[tick - 1]:
                break
            simulation.step(Control(0.0, 0.0))
    change = max(told)
    red = [tick for tick in told if told[tick] > 0.0]
    assert len(red) > 20
    for tick in red:
        if all(told[k] > 0.0 for k in range(tick, change)):
            assert told[tick] == pytest.approx(0.05 * (change - tick), abs=0.11)


def test_approaches_cross_the_route_and_start_elsewhere() -> None:
    whole = suite_route("town05-4")
    passage = passage_at(whole, 102.0)
    assert passage is not None
    ways = approaches(load_town(whole.town), whole, passage)
    assert ways
    for way in ways:
        assert passage.entry <= way.at <= passage.exit + 12.0
        assert way.stop <= way.meets <= way.line.shape[0] * 200.0
        assert way.link.junction == passage.junction


@pytest.mark.parametrize("speed", [0.0, 5.0, 12.0])
@pytest.mark.parametrize("time", [3.0, 5.0])
def test_vehicle_arrives_at_the_requested_time(speed: float, time: float) -> None:
    way = speed * time + 0.3 * ACCELERATION * time**2
    pace = speed_to_arrive(way, time, speed)
    assert time_to_go(way, speed, pace) == pytest.approx(time, abs=0.01)
    assert time_to_go(way, speed, pace + 3.0) < time
