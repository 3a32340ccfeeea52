"""The careful driver in single hand-made situations on a straight road."""

import math
from dataclasses import replace

import numpy as np
import pytest

from plant_bench.agent import (
    NO_ACTOR,
    Cause,
    Control,
    NextLight,
    Observation,
    Privileged,
    Reason,
)
from plant_bench.agents.careful.driver import CarefulDriver
from plant_bench.agents.careful.forecast import along_true_lanes, straight_on
from plant_bench.agents.careful.leader import corridor
from plant_bench.agents.expert import Expert
from plant_bench.agents.idm import light_limit
from plant_bench.agents.rule_based import RuleBased
from plant_bench.errors import AgentError
from plant_bench.features.limits import allowed_speed
from plant_bench.features.rollouts import STEP
from plant_bench.world.route import Passage
from plant_bench.world.scene import Actors, Light
from tests.builders import (
    cars,
    observation_on,
    straight_lane_facts,
    straight_route,
    straight_route_ahead,
)

LIMIT = 10.0  # m/s, of `straight_route`


def observe(
    actors: Actors,
    *,
    speed: float = LIMIT,
    at: float = 20.0,
    light: NextLight | None = None,
    privileged: Privileged | None = None,
) -> Observation:
    """Whom the ego sees on a straight road; all drive straight on, unless stated otherwise."""
    return observation_on(
        straight_route(),
        at,
        speed=speed,
        actors=actors,
        light=light,
        privileged=privileged or straight_lane_facts(actors),
    )


def pull(observation: Observation, *passages: Passage) -> float:
    driver = CarefulDriver(along_true_lanes)
    driver.reset(straight_route(passages=passages))
    return driver.act(observation).acceleration


def reason(observation: Observation, *passages: Passage) -> Reason:
    driver = CarefulDriver(along_true_lanes)
    driver.reset(straight_route(passages=passages))
    driver.act(observation)
    return driver.explain()


def test_free_road_is_driven_at_the_speed_limit() -> None:
    assert pull(observe(cars())) == pytest.approx(0.0, abs=0.01)
    assert pull(observe(cars(), speed=2.0)) > 2.0


def test_ego_brakes_for_a_stationary_car_ahead_but_not_beside() -> None:
    assert pull(observe(cars((45.0, 0.0, 0.0, 0.0)))) < -2.0
    assert pull(observe(cars((45.0, 3.5, 0.0, 0.0)))) == pytest.approx(0.0, abs=0.01)


def test_ego_brakes_for_a_crossing_car_unless_it_must_stop() -> None:
    crossing = cars((50.0, -30.0, math.pi / 2, LIMIT))
    assert pull(observe(crossing)) < -0.5
    yields = straight_lane_facts(crossing, stop_distances=20.0)
    assert pull(observe(crossing, privileged=yields)) == pytest.approx(0.0, abs=0.01)


def test_ego_does_not_brake_for_a_follower() -> None:
    assert pull(observe(cars((10.0, 0.0, 0.0, 14.0)))) == pytest.approx(0.0, abs=0.01)


def test_ego_does_not_enter_a_junction_it_cannot_clear() -> None:
    passage = Passage("j", 40.0, 60.0, "straight", "signal")
    queue = observe(cars((65.0, 0.0, 0.0, 0.0)), speed=5.0)
    assert pull(queue, passage) < pull(queue) - 0.5
    moving = observe(cars((75.0, 0.0, 0.0, 8.0)), speed=5.0)
    assert pull(moving, passage) == pytest.approx(pull(moving))


@pytest.mark.parametrize(
    ("state", "distance", "speed", "stops"),
    [
        (Light.RED, 20.0, 8.0, True),
        (Light.GREEN, 20.0, 8.0, False),
        (Light.YELLOW, 20.0, 8.0, True),
        (Light.YELLOW, 5.0, 8.0, False),
        (Light.RED, -3.0, 8.0, False),
    ],
)
def test_ego_stops_for_red_and_for_yellow_if_it_can(
    state: Light, distance: float, speed: float, stops: bool
) -> None:
    assert (light_limit(speed, NextLight(state, distance)) < 0.0) is stops


def test_ego_slows_down_in_time_for_a_lower_limit() -> None:
    limits = np.concatenate((np.full(50, 13.9), np.full(51, 4.0)))
    allowed = allowed_speed(straight_route_ahead(speed_limits=limits))
    assert 4.0 < allowed < 13.9
    assert allowed**2 - 4.0**2 == pytest.approx(2.0 * 1.8 * 49.0, rel=0.03)


def test_leader_is_the_nearest_vehicle_in_the_lane() -> None:
    actors = cars((60.0, 0.0, 0.0, 5.0), (40.0, 0.2, 0.0, 3.0), (30.0, 3.5, 0.0, 1.0))
    observation = observe(actors)
    assert observation.route is not None
    leader = corridor(observation.route, actors, 0.0, LIMIT).leader()
    assert leader.actor == 1
    assert leader.distance == pytest.approx(40.0 - 2.25 - 20.0, abs=0.05)
    assert leader.speed == pytest.approx(3.0)


def test_forecasts_agree_for_a_car_at_constant_velocity() -> None:
    actors = cars((0.0, 3.5, 0.0, LIMIT))
    observation = observe(actors)
    keep = np.array([0])
    true = along_true_lanes(observation, keep)
    guess = straight_on(observation, keep)
    assert true.poses == pytest.approx(guess.poses, abs=1e-3)
    assert guess.poses[0, 4, 0] == pytest.approx(4 * STEP * LIMIT)


def test_the_privileged_forecast_follows_the_lane_and_stops_at_the_line() -> None:
    actors = cars((0.0, 3.5, 0.0, LIMIT))
    known = straight_lane_facts(actors, stop_distances=12.0)
    true = along_true_lanes(observe(actors, privileged=known), np.array([0]))
    assert true.poses[0, -1, 0] == pytest.approx(12.0, abs=1e-6)


def test_stationary_actors_are_forecast_to_stay() -> None:
    actors = cars((30.0, -3.0, math.pi / 2, 0.0))
    true = along_true_lanes(observe(actors), np.array([0]))
    assert np.ptp(true.poses[0], axis=0) == pytest.approx([0.0, 0.0, 0.0], abs=1e-6)


def test_missing_inputs_are_reported() -> None:
    with pytest.raises(AgentError, match="route"):
        Expert().reset(None)
    observation = observe(cars((45.0, 5.0, 0.0, 3.0)))
    blind = replace(observation, actors=None)
    driver = RuleBased()
    driver.reset(straight_route())
    with pytest.raises(AgentError, match="objects"):
        driver.act(blind)


def test_act_returns_a_control() -> None:
    driver = RuleBased()
    driver.reset(straight_route())
    assert isinstance(driver.act(observe(cars((45.0, 0.0, 0.0, 3.0)))), Control)


def test_ego_does_not_race_an_actor_that_comes_too_close() -> None:
    """Within the margins of a moving car every choice is in conflict: the driver must brake."""
    beside = cars((22.0, -3.5, math.pi / 2, 2.5))
    assert pull(observe(beside, speed=0.5)) <= -1.0


def test_ego_drives_off_from_a_vehicle_touching_its_side() -> None:
    assert pull(observe(cars((20.0, 1.5, 0.0, 0.0)), speed=0.0)) > 2.0
    assert pull(observe(cars((23.0, 1.5, 0.0, 0.0)), speed=0.0)) < 0.0


@pytest.mark.parametrize(
    ("scene", "cause", "actor"),
    [
        (observe(cars(), speed=2.0), Cause.FREE, NO_ACTOR),
        (observe(cars(), speed=LIMIT + 2.0), Cause.LIMIT, NO_ACTOR),
        (observe(cars(), light=NextLight(Light.RED, 20.0)), Cause.LIGHT, NO_ACTOR),
        (observe(cars((45.0, 3.5, 0.0, 0.0), (45.0, 0.0, 0.0, 0.0))), Cause.LEADER, 2),
        (observe(cars((90.0, 0.0, 0.0, LIMIT))), Cause.FREE, NO_ACTOR),
        (observe(cars((10.0, 0.0, 0.0, 14.0))), Cause.FREE, NO_ACTOR),
        (
            observe(cars((120.0, -80.0, math.pi / 2, 5.0), (50.0, -30.0, math.pi / 2, LIMIT))),
            Cause.CONFLICT,
            2,
        ),
    ],
)
def test_reason_is_the_actor_that_limits_the_acceleration(
    scene: Observation, cause: Cause, actor: int
) -> None:
    assert reason(scene) == Reason(cause, actor)


def test_reason_is_the_earlier_of_two_conflicts() -> None:
    far, near = (55.0, -35.0, math.pi / 2, LIMIT), (40.0, -20.0, math.pi / 2, LIMIT)
    assert reason(observe(cars(far, near))) == Reason(Cause.CONFLICT, 2)
    assert reason(observe(cars(near, far))) == Reason(Cause.CONFLICT, 1)


def test_reason_is_the_vehicle_that_blocks_the_junction_exit() -> None:
    passage = Passage("j", 30.0, 50.0, "straight", "signal")
    scene = observe(cars((50.0, 3.5, 0.0, 0.0), (55.0, 0.0, 0.0, 0.0)), speed=5.0)
    assert reason(scene, passage) == Reason(Cause.JUNCTION, 2)


def test_reset_clears_the_reason() -> None:
    driver = CarefulDriver(along_true_lanes)
    driver.reset(straight_route())
    driver.act(observe(cars((45.0, 0.0, 0.0, 0.0))))
    driver.reset(straight_route())
    assert driver.explain() == Reason(Cause.FREE)


def test_ego_waits_for_crossing_traffic_at_the_stop_line() -> None:
    stream = observe(cars(*((35.0, -y, math.pi / 2, 8.0) for y in (20, 32, 44))), speed=1.0)
    assert pull(stream) == pytest.approx(0.0)
    assert pull(stream, Passage("j", 23.5, 45.0, "left", "priority")) < -1.0


def test_passing_before_another_vehicle_needs_a_time_margin() -> None:
    """At full acceleration the ego passes before the other vehicle, with less it does not."""
    early, late = cars((40.0, -26.0, math.pi / 2, 8.0)), cars((40.0, -40.0, math.pi / 2, 8.0))
    assert pull(observe(early)) < -0.5
    assert pull(observe(late)) == pytest.approx(0.0, abs=0.01)


def test_requested_acceleration_is_not_exceeded() -> None:
    driver = CarefulDriver(straight_on)
    driver.reset(straight_route())
    assert driver.act(observe(cars(), speed=5.0), 0.3).acceleration == pytest.approx(0.3)
    assert (
        driver.act(observe(cars(), speed=5.0), 9.0).acceleration
        == driver.act(observe(cars(), speed=5.0)).acceleration
    )
