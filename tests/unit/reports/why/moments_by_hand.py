"""Hand-made moments: an ego that drives at 10 m/s towards the stationary car 17."""

from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np

from plant_bench.agent import (
    Cause,
    Control,
    NextLight,
    Plan,
    Reason,
)
from plant_bench.reports.why.incidents import Incident, incidents
from plant_bench.runner.decisions import Decision
from plant_bench.runner.review.review_frames import Moment, Postmortem
from plant_bench.scoring.infractions import Infraction, InfractionKind, Status
from plant_bench.scoring.results import EpisodeResult
from plant_bench.world.route import Passage, Route
from plant_bench.world.scene import TICK, ActorKind, Light, Scene
from tests.builders import (
    CAR_EXTENT,
    first_lane,
    make_actors,
    make_ego,
    make_scene,
    observation_on,
    straight_route,
)

FOE, BYSTANDER = 17, 500_001
SPEED, START, FOE_AT, LINE = 10.0, 20.0, 60.1, 50.0  # m/s, m
HIT = 71  # the tick at which the boxes overlap
PLAN = Plan(np.array([[5.0, 0.0], [10.0, 0.0], [15.0, 0.0], [20.0, 0.0]]))

Answers = Callable[[int], tuple[float, Reason | None]]


@cache
def route(metres: int = 100) -> Route:
    """A straight route to the east, on an existing lane."""
    passage = Passage("j", LINE, LINE + 20.0, "straight", "signal", "s", 0)
    return straight_route(
        metres,
        name="town01-0",
        town="town01",
        lane=first_lane("town01"),
        speed_limit=8.33,
        passages=[passage],
    )


def infraction(kind: InfractionKind = InfractionKind.COLLISION_VEHICLE, **facts: Any) -> Infraction:
    """The hit at the tick `HIT`, or another infraction then."""
    known: dict[str, Any] = {"time": HIT * TICK, "x": 55.5, "y": 0.0, "progress": 55.5}
    if kind is InfractionKind.COLLISION_VEHICLE:
        known |= {"actor": FOE, "actor_kind": ActorKind.CAR, "cause": "ego"}
    return Infraction(kind=kind, **(known | facts))


def record(*infractions: Infraction, **changes: Any) -> EpisodeResult:
    """An episode's record."""
    known: dict[str, Any] = {
        "protocol": "longest6-sumo-v2-rc2", "agent": "plant", "agent_checksum": "c0ffee",
        "inputs": ("objects", "route"), "route": "town01-0", "town": "town01",
        "scenario": "0123456789abcdef", "repetition": 0, "seed": 7, "density": "dense",
        "town_checksum": "aa", "route_checksum": "bb", "status": Status.COMPLETED,
        "route_length": 100.0, "completion": 1.0, "distance": 100.0, "duration": 9.0,
        "infractions": infractions,
    }  # fmt: skip
    return EpisodeResult(**(known | changes))


def scene(tick: int, *, speed: float = SPEED, light: Light = Light.UNKNOWN) -> Scene:
    """The ego on its way to car 17, a pedestrian at the side."""
    actors = make_actors(
        [(FOE_AT, 0.0, 0.0), (40.0, 8.0, 1.0)],
        speeds=(0.0, 1.0),
        extents=[CAR_EXTENT, (0.5, 0.5)],
        kinds=(ActorKind.CAR, ActorKind.PEDESTRIAN),
        ids=(FOE, BYSTANDER),
    )
    x = START + SPEED * tick * TICK if speed else FOE_AT - 8.0
    return make_scene(tick, ego=make_ego(speed, x=x), actors=actors, lights=[light])


def moment(tick: int, expert: Answers, **changes: Any) -> Moment:
    """One moment; the planner requests zero control and ranks the pedestrian first."""
    light = changes.pop("light", Light.UNKNOWN)
    at = scene(tick, speed=changes.pop("speed", SPEED), light=light)
    shown = NextLight(light, LINE - at.ego.x - 2.45)
    seen = observation_on(
        route(), at.ego.x, speed=at.ego.speed, time=at.time, actors=at.actors, light=shown
    )
    pull, reason = expert(tick)
    ranking = changes.pop("ranking", (BYSTANDER, FOE))
    planner = Decision(tick, PLAN, Control(0.0, 0.0), None, ranking)
    known: dict[str, Any] = {
        "scene": at, "seen": seen, "control": Control(0.0, 0.0), "plan": PLAN,
        "planned_at": at.ego, "planner": planner,
        "expert": Decision(tick, Control(pull, 0.0), Control(pull, 0.0), reason),
    }  # fmt: skip
    return Moment(**(known | changes))


def braking_from(first: int, actor: int = FOE, cause: Cause = Cause.CONFLICT) -> Answers:
    """An expert that brakes from a tick on, for one reason."""
    return lambda tick: (-3.5, Reason(cause, actor)) if tick >= first else (0.5, Reason(Cause.FREE))


def postmortem(
    item: Infraction, moments: list[Moment], **changes: Any
) -> tuple[Incident, Postmortem]:
    """An episode with one infraction."""
    result = record(item)
    known: dict[str, Any] = {
        "result": result, "route": route(), "moments": {one.scene.tick: one for one in moments},
        "ticks": 100, "difference": "", "differs_at": None, "planner_note": "",
        "ranked_itself": True, "expert_note": "",
    }  # fmt: skip
    return incidents(result, 3.0)[0], Postmortem(**(known | changes))


def lights(red_from: int) -> Callable[[int], Light]:
    """A light that turns red."""
    return lambda tick: Light.RED if tick >= red_from else Light.YELLOW
