"""Drives one episode in this process and yields every tick: `plant_bench.drive`, for debugging."""

import os
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any, cast

from plant_bench.agent import Agent, Control, Input, Observation, Plan, Reason
from plant_bench.agents.loading.registry import load_agent
from plant_bench.api.numbers import HIGHEST_SEED, MOST_REPETITIONS, check_whole_number
from plant_bench.api.planners import PlannerLike, check_planner, is_planner_factory, resolve
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
    """One tick of an episode: the scene, the planner's observation and its action.

    Attributes:
        scene: State of the world.
        observation: The planner's observation; None at ticks without a decision (a planner with an
            `interval` skips ticks) and at the last scene.
        action: The planner's plan or control; None at ticks without a decision.
        control: Control executed until the next step; None at the last scene.
        reason: The planner's own explanation, if it gives one.
        infractions: Infractions so far, in chronological order.
        completion: Fraction of the route driven so far, 0 to 1.
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
    """Drive one episode in this process; yield each tick while driving.

    With the same arguments, `score` drives the same episode. A planner object is used directly, not
    copied, so it can be inspected between ticks. A process can drive only one episode at a time,
    since SUMO allows one simulation per process. Leaving the loop ends the episode.

    Args:
        planner: A name, "module:Class", "file.py:Class", a class or an object.
        route: A route, or the id or number of one in the suite.
        suite: A suite's name, or a folder or file of routes.
        repetition: Repetition of the route, from 0.
        seed: Base seed of the traffic.
        density: Traffic density.
        hazards: Whether the route's hazards are enabled.

    Raises:
        InputError: There is no such planner or route.
        AgentError: The planner fails.
        SimulationError: SUMO fails.
    """
    check_whole_number("repetition", repetition, 0, MOST_REPETITIONS - 1)
    check_whole_number("seed", seed, 0, HIGHEST_SEED)
    chosen = route if isinstance(route, Route) else _route(suite, str(route))
    agent = _make_planner(planner)
    traffic = repetition_seed(seed, chosen.id, repetition)
    return _steps(agent, Scenario(chosen, traffic, density, hazards))


def _steps(agent: Agent, scenario: Scenario) -> Iterator[Step]:
    """Yield the ticks of an episode and its last scene."""
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
                **_scores_so_far(episode.referee),
            )
        yield Step(episode.scene, None, None, None, None, **_scores_so_far(episode.referee))


def _scores_so_far(referee: Referee) -> dict[str, Any]:
    return {
        "infractions": tuple(referee.infractions),
        "completion": referee.completion,
        "status": referee.status,
    }


def _make_planner(planner: PlannerLike) -> Agent:
    """Return a planner object to drive in this process.

    Raises:
        InputError: The argument is not a planner, or a planner cannot be created from it.
    """
    if isinstance(planner, str):
        return load_agent(resolve(planner).spec)
    if not is_planner_factory(planner):
        return check_planner(planner)
    make = cast("Callable[[], object]", planner)
    try:
        return check_planner(make())
    except TypeError as error:
        message = f"The planner cannot be created: {error}."
        raise InputError(message) from error


def _route(suite: str | os.PathLike[str], name: str) -> Route:
    routes = select_routes(load_suite(os.fspath(suite)), name)
    if len(routes) != 1:
        message = f"route: expected one route, got '{name}', which selects {len(routes)}."
        raise InputError(message)
    return routes[0]
