"""Planners that are asked while somebody else drives: they answer, and nobody obeys."""

import copy
from dataclasses import dataclass

import numpy as np

from plant_bench.agent import Agent, Control, Input, Observation, Plan, Privileged, Ranker, Reason
from plant_bench.agent_check import check_action, decision_interval, reason_of
from plant_bench.agents.ranking.masking import Masking
from plant_bench.controller import control_of
from plant_bench.runner.asking import asked
from plant_bench.sensing.observe import observe
from plant_bench.world.route import Route
from plant_bench.world.scene import Scene


@dataclass(frozen=True, eq=False, slots=True)
class Answer:
    """What a planner answers to one scene.

    Attributes:
        tick: Of the scene.
        action: Its plan or control.
        control: The control that carries it out.
        reason: Why; None where it does not explain itself.
        ranking: The ids of the actors that matter to it, the most relevant first; None where it was
            not asked for, or nobody can tell.
    """

    tick: int
    action: Plan | Control
    control: Control
    reason: Reason | None
    ranking: tuple[int, ...] | None = None


class Shadow:
    """Asks one planner as the loop of an episode would, through one episode; mutable.

    Attributes:
        privileged: Whether it must be given what only the simulator knows.
        ranks_itself: Whether its ranking is its own; else it is by masking.

    Args:
        agent: The planner, which is reset here.
        route: The route being driven.

    Raises:
        AgentError: It cannot be reset.
    """

    def __init__(self, agent: Agent, route: Route) -> None:
        self._agent = agent
        self._route = route
        self._due = 0
        self.privileged = Input.PRIVILEGED in agent.inputs
        self.ranks_itself = isinstance(agent, Ranker)
        plan = route.plan if Input.ROUTE in agent.inputs else None
        asked("reset", agent.reset, plan)

    def due(self, tick: int) -> bool:
        """Tell whether the planner decides at this tick."""
        return tick >= self._due

    def answer(
        self,
        scene: Scene,
        progress: float,
        offset: float,
        facts: Privileged | None,
        *,
        ranking: bool = False,
    ) -> Answer:
        """Return what the planner answers; to be called when it is due.

        Args:
            scene: What there is.
            progress: Metres of the route that the ego has driven.
            offset: Its lateral distance from the route, positive to the left.
            facts: What only the simulator knows, if the planner is to have it.
            ranking: Whether to ask who matters, too.

        Raises:
            AgentError: The planner fails.
        """
        agent = self._agent
        seen = observe(scene, self._route, progress, offset, agent.inputs, facts)
        before = _copied(agent) if ranking and Input.OBJECTS in agent.inputs else None
        action = check_action(asked("act", agent.act, seen))
        reason = asked("explain", reason_of, agent)
        self._due = scene.tick + decision_interval(agent)
        ranks = None if before is None else ranking_of(before, seen)
        return Answer(scene.tick, action, control_of(action, scene.ego), reason, ranks)


def ranking_of(agent: Agent, seen: Observation) -> tuple[int, ...]:
    """Return the ids of the actors in sight, the most relevant to a planner first.

    A planner that has no `rank` is asked by masking, which changes its memory: give it a copy. Who
    changes nothing is no part of that ranking.

    Raises:
        AgentError: The planner fails.
    """
    actors = seen.actors
    if actors is None or not len(actors):
        return ()
    itself = isinstance(agent, Ranker)
    ranks = np.asarray(asked("rank", (agent if itself else Masking(agent)).rank, seen))
    order = np.lexsort((actors.ids, -ranks))
    return tuple(int(actors.ids[place]) for place in order if itself or ranks[place] > 0.0)


def _copied(agent: Agent) -> Agent | None:
    """Return a copy that can be asked without the planner's noticing; None if there can be none."""
    try:
        return copy.deepcopy(agent)
    except Exception:  # noqa: BLE001  whatever a planner holds that cannot be copied
        return None


def same_answer(answer: Answer, recorded: Plan | Control | None) -> bool:
    """Tell whether an answer is what was recorded at its tick, but for rounding of the network."""
    action = answer.action
    if isinstance(action, Plan) and isinstance(recorded, Plan):
        return bool(np.allclose(action.waypoints, recorded.waypoints, rtol=0.0, atol=1e-4))
    if isinstance(action, Control) and isinstance(recorded, Control):
        pair = (action.acceleration, action.steering), (recorded.acceleration, recorded.steering)
        return bool(np.allclose(*pair, rtol=0.0, atol=1e-6))
    return False
