"""One episode in this process, tick by tick: to look at what a planner sees, answers and causes."""

import os
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any, cast

from plant_bench.agent import Agent, Control, Input, Observation, Plan, Reason
from plant_bench.agents.loading.registry import load_agent
from plant_bench.api.planners import PlannerLike, check_planner, makes_planners, resolve
from plant_bench.errors import InputError
from plant_bench.runner.decisions import PlannerSession
from plant_bench.runner.episode.jobs import repetition_seed, select_routes
from plant_bench.runner.episode.loop import Episode
from plant_bench.runner.episode.loop import drive as drive_episode
from plant_bench.scoring.infractions import Infraction, Status
from plant_bench.scoring.referee import Referee
from plant_bench.world.route import Route, Scenario, load_suite
from plant_bench.world.scene import Scene


@dataclass(frozen=True, eq=False, slots=True)
class Step:
    """One tick of an episode: what there was, what the planner was given, and what it answered.

    Attributes:
        scene: The world.
        observation: What the planner was given; None where it did not decide, as at most ticks of
            one with an `interval`, and at the last scene.
        action: Its answer; None where it did not decide.
        control: What the ego does until the next step; None at the last scene.
        reason: Why, where the planner explains itself.
        infractions: So far, in order of time.
        completion: Share of the route driven so far, 0 to 1.
        status: How the episode ended; None before the last scene.
    """

    scene: Scene
    observation: Observation | None
    action: Plan | Control | None
    control: Control | None
    reason: Reason | None
    infractions: tuple[Infraction, ...]
    completion: float
    status: Status | None


def drive(
    planner: PlannerLike,
    route: str | int | Route,
    *,
    suite: str | os.PathLike[str] = "longest6",
    repetition: int = 0,
    seed: int = 0,
    density: str = "dense",
    hazards: bool = True,
) -> Iterator[Step]:
    """Drive one episode in this process, and give each of its ticks as it happens.

    It is the episode that `score` drives with the same arguments. An object is driven itself, not a
    copy, so that it can be looked at meanwhile. Only one episode at a time: SUMO is there once in a
    process. Leaving the loop ends it.

    Args:
        planner: A name, "module:Class", "file.py:Class", a class or an object.
        route: Its id or number in the suite, or a route.
        suite: A suite's name, or a folder or file of routes.
        repetition: Which of the route's episodes, from 0.
        seed: Base seed of the traffic.
        density: Of the traffic.
        hazards: Whether the route's hazards are played.

    Raises:
        InputError: There is no such planner or route.
        AgentError: The planner fails.
        SimulationError: SUMO fails.
    """
    agent = _made(planner)
    chosen = route if isinstance(route, Route) else _route(suite, str(route))
    traffic = repetition_seed(seed, chosen.id, repetition)
    return _steps(agent, Scenario(chosen, traffic, density, hazards))


def _steps(agent: Agent, scenario: Scenario) -> Iterator[Step]:
    """Give the ticks of an episode, and its last scene."""
    self_driving = Input.SIMULATOR in agent.inputs
    with Episode(scenario, self_driving=self_driving) as episode:
        planner = PlannerSession(agent, scenario.route, scenario.seed)
        for tick in drive_episode(episode, planner):
            decision = tick.decision
            yield Step(
                scene=tick.scene,
                observation=tick.observation,
                action=None if decision is None else decision.action,
                control=tick.control,
                reason=None if decision is None else decision.reason,
                **_judged(episode.referee),
            )
        yield Step(episode.scene, None, None, None, None, **_judged(episode.referee))


def _judged(referee: Referee) -> dict[str, Any]:
    return {
        "infractions": tuple(referee.infractions),
        "completion": referee.completion,
        "status": referee.status,
    }


def _made(planner: PlannerLike) -> Agent:
    """Return a planner to be driven in this process.

    Raises:
        InputError: It is none, or cannot be made.
    """
    if isinstance(planner, str):
        return load_agent(resolve(planner).spec)
    if not makes_planners(planner):
        return check_planner(planner)
    make = cast("Callable[[], object]", planner)
    try:
        return check_planner(make())
    except TypeError as error:
        message = f"The planner cannot be made: {error}."
        raise InputError(message) from error


def _route(suite: str | os.PathLike[str], name: str) -> Route:
    found = select_routes(load_suite(os.fspath(suite)), name)
    if len(found) != 1:
        message = f"'{name}' names {len(found)} routes: one is wanted."
        raise InputError(message)
    return found[0]
