"""Rewards and their terms."""

import math
from dataclasses import replace

import pytest

from plant_bench.agent import Control, NextLight, Observation
from plant_bench.errors import InputError
from plant_bench.gym.rewards import ProgressReward, reward_of
from plant_bench.gym.roach import RoachReward, desired_speed
from plant_bench.gym.transition import Transition
from plant_bench.scoring.infractions import Infraction, InfractionKind, Status
from plant_bench.world.actor_ids import PARKED
from plant_bench.world.scene import EGO_LENGTH, ActorKind, EgoState, Light
from tests.builders import make_actors, make_ego, make_observation, make_scene, straight_route_ahead

TOP = 6.0


def seen(
    *others: tuple[float, float, float],
    kind: ActorKind = ActorKind.CAR,
    first: int = 1,
    light: NextLight | None = None,
    ego: EgoState | None = None,
    offset: float = 0.0,
) -> Observation:
    ids = range(first, first + len(others))
    return make_observation(
        ego=ego or make_ego(TOP),
        actors=make_actors(others, extents=(4.0, 2.0), kinds=kind, ids=ids),
        route=straight_route_ahead(60, offset=offset),
        light=light,
    )


def step(observation: Observation, **facts: object) -> Transition:
    scene = make_scene(2, ego=observation.ego)
    still = Control(0.0, 0.0)
    transition = Transition(scene, scene, observation, still, still, 0.5, 0.0, (), None)
    return replace(transition, **facts)


def hit(kind: InfractionKind = InfractionKind.COLLISION_PEDESTRIAN) -> Infraction:
    return Infraction(kind=kind, time=1.0, x=0.0, y=0.0, progress=1.0)


def test_reward_is_one_on_a_free_route_at_the_desired_speed() -> None:
    terms = RoachReward()(step(seen()))
    assert sum(terms.values()) == pytest.approx(1.0)
    assert list(terms) == ["speed", "position", "rotation", "action", "terminal"]


@pytest.mark.parametrize(
    ("other", "wanted"),
    [
        ((9.0, 0.0, 0.0), TOP / 5.0),  # a metre beyond where to stop, of a ramp of 5 m
        ((8.0, 0.0, 0.0), 0.0),
        ((10.0, 0.0, 0.0), TOP),  # too far
        ((6.0, 6.5, 0.0), TOP),  # beyond 45 degrees
        ((8.0, 0.0, math.pi), TOP),  # oncoming
        ((-8.0, 0.0, 0.0), TOP),  # behind
    ],
)
def test_vehicles_ahead_lower_the_desired_speed(
    other: tuple[float, float, float], wanted: float
) -> None:
    assert desired_speed(seen(other), TOP) == pytest.approx(wanted, abs=1e-4)


def test_actors_beside_the_route_do_not_lower_the_desired_speed() -> None:
    beside, on_it = (7.0, 2.5, 0.0), (7.0, 0.5, 0.0)
    assert desired_speed(seen(beside, first=PARKED.start), TOP) == TOP
    assert desired_speed(seen(on_it, first=PARKED.start), TOP) == 0.0
    assert desired_speed(seen(beside, kind=ActorKind.PEDESTRIAN), TOP) == TOP
    assert desired_speed(seen(on_it, kind=ActorKind.PEDESTRIAN), TOP) < 2.0


def test_red_light_lowers_the_desired_speed_and_green_does_not() -> None:
    distance = 7.5 - 0.5 * EGO_LENGTH  # the line is 7.5 m from the centre, which may go 2.5 m
    assert desired_speed(seen(light=NextLight(Light.RED, distance)), TOP) == pytest.approx(3.0)
    assert desired_speed(seen(light=NextLight(Light.GREEN, distance)), TOP) == TOP
    assert desired_speed(seen(light=NextLight(Light.RED, -1.5)), TOP) == TOP  # crossed


def test_position_heading_and_steering_errors_are_penalised() -> None:
    turned = make_ego(TOP, y=1.0, yaw=0.3)
    given = step(seen(ego=turned, offset=1.0), control=Control(0.0, 0.1))
    terms = RoachReward()(given)
    assert terms["position"] == -0.5
    assert terms["rotation"] == pytest.approx(-0.3)
    assert terms["action"] == -0.1


def test_terminal_reward_is_minus_one_and_less_after_a_collision() -> None:
    assert RoachReward()(step(seen(), infractions=(hit(),)))["terminal"] == -1.0 - TOP
    assert RoachReward()(step(seen(), status=Status.DEVIATED))["terminal"] == -1.0
    assert RoachReward()(step(seen(), status=Status.COMPLETED))["terminal"] == 0.0


def test_progress_reward_is_metres_minus_penalties() -> None:
    light = hit(InfractionKind.RED_LIGHT)
    terms = ProgressReward(lost=100.0)(step(seen(), infractions=(hit(), light), outside=0.25))
    assert terms == pytest.approx({"progress": 0.5, "outside": -0.25, "infractions": -80.0})


def test_custom_reward_is_used_unchanged() -> None:
    def mine(transition: Transition) -> dict[str, float]:
        return {"mine": transition.progress}

    assert reward_of(mine) is mine
    assert isinstance(reward_of("progress"), ProgressReward)
    for wrong in ("raoch", 3):
        with pytest.raises(InputError, match="[Rr]eward"):
            reward_of(wrong)
