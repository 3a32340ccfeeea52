"""Each episode metric: a value known by arithmetic, and cases just above and below its limit."""

import math
from collections.abc import Sequence

import numpy as np
import pytest

from plant_bench.scoring.episode_measures import measure
from plant_bench.scoring.episode_metrics import (
    hard_brake_share,
    hard_brakes,
    jerk_p95,
    lateral_acceleration_p95,
    relative_speed,
    standing_share,
)
from plant_bench.scoring.near_misses import least_post_encroachment_time, least_time_to_collision
from plant_bench.scoring.trajectory import (
    SAMPLE,
    VEHICLES,
    VULNERABLE,
    Trajectory,
    TrajectoryRecorder,
)
from plant_bench.world.scene import TICK, ActorKind, Actors, EgoState
from tests.builders import make_actors, make_ego, make_scene

TOUCH = 2.45 + 2.0  # m between the centres when the ego's bumper meets that of a 4 m car
BESIDE = 1.065 + 1.0  # m between the centres when the ego's flank meets that of a 2 m wide car
WALKER = (0.5, 0.5)
NORTH = 0.5 * math.pi
Actor = tuple[float, float, float, float]  # x, y and yaw at time 0, speed


def straight(ticks: int, speed: float = 10.0, x: float = 0.0) -> list[EgoState]:
    """Return an ego that drives along x."""
    return [make_ego(speed, x=x + speed * tick * TICK) for tick in range(ticks)]


def turning(ticks: int, speed: float, radius: float) -> list[EgoState]:
    """Return an ego that turns left in a circle, from the origin and the heading x."""
    angles = np.arange(ticks) * TICK * speed / radius
    return [
        EgoState(radius * np.sin(a), radius * (1.0 - np.cos(a)), float(a), speed) for a in angles
    ]


def track_of(
    egos: Sequence[EgoState],
    actors: Sequence[Actor] = (),
    *,
    kind: ActorKind = ActorKind.CAR,
    extent: tuple[float, float] = (4.0, 2.0),
) -> Trajectory:
    """Return the trajectory of an ego among actors of one kind."""
    recorder = TrajectoryRecorder()
    for tick, ego in enumerate(egos):
        time = tick * TICK
        poses = [(x + v * time * np.cos(a), y + v * time * np.sin(a), a) for x, y, a, v in actors]
        speeds = [actor[3] for actor in actors]
        seen = make_actors(poses, speeds=speeds, extents=extent, kinds=kind)
        recorder.add(make_scene(tick, ego=ego, actors=seen))
    return recorder.trajectory()


def actors_at(poses: np.ndarray, speed: float) -> Actors:
    """Return cars at these poses."""
    return make_actors(poses, speeds=speed, extents=(4.0, 2.0))


def changing(accelerations: Sequence[float], speed: float = 20.0) -> Trajectory:
    """Return the trajectory of an ego with these accelerations, tick by tick."""
    speeds = speed + np.cumsum(accelerations) * TICK
    return track_of(
        [
            make_ego(float(v), acceleration=float(a))
            for v, a in zip(speeds, accelerations, strict=True)
        ]
    )


def to_collision(trajectory: Trajectory, kinds: tuple[ActorKind, ...] = VEHICLES) -> float | None:
    return least_time_to_collision(trajectory, trajectory.of_kinds(kinds))


def encroachment(trajectory: Trajectory) -> float | None:
    return least_post_encroachment_time(trajectory, trajectory.of_kinds(VEHICLES))


@pytest.mark.parametrize(("speed", "seconds"), [(0.0, 1.0), (5.0, 2.0)])
def test_time_to_collision_with_a_vehicle_ahead(speed, seconds):
    trajectory = track_of(straight(1), [(TOUCH + 9.99, 0.0, 0.0, speed)])
    assert to_collision(trajectory) == pytest.approx(seconds)


def test_time_to_collision_is_the_minimum_of_the_episode():
    """At the last sample, tick 56, the ego is at 28 m: 10 m before the car."""
    trajectory = track_of(straight(57), [(28.0 + TOUCH + 9.99, 0.0, 0.0, 0.0)])
    assert to_collision(trajectory) == pytest.approx(1.0)


@pytest.mark.parametrize(("aside", "seconds"), [(BESIDE + 0.01, None), (BESIDE - 0.01, 1.0)])
def test_passing_close_at_the_side_has_no_time_to_collision(aside, seconds):
    trajectory = track_of(straight(1), [(TOUCH + 9.99, aside, 0.0, 0.0)])
    assert to_collision(trajectory) == (seconds and pytest.approx(seconds))


@pytest.mark.parametrize(("gap", "seconds"), [(49.99, 5.0), (50.01, None)])
def test_time_to_collision_is_limited_by_its_horizon(gap, seconds):
    assert to_collision(track_of(straight(1), [(TOUCH + gap, 0.0, 0.0, 0.0)])) == seconds


def test_time_to_collision_is_zero_in_a_collision():
    assert to_collision(track_of(straight(1), [(TOUCH - 0.01, 0.0, 0.0, 0.0)])) == 0.0


def test_vehicle_behind_is_ignored_but_not_one_hitting_the_side():
    assert to_collision(track_of(straight(1), [(-10.0, 0.0, 0.0, 20.0)])) is None
    crossing = track_of(straight(1, speed=0.0), [(-1.0, -10.0, NORTH, 10.0)])
    assert to_collision(crossing) == pytest.approx(0.7)  # 10 m less 2 m less 1.065 m: 0.69 s


def test_pedestrian_on_a_collision_course_has_a_time_to_collision():
    """The ego's front arrives after 1.73 s; the pedestrian is on its lane from 1.12 s on."""
    trajectory = track_of(
        straight(1), [(20.0, -3.0, NORTH, 1.5)], kind=ActorKind.PEDESTRIAN, extent=WALKER
    )
    assert to_collision(trajectory, VULNERABLE) == pytest.approx(1.8)
    assert to_collision(trajectory) is None


def test_vehicle_waiting_beside_a_bend_has_no_time_to_collision():
    """Straight ahead the ego would hit it after about 1 s, but it turns and never comes near."""
    egos = turning(60, speed=8.0, radius=12.0)
    assert to_collision(track_of(egos[:1], [(10.0, 0.0, math.pi, 0.0)])) is not None
    assert to_collision(track_of(egos, [(15.5, 3.0, math.pi, 0.0)])) is None


def test_time_to_collision_uses_the_recorded_paths_of_others():
    """An oncoming car turns off before the ego: the metric uses its recorded path."""
    egos = straight(40, speed=1.0)
    circle = turning(40, speed=8.0, radius=8.0)
    recorder = TrajectoryRecorder()
    for tick, (ego, other) in enumerate(zip(egos, circle, strict=True)):
        pose = np.array([[24.0 - other.x, other.y, math.pi - other.yaw]], np.float32)
        seen = actors_at(pose, 8.0)
        recorder.add(make_scene(tick, ego=ego, actors=seen))
    assert to_collision(recorder.trajectory()) is None
    assert to_collision(track_of(egos, [(24.0, 0.0, math.pi, 8.0)])) is not None


@pytest.mark.parametrize("shift", [1.5, -1.5])
def test_post_encroachment_time_of_a_crossing(shift):
    """The car is on the ego's lane for 0.613 s around the moment it is at y = 0; the ego needs
    from x = 46.55 to x = 53.45, 4.655 to 5.345 s, to pass where it crosses.
    """
    moment = 4.655 - shift - 0.3065 if shift > 0 else 5.345 - shift + 0.3065
    trajectory = track_of(straight(160), [(50.0, -10.0 * moment, NORTH, 10.0)])
    assert abs(shift) <= encroachment(trajectory) <= abs(shift) + 2.0 * SAMPLE


def test_crossing_over_5_s_later_has_no_post_encroachment_time():
    assert encroachment(track_of(straight(200), [(50.0, 10.0, NORTH, 10.0)])) is None  # 5.35 s ago
    assert encroachment(track_of(straight(200), [(50.0, 3.0, NORTH, 10.0)])) is not None


@pytest.mark.parametrize(
    "other", [(20.0, 0.0, 0.0, 10.0), (60.0, 3.5, math.pi, 10.0), (50.0, -3.2, NORTH, 0.0)]
)
def test_parallel_paths_have_no_post_encroachment_time(other):
    """One ahead on the same lane, one on the oncoming lane, one that waits at the side."""
    assert encroachment(track_of(straight(160), [other])) is None


@pytest.mark.parametrize(
    ("accelerations", "count"),
    [
        ([-4.01] * 20, 1),
        ([-4.0] * 20, 0),
        ([-5.0] * 5 + [0.0] * 19 + [-5.0] * 5, 1),
        ([-5.0] * 5 + [0.0] * 20 + [-5.0] * 5, 2),
        ([5.0] * 20, 0),
    ],
)
def test_hard_brakes_are_counted(accelerations, count):
    assert hard_brakes(changing(accelerations)) == count


def test_share_of_hard_braking_is_over_time():
    assert hard_brake_share(changing([-5.0] * 5 + [-3.0] * 15)) == 0.25


@pytest.mark.parametrize("rate", [2.0, -3.0])
def test_jerk_of_a_linearly_growing_acceleration(rate):
    trajectory = changing([rate * TICK * tick for tick in range(60)])
    assert jerk_p95(trajectory) == pytest.approx(abs(rate))


def test_jerk_is_smoothed_and_zero_at_constant_acceleration():
    assert jerk_p95(changing([2.0] * 60)) == pytest.approx(0.0, abs=1e-9)
    assert jerk_p95(changing([2.0, -2.0] * 30)) == pytest.approx(0.0, abs=1e-9)
    assert jerk_p95(changing([0.0] * 60, speed=0.0)) is None
    assert jerk_p95(changing([2.0] * 20)) is None  # too short for it


def test_lateral_acceleration_of_a_circle():
    assert lateral_acceleration_p95(track_of(turning(200, 10.0, 20.0))) == pytest.approx(5.0)
    assert lateral_acceleration_p95(track_of(straight(60))) == 0.0
    assert lateral_acceleration_p95(track_of(straight(60, speed=0.0))) is None


def test_share_of_time_stationary():
    egos = straight(30) + [make_ego(0.09, x=15.0)] * 10
    assert standing_share(track_of(egos)) == 0.25


def test_relative_speed_compares_with_nearby_traffic():
    ahead, oncoming = (20.0, 0.0, 0.0, 8.0), (40.0, 3.5, math.pi, 12.0)
    assert relative_speed(track_of(straight(20, 5.0), [ahead, oncoming])) == pytest.approx(0.5)


@pytest.mark.parametrize(
    "other",
    [(20.0, 6.0, 0.0, 0.0), (-20.0, 0.0, 0.0, 5.0), (56.0, 0.0, 0.0, 5.0)],
    ids=["parked", "follows", "far away"],
)
def test_parked_following_and_distant_vehicles_are_not_traffic(other):
    egos, ahead = straight(20, 5.0), (20.0, 0.0, 0.0, 10.0)
    assert relative_speed(track_of(egos, [other])) is None
    assert relative_speed(track_of(egos, [ahead, other])) == pytest.approx(0.5)


def test_pedestrians_and_cyclists_are_not_traffic():
    for kind in (ActorKind.PEDESTRIAN, ActorKind.BICYCLE, ActorKind.STATIC):
        assert relative_speed(track_of(straight(20), [(20.0, 0.0, 0.0, 5.0)], kind=kind)) is None


def test_waiting_vehicle_counts_as_traffic():
    """It stands for the first half, and then drives at 10 m/s: 5 m/s on average."""
    recorder = TrajectoryRecorder()
    for tick, ego in enumerate(straight(40, 5.0)):
        pose = np.array([[20.0, 0.0, 0.0]], np.float32)
        seen = actors_at(pose, 0.0 if tick < 20 else 10.0)
        recorder.add(make_scene(tick, ego=ego, actors=seen))
    assert relative_speed(recorder.trajectory()) == pytest.approx(1.0)


def test_metrics_of_a_single_tick_are_defined():
    found = measure(track_of(straight(1)))
    for name in ("ttc_vehicle", "pet_vehicle", "jerk_p95", "relative_speed"):
        assert name in found
        assert found[name] is None
    assert (found["hard_brakes"], found["standing_share"]) == (0, 0.0)
