"""An `Agent` that forwards its calls to a planner in another process."""

import numpy as np
from jaxtyping import Float

from plant_bench.agent import Cause, Control, Observation, Plan, Reason
from plant_bench.agents.remote.launch_command import LaunchCommand
from plant_bench.agents.remote.messages import observation_out, reset_out
from plant_bench.agents.remote.planner_connection import Connection, Profile, first_profile
from plant_bench.agents.remote.process import Limits
from plant_bench.agents.remote.remote_errors import ProtocolError
from plant_bench.agents.remote.responses import ControlResponse, PlanResponse, Ranks, Ready
from plant_bench.errors import AgentError
from plant_bench.inference_timing import ForwardPass, record_pass
from plant_bench.world.route import Route


class RemoteAgent:
    """A planner in a separate process.

    Attributes:
        remote: Marks planners in other processes, whose `files` list all of their code and weights.

    Args:
        connection: The connection to the planner.
        profile: The planner's profile; a different one at a `reset` is an error.
    """

    remote = True

    def __init__(self, connection: Connection, profile: Profile) -> None:
        self._connection = connection
        self.profile = profile
        self.inputs = profile.inputs
        self.interval = profile.interval
        self.files = profile.files
        self.libraries = profile.libraries
        self._reason: Reason | None = None
        self._explain_failed: str | None = None

    def reset(self, route: Route | None) -> None:
        """Start a new episode, in a new process if the last one has failed."""
        connection = self._connection
        if not connection.alive and connection.begin() != self.profile:
            connection.close()
            message = "its hello differs from that of its first process."
            raise ProtocolError(message)
        ready: Ready = connection.ask(reset_out(route), Ready, starting=True)
        self.interval = ready.interval

    def act(self, observation: Observation) -> Plan | Control:
        """Return the planner's action."""
        request = observation_out("act", observation)
        response = self._connection.ask(request, ControlResponse, PlanResponse)
        for seconds, tokens in response.passes:
            record_pass(ForwardPass(seconds, tokens))
        reason, self._explain_failed = response.reason, response.explain_failed
        self._reason = None if reason is None else Reason(Cause(reason.cause), reason.actor)
        self.interval = response.interval
        if isinstance(response, ControlResponse):
            return Control(float(response.acceleration), float(response.steering))
        return Plan(self._connection.array(response.waypoints, axes=2))

    def explain(self) -> Reason | None:
        """Return the reason that came with the last action, or None."""
        if self._explain_failed is not None:
            raise AgentError(self._explain_failed)
        return self._reason


class RemoteRanker(RemoteAgent):
    """A remote planner that also ranks actors."""

    def rank(self, observation: Observation) -> Float[np.ndarray, " actors"]:
        """Return the relevance of each actor."""
        response: Ranks = self._connection.ask(observation_out("rank", observation), Ranks)
        return self._connection.array(response.values, axes=1)


def remote_agent(
    program: LaunchCommand, limits: Limits, profile: Profile | None = None
) -> RemoteAgent:
    """Return a planner in a separate process.

    Args:
        program: The command to start, and the planner to create in it.
        limits: Its time and memory limits.
        profile: Its profile from an earlier start. With it, the process starts at the first
            `reset`, so that a failure to start ends an episode; without it, it starts now.

    Raises:
        InputError: It does not start.
    """
    connection = Connection(program, limits)
    known = first_profile(connection) if profile is None else profile
    return (RemoteRanker if known.ranks else RemoteAgent)(connection, known)
