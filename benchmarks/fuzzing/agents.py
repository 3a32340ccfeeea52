"""Fuzzing of responses of planner processes: valid responses and their readers."""

import fcntl
import os
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np

from fuzzing.form import Format, used
from plant_bench.agent import Observation
from plant_bench.agent_check import check_action, decision_interval, reason_of
from plant_bench.agents.remote.codec import array_out, pack
from plant_bench.agents.remote.launch_command import LaunchCommand
from plant_bench.agents.remote.planner_connection import Connection, Profile, _idle
from plant_bench.agents.remote.process import LENGTH, Limits, PlannerProcess
from plant_bench.agents.remote.remote_agent import RemoteRanker
from plant_bench.errors import AgentError
from plant_bench.world.scene import EgoState

PIPE = 1 << 20  # bytes that fit into it
DECISION: dict[str, Any] = {
    "interval": 2,
    "reason": {"cause": 1, "actor": 3},
    "passes": [[0.01, 12]],
}
WHOLE: tuple[dict[str, Any], ...] = (
    {"type": "hello", "protocol": 1, "inputs": ["objects"], "ranks": True, "files": ["a.py"]},
    {"type": "ready", "interval": 2},
    {"type": "control", "acceleration": 1.0, "steering": 0.1} | DECISION,
    {"type": "plan", "waypoints": array_out(np.ones((4, 2)))} | DECISION,
    {"type": "ranks", "values": array_out(np.ones(3))},
    {"type": "failed", "error": "ValueError", "message": "no lane"},
)
ASKED = Observation(0.0, EgoState(0.0, 0.0, 0.0, 1.0, 0.0, 0.0), 8.0)


class _Spoken(PlannerProcess):
    """A process whose pipe holds what a file says, and that ends then; mutable."""

    def __init__(self, said: bytes) -> None:
        self.limits, self.alive, self._said = Limits(), True, said[:PIPE]
        self._from, self._speaks = os.pipe()
        self._hears, self._to = os.pipe()
        self._status, status = os.pipe()
        self._control = os.open(os.devnull, os.O_RDONLY)
        os.close(status)
        fcntl.fcntl(self._speaks, fcntl.F_SETPIPE_SZ, PIPE)
        for end in (self._from, self._to, self._speaks):
            os.set_blocking(end, False)
        streams = [os.fdopen(end, mode) for end, mode in ((self._to, "wb"), (self._from, "rb"))]
        self._supervisor: Any = SimpleNamespace(
            wait=lambda _: None, stdin=streams[0], stdout=streams[1]
        )

    def _expect_silence(self) -> None:
        super()._expect_silence()
        os.write(self._speaks, self._said)
        os.close(self._speaks)

    def close(self) -> None:
        if self.alive:
            os.close(self._hears)
        super().close()


def _use_answer(box: Path) -> None:
    """Give an answer to each question there is; one at least must like it."""
    said = (box / "answer.bin").read_bytes()
    liked, refusal = 0, AgentError("nobody was asked")
    for question in ("reset", "act", "rank", "hello"):
        try:
            _ask(question, said)
            liked += 1
        except AgentError as error:
            refusal = error
    if not liked:
        raise refusal


def _ask(question: str, said: bytes) -> None:
    limits = Limits()
    connection = Connection(LaunchCommand("fuzzed", ("fuzzed",)), limits)
    connection._process = process = _Spoken(said)
    agent = RemoteRanker(connection, Profile(frozenset(), 1, True, ()))
    try:
        if question == "reset":
            agent.reset(None)
        elif question == "act":
            used(check_action(agent.act(ASKED)), reason_of(agent), decision_interval(agent))
        elif question == "rank":
            used(agent.rank(ASKED).sum())
        else:
            _idle[connection.program, limits] = process  # which `begin` takes over
            connection.begin()
    finally:
        process.close()


def _answer_seeds() -> list[bytes]:
    messages = [pack(message) for message in WHOLE]
    return [LENGTH.pack(len(message)) + message for message in messages[:-1]]


FORMATS = (Format("answer", "msgpack", "answer.bin", _answer_seeds, _use_answer),)
