"""Gridlock: which vehicles are released, and which are not."""

import math

import numpy as np
import pytest

from plant_bench.agent import PATH_POSES, Privileged
from plant_bench.sim.gridlock import (
    LOOK_INTERVAL,
    MAX_WAIT,
    MIN_STANDSTILL,
    MIN_WAIT,
    MIN_WAIT_AGAIN,
    ORDER_INTERVAL,
    Gridlock,
)
from plant_bench.sim.roadside.collision_check import BODY
from plant_bench.sim.scene_builder import join
from plant_bench.sim.sumo import VehicleState
from plant_bench.sim.sumo_commands import Commands
from plant_bench.sim.sumo_placement import Placements
from plant_bench.world.actor_ids import PEDESTRIANS, SUMO_PROXIES
from plant_bench.world.scene import TICK, EgoState
from tests.builders import cars, make_actors, make_ego

EGO = make_ego()  # stands inside the junction, eastwards
CROSSING = (8.0, -8.0, math.pi / 2)  # would drive north past the ego's front
BEHIND = (-8.0, 0.0, 0.0)  # stands behind the ego
WALKER_PROXY = SUMO_PROXIES.start
EGO_LONG_STATIONARY = 10.0  # s; shorter than a driver's own long wait


class RecordedCommands(Commands):
    """Records which vehicles others are told to ignore."""

    def __init__(self) -> None:
        super().__init__(Placements())
        self.ignored: dict[int, tuple[int, ...]] = {}
        self.reseated: list[int] = []
        self.out_of_order = False
        self.red: set[int] = set()
        self.withdrawn: set[int] = set()
        self.leaders: dict[int, int] = {}

    def ignore(self, vehicle: int, others: tuple[int, ...]) -> None:
        self.ignored[vehicle] = others

    def withdraw(self, vehicle: int) -> None:
        self.withdrawn.add(vehicle)

    def leader(self, vehicle: int) -> int | None:
        return self.leaders.get(vehicle)

    def is_at_red_light(self, vehicle: int) -> bool:
        return vehicle in self.red

    def is_out_of_order(self, vehicle: int) -> bool:
        return self.out_of_order

    def reseat(self, vehicle: int) -> None:
        self.reseated.append(vehicle)


def drive(
    gridlock: Gridlock,
    *poses: tuple[float, float, float],
    seconds: float,
    ego: EgoState = EGO,
    lanes: str = ":J_0_0",
    speed: float = 0.0,
    walker: tuple[float, float] | None = None,
) -> None:
    """Step for some seconds beside vehicles 1, 2, ...; each would go straight ahead."""
    count = len(poses)
    placed = np.array(poses).reshape(count, 3)
    actors = cars(*((*pose, speed) for pose in poses))
    if walker is not None:
        actors = join(
            actors, make_actors([(*walker, 0.0)], ids=[PEDESTRIANS.start], extents=[BODY])
        )
    ahead = np.stack((np.cos(placed[:, 2]), np.sin(placed[:, 2]), np.zeros(count)), axis=1)
    paths = placed[:, None] + np.arange(PATH_POSES)[:, None] * ahead[:, None]
    zero = np.zeros(count)
    states = {
        number: VehicleState(x, y, 0.0, yaw, speed, 0.0, lanes, 0.0, 0.0)
        for number, (x, y, yaw) in enumerate(poses, start=1)
    }
    for tick in range(round(seconds / TICK)):
        gridlock.step(tick, ego, actors, states, lambda: Privileged(paths, zero, zero, zero, zero))


def after(
    seconds: float,
    *poses: tuple[float, float, float],
    ego: EgoState = EGO,
    lanes: str = ":J_0_0",
    speed: float = 0.0,
    red: set[int] | None = None,
) -> dict[int, tuple[int, ...]]:
    """Return whom each vehicle ignores after some seconds."""
    commands = RecordedCommands()
    commands.red = red or set()
    drive(Gridlock(commands), *poses, seconds=seconds, ego=ego, lanes=lanes, speed=speed)
    return commands.ignored


def test_vehicle_waiting_for_the_ego_and_its_queue_is_released() -> None:
    """The crossing vehicle waits for the ego and for the one behind it."""
    assert after(EGO_LONG_STATIONARY, CROSSING, BEHIND) == {1: (0, 2)}  # 0 is the ego


def test_vehicle_is_not_released_into_a_stationary_vehicle() -> None:
    assert 1 not in after(EGO_LONG_STATIONARY, CROSSING, (8.0, 0.0, 0.0))


def test_a_vehicle_that_overlaps_another_one_already_is_released() -> None:
    assert 1 in after(EGO_LONG_STATIONARY, CROSSING, (8.5, -8.5, math.pi / 2))


@pytest.mark.parametrize(("lanes", "speed"), [("street_0", 0.0), (":J_0_0", 1.0)])
def test_vehicles_moving_or_before_the_junction_are_not_released(lanes: str, speed: float) -> None:
    assert after(EGO_LONG_STATIONARY, CROSSING, lanes=lanes, speed=speed) == {}


def test_drivers_that_wait_for_each_other_for_long_are_released_while_the_ego_drives() -> None:
    """Two drivers before a junction whose paths cross: each has free space right ahead."""
    poses = ((20.0, -12.0, math.pi / 2), (32.0, 0.0, math.pi))
    moving = make_ego(5.0)
    assert after(MIN_WAIT - 1.0, *poses, ego=moving, lanes="street_0") == {}
    released = after(MIN_WAIT + 1.5, *poses, ego=moving, lanes="street_0")
    assert released == {1: (2,), 2: (1,)}


def test_the_next_driver_on_the_same_lane_is_released_sooner() -> None:
    first = ((20.0, -12.0, math.pi / 2), (32.0, 0.0, math.pi))
    commands = RecordedCommands()
    gridlock = Gridlock(commands)
    moving = make_ego(5.0)
    drive(gridlock, *first, seconds=MIN_WAIT + 1.5, ego=moving, lanes="street_0")
    gridlock.step(10_001, moving, cars(), {}, _no_facts)  # all have left, and all releases ended
    commands.ignored.clear()

    drive(gridlock, *first, seconds=MIN_WAIT_AGAIN + 1.5, ego=moving, lanes="other_0")
    assert commands.ignored == {}
    gridlock.step(10_020, moving, cars(), {}, _no_facts)
    drive(gridlock, *first, seconds=MIN_WAIT_AGAIN + 1.5, ego=moving, lanes="street_0")
    assert commands.ignored == {1: (2,), 2: (1,)}


def test_drivers_at_a_red_light_are_not_released() -> None:
    poses = ((20.0, -12.0, math.pi / 2), (32.0, 0.0, math.pi))
    released = after(MIN_WAIT + 1.5, *poses, ego=make_ego(5.0), lanes="street_0", red={1})
    assert released == {2: (1,)}


@pytest.mark.parametrize(("leaders", "released"), [({}, set()), ({2: 1}, {1})])
def test_a_follower_on_a_lane_that_is_folded_back_is_not_in_the_way(
    leaders: dict[int, int], released: set[int]
) -> None:
    commands = RecordedCommands()
    commands.leaders = leaders
    poses = ((30.0, 0.0, 0.0), (36.0, 0.0, math.pi))
    drive(Gridlock(commands), *poses, seconds=MIN_WAIT + 1.5, ego=make_ego(5.0), lanes="street_0")
    assert set(commands.ignored) == released


@pytest.mark.parametrize(
    ("walker", "released"),
    [((31.5, 1.6), {1: (WALKER_PROXY,)}), ((33.0, 0.0), {}), ((90.0, 0.0), {1: ()})],
)
def test_driver_ignores_a_pedestrian_who_waits_beside_its_path(
    walker: tuple[float, float], released: dict[int, tuple[int, ...]]
) -> None:
    """Beside the car's front, right ahead of it, and far away."""
    commands = RecordedCommands()
    gridlock = Gridlock(commands, proxies={PEDESTRIANS.start: WALKER_PROXY})
    pose, moving = (30.0, 0.0, 0.0), make_ego(5.0)
    drive(gridlock, pose, seconds=MIN_WAIT + 1.5, ego=moving, walker=walker)
    assert commands.ignored == released


def test_a_queued_driver_is_not_released_into_the_one_ahead() -> None:
    poses = ((20.0, 0.0, 0.0), (26.0, 0.0, 0.0))
    assert after(MIN_WAIT + 1.5, *poses, ego=make_ego(5.0)) == {2: (1,)}


@pytest.mark.parametrize(
    ("seconds", "lanes", "scripted", "removed"),
    [
        (MAX_WAIT - 1.0, ":J_0_0", set(), set()),
        (MAX_WAIT + 1.0, ":J_0_0", set(), {1, 2}),
        (MAX_WAIT + 1.0, "street_0", set(), set()),
        (MAX_WAIT + 1.0, ":J_0_0", {1}, {2}),
    ],
)
def test_drivers_that_block_each_other_inside_a_junction_are_removed(
    seconds: float, lanes: str, scripted: set[int], removed: set[int]
) -> None:
    """They stand nose to nose: none can move."""
    poses = ((30.0, 0.0, 0.0), (35.0, 0.3, math.pi))
    commands = RecordedCommands()
    gridlock = Gridlock(commands, scripted)
    drive(gridlock, *poses, seconds=seconds, ego=make_ego(5.0), lanes=lanes)
    assert commands.withdrawn == removed


def test_a_driver_that_the_ego_blocks_is_not_removed() -> None:
    commands = RecordedCommands()
    drive(Gridlock(commands), (8.0, 0.0, math.pi), seconds=MAX_WAIT + 1.0)
    assert commands.withdrawn == set()


@pytest.mark.parametrize("speed", [0.0, 5.0])
def test_ego_out_of_lane_order_is_reseated(speed: float) -> None:
    commands = RecordedCommands()
    gridlock = Gridlock(commands)
    drive(gridlock, seconds=ORDER_INTERVAL * TICK, ego=make_ego(speed))
    assert commands.reseated == []
    commands.out_of_order = True
    drive(gridlock, seconds=ORDER_INTERVAL * TICK, ego=make_ego(speed))
    assert commands.reseated == [0]


def test_release_of_a_vehicle_expires_and_is_renewed_at_the_next_check() -> None:
    commands = RecordedCommands()
    gridlock = Gridlock(commands)
    drive(gridlock, CROSSING, seconds=EGO_LONG_STATIONARY)
    assert commands.ignored == {1: (0,)}
    gridlock.step(10_001, make_ego(5.0), cars(), {}, _no_facts)
    assert commands.ignored == {1: ()}


def test_facts_are_queried_only_after_a_long_stop() -> None:
    gridlock = Gridlock(RecordedCommands())
    with pytest.raises(AssertionError, match="queried"):
        gridlock_with_facts(gridlock, ticks=round(MIN_STANDSTILL / TICK) + LOOK_INTERVAL + 1)
    gridlock_with_facts(Gridlock(RecordedCommands()), ticks=round(MIN_STANDSTILL / TICK))


def gridlock_with_facts(gridlock: Gridlock, ticks: int) -> None:
    """Step beside one stationary vehicle; a query of facts raises."""
    x, y, yaw = CROSSING
    states = {1: VehicleState(x, y, 0.0, yaw, 0.0, 0.0, ":J_0_0", 0.0, 0.0)}
    for tick in range(ticks):
        gridlock.step(tick, EGO, cars((*CROSSING, 0.0)), states, _no_facts)


def _no_facts() -> Privileged:
    raise AssertionError("queried")
