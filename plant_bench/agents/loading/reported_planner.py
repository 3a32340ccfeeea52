"""A planner whose exceptions are logged with their traceback, and say where they were raised."""

from functools import partial
from typing import Any

from plant_bench.agent import Agent, Control, Observation, Plan
from plant_bench.user_code import call_reported
from plant_bench.world.route import Route


class ReportedPlanner:
    """Calls another planner; see `call_reported`. All other attributes are the planner's own.

    Attributes:
        inputs: The planner's inputs.

    Args:
        agent: The planner.
    """

    def __init__(self, agent: Agent) -> None:
        self._agent = agent
        self.inputs = agent.inputs

    def __getattr__(self, name: str) -> Any:
        if name == "_agent":  # asked for while a copy is made
            raise AttributeError(name)
        value = getattr(self._agent, name)
        return partial(call_reported, value) if name == "explain" and callable(value) else value

    def reset(self, route: Route | None) -> None:
        """Start a new episode."""
        call_reported(self._agent.reset, route)

    def act(self, observation: Observation) -> Plan | Control:
        """Return the planner's action."""
        return call_reported(self._agent.act, observation)
