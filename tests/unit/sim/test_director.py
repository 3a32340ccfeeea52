"""The director lets go of traffic that waits for an ego that waits."""

import random

import pytest

from plant_bench.sim.hazards import director as module
from plant_bench.sim.hazards.behaviour import HoldsTraffic
from plant_bench.sim.hazards.director import MAX_WAIT, Director
from plant_bench.sim.hazards.hazard_world import HazardWorld
from plant_bench.world.hazard import Hazard, HazardKind, Phase
from plant_bench.world.scene import TICK, EgoState

MOVING, WAITING = EgoState(0.0, 0.0, 0.0, 5.0), EgoState(0.0, 0.0, 0.0, 0.0)
TICKS = round(MAX_WAIT / TICK) + 2


class EmptyWorld(HazardWorld):
    def __init__(self) -> None:
        self.progress, self.tick = 0.0, 0


class Holding(HoldsTraffic):
    """A behaviour that waits for the ego for ever."""

    def __init__(self, hazard: Hazard, world: HazardWorld, draw: random.Random) -> None:
        self.phase, self.reason = Phase.ARMED, ""

    def step(self, ego: EgoState, world: HazardWorld) -> None:
        assert self.phase is Phase.ARMED

    def let_go(self, world: HazardWorld) -> None:
        self.phase = Phase.DONE


@pytest.fixture
def director(monkeypatch) -> Director:
    monkeypatch.setattr(module, "load_behaviour", lambda _: Holding)
    hazard = Hazard(HazardKind.MERGE_PRESSURE, 100.0, 0.0, 1, {})
    return Director(EmptyWorld(), (hazard,), 0)


def test_who_waits_for_an_ego_that_stands_is_let_go(director):
    for _ in range(TICKS):
        director.step(WAITING)
    (outcome,) = director.outcomes
    assert outcome.phase is Phase.VOID
    assert "stationary" in outcome.reason
    assert director.idle


class Counting(Holding):
    """Counts how often it is asked."""

    asked = 0

    def step(self, ego: EgoState, world: HazardWorld) -> None:
        type(self).asked += 1


@pytest.mark.parametrize(("kind", "times"), [(HazardKind.CUT_IN, 10), (HazardKind.HARD_BRAKE, 5)])
def test_who_places_a_vehicle_while_armed_is_asked_at_every_tick(kind, times, monkeypatch):
    """SUMO drives a vehicle that is not placed at a tick, and may begin to change its lane."""
    monkeypatch.setattr(module, "load_behaviour", lambda _: Counting)
    monkeypatch.setattr(Counting, "asked", 0)
    world = EmptyWorld()
    director = Director(world, (Hazard(kind, 100.0, 0.0, 1, {}),), 0)
    for world.tick in range(10):
        director.step(MOVING)
    assert Counting.asked == times


def test_an_ego_that_goes_on_now_and_then_is_waited_for(director):
    for tick in range(2 * TICKS):
        director.step(MOVING if tick % 1000 == 0 else WAITING)
    assert director.outcomes[0].phase is Phase.ARMED
