"""A planner in another process, as the loop sees it: an ordinary `Agent`."""

import numpy as np
from jaxtyping import Float

from plant_bench.agent import Cause, Control, Observation, Plan, Reason
from plant_bench.agents.remote.launch_command import LaunchCommand
from plant_bench.agents.remote.messages import observation_out, reset_out
from plant_bench.agents.remote.process import Limits
from plant_bench.agents.remote.process_reuse import Connection, Profile, first_profile
from plant_bench.agents.remote.remote_errors import ProtocolError
from plant_bench.agents.remote.responses import ControlAnswer, PlanAnswer, Ranks, Ready
from plant_bench.errors import AgentError
from plant_bench.inference_timing import ForwardPass, tell_pass
from plant_bench.world.route import Route


class RemoteAgent:
    """Asks a planner in a process of its own.

    Attributes:
        remote: Whether the planner is in another process: `files` are all that it is made of then.

    Args:
        connection: To the planner.
        profile: What it said of itself; another answer at a `reset` is a failure.
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
        """Start a new episode, in a new process where the last one failed."""
        connection = self._connection
        if not connection.alive and connection.begin() != self.profile:
            connection.close()
            message = "it says of itself something else than when it was first asked."
            raise ProtocolError(message)
        ready: Ready = connection.ask(reset_out(route), Ready, starting=True)
        self.interval = ready.interval

    def act(self, observation: Observation) -> Plan | Control:
        """Let it decide."""
        question = observation_out("act", observation)
        answer = self._connection.ask(question, ControlAnswer, PlanAnswer)
        for seconds, tokens in answer.passes:
            tell_pass(ForwardPass(seconds, tokens))
        told, self._explain_failed = answer.reason, answer.explain_failed
        self._reason = None if told is None else Reason(Cause(told.cause), told.actor)
        self.interval = answer.interval
        if isinstance(answer, ControlAnswer):
            return Control(float(answer.acceleration), float(answer.steering))
        return Plan(self._connection.array(answer.waypoints, axes=2))

    def explain(self) -> Reason | None:
        """Return the reason that came with the last action, if any did."""
        if self._explain_failed is not None:
            raise AgentError(self._explain_failed)
        return self._reason


class RemoteRanker(RemoteAgent):
    """One that also says which actors matter to it."""

    def rank(self, observation: Observation) -> Float[np.ndarray, " actors"]:
        """Return the relevance of each actor."""
        answer: Ranks = self._connection.ask(observation_out("rank", observation), Ranks)
        return self._connection.array(answer.values, axes=1)


def remote_agent(
    program: LaunchCommand, limits: Limits, profile: Profile | None = None
) -> RemoteAgent:
    """Return a planner in a process of its own.

    Args:
        program: What to start, and which planner to ask for in it.
        limits: What it may take.
        profile: What it said of itself earlier: it is started with the first `reset` then, so that
            a failure to start ends an episode. Without it, it is started now.

    Raises:
        InputError: It does not start.
    """
    connection = Connection(program, limits)
    known = first_profile(connection) if profile is None else profile
    return (RemoteRanker if known.ranks else RemoteAgent)(connection, known)
