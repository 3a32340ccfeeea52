"""How the careful driver enters, crosses and merges: rules about time lost and who reacts."""

import math
from dataclasses import replace

import numpy as np
import pytest

from plant_bench.agents.careful.actor_filter import brake_for_ego
from plant_bench.agents.careful.conflicts import clearest
from plant_bench.agents.careful.forecast import TIMES, Forecast
from plant_bench.agents.careful.reduced_pace import at_slower_pace
from plant_bench.features.rollouts import STEP, ego_poses, rollout
from plant_bench.world.scene import Actors
from tests.builders import cars, make_ego, straight_route_ahead

LIMIT = 10.0


def car(x: float, y: float, yaw: float, speed: float) -> tuple[Actors, Forecast]:
    """One car that goes straight on at its speed, and its forecast."""
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
    """Return which of some accelerations is chosen on a straight road."""
    choices = np.array(pulls)
    poses = ego_poses(straight_route_ahead(), rollout(speed, choices, LIMIT))
    return float(choices[clearest(poses, forecast, 0.0)])


def test_a_slower_pace_meets_the_limits_ahead() -> None:
    limits = np.concatenate((np.full(15, LIMIT), np.full(86, 4.0)))
    travel = rollout(5.0, np.array([2.5]), LIMIT)[0]
    slow = at_slower_pace(travel, 5.0, straight_route_ahead(speed_limits=limits), math.inf, 0.0)
    assert (slow <= travel).all()
    assert (slow[-1] - slow[-2]) / STEP == pytest.approx(0.85 * 4.0, abs=0.1)


def test_a_slower_pace_of_one_who_stands_beyond_the_first_points() -> None:
    """The ego may be a little more than a metre beyond the first point: points lie unevenly."""
    travel = rollout(0.0, np.array([2.5]), LIMIT)[0]
    slow = at_slower_pace(travel, 0.0, replace(straight_route_ahead(), past=1.3), math.inf, 0.0)
    assert np.isfinite(slow).all()
    assert slow[0] == 0.0
    assert 0.5 * travel[-1] < slow[-1] < travel[-1]


def test_a_slower_pace_stays_behind_the_leader() -> None:
    travel = rollout(5.0, np.array([2.5]), LIMIT)[0]
    slow = at_slower_pace(travel, 5.0, straight_route_ahead(), 6.0, 1.0)
    assert slow[-1] == pytest.approx(6.0 + TIMES[-1])


def test_a_slower_pace_brakes_no_less() -> None:
    travel = rollout(8.0, np.array([-8.0]), LIMIT)[0]
    slow = at_slower_pace(travel, 8.0, straight_route_ahead(), math.inf, 0.0)
    assert slow[-1] == pytest.approx(travel[-1])


def test_within_the_margins_the_hardest_braking_is_chosen() -> None:
    """It passes the standing ego's front by less than the margin."""
    _, passing = car(3.5, -12.0, math.pi / 2, 8.0)
    assert chosen(0.3, [2.5, 0.5, 0.0, -2.0, -8.0], passing) == -8.0


def test_in_a_crossing_path_going_on_is_chosen_where_that_is_clear() -> None:
    """To stop is to be hit, and to brake is to stay."""
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
def test_a_follower_is_trusted_only_if_it_can_fall_in(
    x: float, y: float, yaw: float, speed: float, falls_in: bool
) -> None:
    ego = make_ego(5.0)
    actors, forecast = car(x, y, yaw, speed)
    assert brake_for_ego(ego, actors, forecast).tolist() == [falls_in]
