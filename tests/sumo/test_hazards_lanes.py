"""Lane events, crossings and control loss: avoidable for the expert, not for a blind driver."""

from collections.abc import Iterator
from dataclasses import replace
from typing import NamedTuple

import pytest

from plant_bench.sim.simulation import Simulation
from plant_bench.world.hazard import Hazard, HazardKind, HazardOutcome, Phase
from plant_bench.world.route import Scenario
from tests.builders import suite_route
from tests.sumo import driving

pytestmark = pytest.mark.sumo

SEEDS = (1, 2, 3)
PLACES = {  # kind: route, place, metres before it at which it is armed
    HazardKind.HARD_BRAKE: ("town03-0", 155.0, 110.0),
    HazardKind.CUT_IN: ("town05-2", 155.0, 150.0),
    HazardKind.BLOCKED_LANE: ("town03-0", 155.0, 115.0),
    HazardKind.QUEUE_TAIL: ("town03-0", 155.0, 125.0),
}


class Drive(NamedTuple):
    """The outcome of one hazard, and of the ego."""

    outcome: HazardOutcome
    collisions: int
    offset: float


def drive(name: str, agent: str, hazard: Hazard, seed: int, beyond: float = 60.0) -> Drive:
    """Drive until shortly past a route's only hazard, without other traffic."""
    scenario = Scenario(replace(suite_route(name), hazards=(hazard,)), seed, "empty", hazards=True)
    offset = 0.0
    with Simulation(scenario) as simulation:
        for referee in driving.drive(simulation, scenario.route, agent):
            offset = max(offset, abs(referee.offset))
            if referee.progress >= hazard.at + beyond or referee.status is not None:
                return Drive(simulation.outcomes[0], len(referee.infractions), offset)
    message = "the drive has no end of its own"
    raise AssertionError(message)


def drives(kind: HazardKind, agent: str) -> Iterator[Drive]:
    name, at, before = PLACES[kind]
    for seed in SEEDS:
        yield drive(name, agent, Hazard(kind, at, at - before, 7, {}), seed)


@pytest.mark.parametrize("kind", PLACES)
def test_lane_hazard_hits_a_blind_driver(kind: HazardKind) -> None:
    found = list(drives(kind, "cruise"))
    assert any(one.outcome.phase in (Phase.DONE, Phase.COMMITTED) for one in found)
    assert any(one.collisions for one in found)


@pytest.mark.parametrize("kind", PLACES)
def test_lane_hazard_never_hits_an_attentive_driver(kind: HazardKind) -> None:
    found = list(drives(kind, "expert"))
    assert all(one.outcome.phase is not Phase.DORMANT for one in found)
    assert not any(one.collisions for one in found)


def test_equal_scenarios_have_equal_hazards() -> None:
    hazard = Hazard(HazardKind.CUT_IN, 155.0, 5.0, 7, {})
    one, other = (drive("town05-2", "cruise", hazard, 1) for _ in range(2))
    assert one == other


def test_lane_hazard_is_void_if_the_ego_would_see_it_appear() -> None:
    hazard = Hazard(HazardKind.BLOCKED_LANE, 155.0, 130.0, 7, {})
    outcome = drive("town03-0", "cruise", hazard, 1).outcome
    assert (outcome.phase, outcome.reason) == (Phase.VOID, "the place was occupied")


def test_lane_hazard_is_void_without_a_neighbouring_lane() -> None:
    hazard = Hazard(HazardKind.CUT_IN, 150.0, 100.0, 7, {})
    outcome = drive("town02-3", "cruise", hazard, 1).outcome
    assert (outcome.phase, outcome.reason) == (Phase.VOID, "there is no adjacent lane")


@pytest.mark.parametrize(("name", "at"), [("town02-3", 410.0), ("town04-0", 2145.0)])
def test_control_loss_is_bounded(name: str, at: float) -> None:
    strong = {"pull": 0.08, "duration": 2.5}
    hazard = Hazard(HazardKind.CONTROL_LOSS, at, at - 10.0, 7, strong)
    found = drive(name, "expert", hazard, 1, beyond=80.0)
    assert found.outcome.phase is Phase.DONE
    assert found.offset < 1.0


def test_control_loss_does_not_start_before_a_traffic_light() -> None:
    line = suite_route("town02-3").signal_entries[0]
    hazard = Hazard(HazardKind.CONTROL_LOSS, line - 8.0, line - 30.0, 7, {})
    outcome = drive("town02-3", "expert", hazard, 1).outcome
    assert (outcome.phase, outcome.reason) == (Phase.VOID, "the ego had to stop soon")
