"""The server side of the protocol for planners in Python; `--isolate` starts it.

    python -P -m plant_bench.agents.remote.planner_server

The planner's output goes to standard error, since standard output carries the protocol.
"""

import os
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np

from plant_bench.agent import Agent, Control, Observation, Plan, Ranker
from plant_bench.agent_check import check_action, decision_interval, reason_of
from plant_bench.agents.loading.checksum import PlannerComponents, components_of_loaded
from plant_bench.agents.loading.registry import load_agent
from plant_bench.agents.remote.codec import MOST_AXES, MOST_PASSES, array_out, pack, unpack
from plant_bench.agents.remote.messages import (
    PROTOCOL_VERSION,
    Wire,
    observation_in,
    route_in,
)
from plant_bench.agents.remote.process import LENGTH
from plant_bench.errors import AgentError, InputError
from plant_bench.inference_timing import listen_to_passes
from plant_bench.user_code import code_location, located_text, log_traceback


def main() -> None:
    """Serve requests until the benchmark closes its pipe."""
    requests, responses = _protocol_pipes()
    server = _PlannerServer()
    while (data := _read(requests, LENGTH.size)) is not None:
        request = _read(requests, LENGTH.unpack(data)[0])
        if request is None:
            return
        response = pack(server.handle(unpack(request)))
        _write(responses, LENGTH.pack(len(response)) + response)


class _PlannerServer:
    """Serves one planner; each "hello" creates a new one."""

    def __init__(self) -> None:
        self._agent: Agent | None = None
        self._folder = Path.cwd()
        self._components: PlannerComponents | None = None
        self._handlers: dict[str, Callable[[Wire], Wire]] = {
            "hello": self._hello,
            "reset": self._reset,
            "act": self._act,
            "rank": self._rank,
        }

    def handle(self, request: Wire) -> Wire:
        """Return the response to a request; exceptions of the planner become "failed" responses."""
        try:
            return self._handlers[request["type"]](request)
        except BaseException as error:  # noqa: BLE001  SystemExit and KeyboardInterrupt included
            return _failed(error)

    def _hello(self, request: Wire) -> Wire:
        spec = request["agent"]
        os.chdir(self._folder)  # the planner's code may change it, here and at any time
        self._agent = agent = load_agent(spec)
        if self._components is None:
            folder = Path.cwd()
            os.chdir(self._folder)
            self._components = components_of_loaded(spec, agent, str(folder))
            os.chdir(folder)
        return {
            "type": "hello",
            "protocol": PROTOCOL_VERSION,
            "inputs": sorted(agent.inputs),
            "interval": decision_interval(agent),
            "ranks": isinstance(agent, Ranker),
            "files": sorted(map(str, self._components.files)),
            "libraries": sorted(self._components.libraries),
        }

    def _reset(self, request: Wire) -> Wire:
        agent, route = self._planner, request["route"]
        agent.reset(None if route is None else route_in(route))
        return {"type": "ready", "interval": decision_interval(agent)}

    def _act(self, request: Wire) -> Wire:
        agent, observation = self._planner, observation_in(request)
        passes = listen_to_passes()
        response = _action_out(agent.act(observation)) | _reason_out(agent)
        response["interval"] = decision_interval(agent)
        response["passes"] = [[item.seconds, item.tokens] for item in passes[-MOST_PASSES:]]
        return response

    def _rank(self, request: Wire) -> Wire:
        values = _ranks(self._planner, observation_in(request))
        return {"type": "ranks", "values": array_out(values)}

    @property
    def _planner(self) -> Agent:
        if self._agent is None:
            message = "expected hello as the first request."
            raise AgentError(message)
        return self._agent


def _ranks(agent: Agent, observation: Observation) -> np.ndarray:
    if not isinstance(agent, Ranker):
        message = "it has no method rank."
        raise AgentError(message)
    return np.asarray(agent.rank(observation))


def _action_out(action: Plan | Control) -> Wire:
    """Return an action's wire form; raises AgentError if it has none."""
    if isinstance(action, Control):
        try:
            numbers = float(action.acceleration), float(action.steering)
        except (TypeError, ValueError, OverflowError):
            check_action(action)  # raises with a clear message
            raise
        return {"type": "control", "acceleration": numbers[0], "steering": numbers[1]}
    if isinstance(action, Plan) and np.ndim(action.waypoints) <= MOST_AXES:
        try:
            waypoints = np.asarray(action.waypoints, dtype=float)
        except (TypeError, ValueError):
            check_action(action)
            raise
        return {"type": "plan", "waypoints": array_out(waypoints)}
    return _action_out(check_action(action))


def _reason_out(agent: Agent) -> Wire:
    try:
        reason = reason_of(agent)
    except AgentError as error:
        return {"explain_failed": _text(error)}
    except (Exception, SystemExit) as error:  # noqa: BLE001  a failed explain ends the episode
        log_traceback(error)
        text = f"explain raised {type(error).__name__}: {located_text(error)}"
        return {"explain_failed": text}
    if reason is None:
        return {}
    return {"reason": {"cause": int(reason.cause), "actor": int(reason.actor)}}


def _failed(error: BaseException) -> Wire:
    """Return the response to a request that raised an exception; log the planner's traceback."""
    if code_location(error):
        log_traceback(error)
    name = InputError.__name__ if isinstance(error, InputError) else type(error).__name__
    return {"type": "failed", "error": name, "message": located_text(error)}


def _text(error: BaseException) -> str:
    try:
        return str(error)[:2000].encode(errors="replace").decode()
    except Exception:  # noqa: BLE001  __str__ is the planner's code, too
        return "no text"


def _protocol_pipes() -> tuple[int, int]:
    """Move the protocol's pipes off standard input and output, which the planner may use."""
    requests, responses = os.dup(0), os.dup(1)
    null = os.open(os.devnull, os.O_RDONLY)
    os.dup2(null, 0)
    os.close(null)
    os.dup2(2, 1)
    sys.stdout = os.fdopen(1, "w", buffering=1, encoding="utf-8", errors="replace", closefd=False)
    return requests, responses


def _read(descriptor: int, size: int) -> bytes | None:
    """Return `size` bytes; None at the end of the pipe."""
    data = bytearray()
    while len(data) < size:
        part = os.read(descriptor, size - len(data))
        if not part:
            return None
        data += part
    return bytes(data)


def _write(descriptor: int, data: bytes) -> None:
    left = memoryview(data)
    while left:
        left = left[os.write(descriptor, left) :]


if __name__ == "__main__":
    main()
