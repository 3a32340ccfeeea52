"""Gridlock: which vehicles are released, and which are not."""

import math

import numpy as np
import pytest

from plant_bench.agent import PATH_POSES, Privileged
from plant_bench.sim.gridlock import (
    LOOK_INTERVAL,
    MIN_STANDSTILL,
    ORDER_INTERVAL,
    RELEASE,
    Gridlock,
)
from plant_bench.sim.sumo import VehicleState
from plant_bench.sim.sumo_commands import Commands
from plant_bench.sim.sumo_placement import Placements
from plant_bench.world.scene import TICK
from tests.builders import cars, make_ego

EGO = make_ego()  # stands inside the junction, eastwards
CROSSING = (8.0, -8.0, math.pi / 2)  # would drive north past the ego's front
BEHIND = (-8.0, 0.0, 0.0)  # stands behind the ego
NOW = 400  # a tick at which a look may be due


class Told(Commands):
    """Records which vehicles others are told to ignore."""

    def __init__(self) -> None:
        super().__init__(Placements())
        self.ignored: dict[int, tuple[int, ...]] = {}
        self.reseated: list[int] = []
        self.out_of_order = False

    def ignore(self, vehicle: int, others: tuple[int, ...]) -> None:
        self.ignored[vehicle] = others

    def is_out_of_order(self, vehicle: int) -> bool:
        return self.out_of_order

    def reseat(self, vehicle: int) -> None:
        self.reseated.append(vehicle)


def look(
    told: Told, *poses: tuple[float, float, float], lanes: str = ":J_0_0", speed: float = 0.0
) -> Gridlock:
    """Run one gridlock check on vehicles 1, 2, ...; each would go straight ahead."""
    count = len(poses)
    placed = np.array(poses)
    actors = cars(*((*pose, speed) for pose in poses))
    ahead = np.stack((np.cos(placed[:, 2]), np.sin(placed[:, 2]), np.zeros(count)), axis=1)
    paths = placed[:, None] + np.arange(PATH_POSES)[:, None] * ahead[:, None]
    zero = np.zeros(count)
    states = {
        number: VehicleState(x, y, 0.0, yaw, speed, 0.0, lanes, 0.0, 0.0)
        for number, (x, y, yaw) in enumerate(poses, start=1)
    }
    gridlock = Gridlock(told)
    gridlock.look(NOW, EGO, actors, Privileged(paths, zero, zero, zero, zero), states)
    return gridlock


def test_vehicle_waiting_for_the_ego_and_its_queue_is_released() -> None:
    """The crossing vehicle waits for the ego and for the one behind it."""
    told = Told()
    look(told, CROSSING, BEHIND)
    assert told.ignored == {1: (0, 2)}  # the ego's own number is 0; 2 has the ego before it


def test_vehicle_is_not_released_into_a_stationary_vehicle() -> None:
    told = Told()
    look(told, CROSSING, (8.0, 0.0, 0.0))
    assert 1 not in told.ignored


@pytest.mark.parametrize(("lanes", "speed"), [("street_0", 0.0), (":J_0_0", 1.0)])
def test_vehicles_moving_or_before_the_junction_are_not_released(lanes: str, speed: float) -> None:
    told = Told()
    look(told, CROSSING, lanes=lanes, speed=speed)
    assert told.ignored == {}


@pytest.mark.parametrize("speed", [0.0, 5.0])
def test_ego_out_of_lane_order_is_reseated(speed: float) -> None:
    told = Told()
    gridlock = Gridlock(told)
    gridlock.due(NOW, make_ego(speed))
    assert told.reseated == []
    told.out_of_order = True
    for tick in range(NOW, NOW + ORDER_INTERVAL):
        gridlock.due(tick, make_ego(speed))
    assert told.reseated == [0]


def test_release_of_a_vehicle_expires() -> None:
    told = Told()
    gridlock = look(told, CROSSING)
    assert told.ignored == {1: (0,)}
    end = NOW + round(RELEASE / TICK)
    gridlock.due(end - 1, EGO)
    assert told.ignored == {1: (0,)}
    gridlock.due(end, EGO)
    assert told.ignored == {1: ()}


def test_gridlock_check_is_due_only_after_a_long_stop() -> None:
    gridlock = Gridlock(Told())
    due = [tick for tick in range(300) if gridlock.due(tick, EGO)]
    assert due[0] == pytest.approx(MIN_STANDSTILL / TICK, abs=LOOK_INTERVAL)
    assert set(np.diff(due).tolist()) == {LOOK_INTERVAL}
    assert not gridlock.due(300, make_ego(3.0))
    assert not gridlock.due(320, EGO)
