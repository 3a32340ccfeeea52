"""The director releases hazard traffic that waits for a waiting ego."""

import random

import pytest

from plant_bench.sim.hazards import director as module
from plant_bench.sim.hazards.behaviour import HoldsTraffic
from plant_bench.sim.hazards.director import MAX_WAIT, Director
from plant_bench.sim.hazards.hazard_world import HazardWorld
from plant_bench.sim.sumo_library import SumoError
from plant_bench.world.hazard import Hazard, HazardKind, Phase
from plant_bench.world.scene import TICK, EgoState
from tests.builders import make_ego

MOVING, WAITING = make_ego(5.0), make_ego()
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


def test_armed_hazard_is_void_if_the_ego_stays_stationary(director):
    for _ in range(TICKS):
        director.step(WAITING)
    (outcome,) = director.outcomes
    assert outcome.phase is Phase.VOID
    assert "stationary" in outcome.reason
    assert director.idle


class Counting(Holding):
    """Counts its steps."""

    asked = 0

    def step(self, ego: EgoState, world: HazardWorld) -> None:
        type(self).asked += 1


@pytest.mark.parametrize(("kind", "times"), [(HazardKind.CUT_IN, 10), (HazardKind.HARD_BRAKE, 5)])
def test_hazard_placing_a_vehicle_is_stepped_every_tick(kind, times, monkeypatch):
    """Without placement at a tick, SUMO drives the vehicle and may start a lane change."""
    monkeypatch.setattr(module, "load_behaviour", lambda _: Counting)
    monkeypatch.setattr(Counting, "asked", 0)
    world = EmptyWorld()
    director = Director(world, (Hazard(kind, 100.0, 0.0, 1, {}),), 0)
    for world.tick in range(10):
        director.step(MOVING)
    assert Counting.asked == times


def test_armed_hazard_waits_for_an_ego_that_moves_now_and_then(director):
    for tick in range(2 * TICKS):
        director.step(MOVING if tick % 1000 == 0 else WAITING)
    assert director.outcomes[0].phase is Phase.ARMED


class Losing(Holding):
    """Its vehicle is gone at the third step."""

    def step(self, ego: EgoState, world: HazardWorld) -> None:
        if world.tick >= 4:
            raise SumoError("Vehicle '7' is not known")


class RecordingWorld(EmptyWorld):
    """Notes which hazards' actors are taken off the road."""

    def __init__(self) -> None:
        super().__init__()
        self.abandoned: list[float] = []

    def abandon(self, owner: float) -> None:
        self.abandoned.append(owner)


def test_hazard_whose_vehicle_sumo_removes_is_void_and_the_episode_goes_on(monkeypatch):
    behaviours = {HazardKind.CUT_IN: Losing, HazardKind.HARD_BRAKE: Holding}
    monkeypatch.setattr(module, "load_behaviour", behaviours.__getitem__)
    places = zip(behaviours, (70.0, 90.0), strict=True)
    hazards = tuple(Hazard(kind, at, 0.0, 1, {}) for kind, at in places)
    world = RecordingWorld()
    director = Director(world, hazards, 0)
    for world.tick in range(10):
        director.step(MOVING)
    lost, other = director.outcomes
    assert lost.phase is Phase.VOID
    assert lost.reason == "SUMO removed its vehicle (Vehicle '7' is not known)"
    assert other.phase is Phase.ARMED
    assert world.abandoned == [70.0]
    assert not director.idle
