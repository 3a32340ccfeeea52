"""How the careful driver enters, crosses and merges."""

import math
from dataclasses import replace

import numpy as np
import pytest

from plant_bench.agents.careful.actor_filter import yielding_followers
from plant_bench.agents.careful.conflicts import best_choice
from plant_bench.agents.careful.forecast import TIMES, Forecast
from plant_bench.agents.careful.reduced_pace import reduced_travel
from plant_bench.features.rollouts import STEP, ego_poses, rollout
from plant_bench.world.scene import Actors
from tests.builders import cars, make_ego, straight_route_ahead

LIMIT = 10.0


def car(x: float, y: float, yaw: float, speed: float) -> tuple[Actors, Forecast]:
    """Return one car that drives straight ahead at its speed, and its forecast."""
    travel = speed * TIMES
    places = (x + travel * math.cos(yaw), y + travel * math.sin(yaw), np.full(len(TIMES), yaw))
    forecast = Forecast(
        np.stack(places, axis=1)[None],
        np.full((1, len(TIMES)), 4.5),
        np.array([1.8]),
        np.array([speed < 0.1]),
        np.array([1.0]),
    )
    return cars((x, y, yaw, speed)), forecast


def chosen(speed: float, pulls: list[float], forecast: Forecast) -> float:
    """Return which of the given accelerations is chosen on a straight road."""
    choices = np.array(pulls)
    poses = ego_poses(straight_route_ahead(), rollout(speed, choices, LIMIT))
    return float(choices[best_choice(poses, forecast, 0.0)])


def test_slower_profile_respects_the_limits_ahead() -> None:
    limits = np.concatenate((np.full(15, LIMIT), np.full(86, 4.0)))
    travel = rollout(5.0, np.array([2.5]), LIMIT)[0]
    slow = reduced_travel(travel, 5.0, straight_route_ahead(speed_limits=limits), math.inf, 0.0)
    assert (slow <= travel).all()
    assert (slow[-1] - slow[-2]) / STEP == pytest.approx(0.85 * 4.0, abs=0.1)


def test_slower_profile_is_finite_past_the_first_route_point() -> None:
    """The ego may be more than 1 m past the first point, as points are spaced unevenly."""
    travel = rollout(0.0, np.array([2.5]), LIMIT)[0]
    slow = reduced_travel(travel, 0.0, replace(straight_route_ahead(), past=1.3), math.inf, 0.0)
    assert np.isfinite(slow).all()
    assert slow[0] == 0.0
    assert 0.5 * travel[-1] < slow[-1] < travel[-1]


def test_slower_profile_stays_behind_the_leader() -> None:
    travel = rollout(5.0, np.array([2.5]), LIMIT)[0]
    slow = reduced_travel(travel, 5.0, straight_route_ahead(), 6.0, 1.0)
    assert slow[-1] == pytest.approx(6.0 + TIMES[-1])


def test_slower_profile_brakes_as_hard() -> None:
    travel = rollout(8.0, np.array([-8.0]), LIMIT)[0]
    slow = reduced_travel(travel, 8.0, straight_route_ahead(), math.inf, 0.0)
    assert slow[-1] == pytest.approx(travel[-1])


def test_hardest_braking_is_chosen_within_the_margins() -> None:
    """It passes the standing ego's front by less than the margin."""
    _, passing = car(3.5, -12.0, math.pi / 2, 8.0)
    assert chosen(0.3, [2.5, 0.5, 0.0, -2.0, -8.0], passing) == -8.0


def test_ego_clears_a_crossing_path_if_it_can() -> None:
    """Stopping would mean being hit, and braking would mean staying in the path."""
    _, crossing = car(1.0, -30.0, math.pi / 2, 8.0)
    assert chosen(1.0, [2.5, -2.0, -8.0], crossing) == 2.5
    _, nearer = car(9.0, -14.0, math.pi / 2, 8.0)
    assert chosen(4.0, [2.5, -2.0, -8.0], nearer) == -2.0


@pytest.mark.parametrize(
    ("x", "y", "yaw", "speed", "falls_in"),
    [
        (-12.0, 1.0, 0.0, 7.0, True),
        (-12.0, 1.0, 0.0, 14.0, False),  # too fast to fall in behind
        (-12.0, 4.0, 0.0, 7.0, False),  # the ego is not in its way
        (-4.0, 1.0, 0.0, 7.0, False),  # alongside
        (0.0, -12.0, math.pi / 2, 2.0, False),  # it crosses
    ],
)
def test_follower_is_trusted_only_if_it_can_stay_behind(
    x: float, y: float, yaw: float, speed: float, falls_in: bool
) -> None:
    ego = make_ego(5.0)
    actors, forecast = car(x, y, yaw, speed)
    assert yielding_followers(ego, actors, forecast).tolist() == [falls_in]
