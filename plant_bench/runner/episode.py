"""One episode: the one loop in which everything meets."""

import hashlib
import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
from pydantic import BaseModel, ConfigDict

from plant_bench.agent import (
    Agent,
    Control,
    Input,
    Observation,
    Plan,
    check_action,
    decision_interval,
)
from plant_bench.agents.control import follow_plan
from plant_bench.agents.registry import load_agent
from plant_bench.data.recording import Recorder
from plant_bench.errors import AgentError
from plant_bench.runner.observing import observe
from plant_bench.scoring.infractions import Status
from plant_bench.scoring.referee import Referee, result_of
from plant_bench.scoring.results import Crash, EpisodeHeader, EpisodeResult
from plant_bench.sim.simulation import Simulation
from plant_bench.world.route import PROTOCOL, Route, Scenario
from plant_bench.world.scene import TICK
from plant_bench.world.town import town_checksum

PROGRESS_INTERVAL = 100  # ticks between two calls of the progress callback


@dataclass(frozen=True)
class Job:
    """One episode to be driven; picklable.

    Attributes:
        agent: As given to `load_agent`.
        agent_checksum: Content hash of the agent.
        route: To drive.
        repetition: From 0.
        seed: The scenario's seed.
        density: Of the traffic.
    """

    agent: str
    agent_checksum: str
    route: Route
    repetition: int
    seed: int
    density: str

    @cached_property
    def scenario(self) -> Scenario:
        """What the episode depends on, apart from the agent."""
        return Scenario(self.route, self.seed, self.density)

    @cached_property
    def key(self) -> str:
        """A content hash: of the agent, the scenario, the town and the rules."""
        parts = (
            PROTOCOL,
            self.agent,
            self.agent_checksum,
            self.scenario.key,
            str(self.repetition),
            town_checksum(self.route.town),
        )
        return hashlib.sha256("|".join(parts).encode()).hexdigest()

    def header(self, inputs: frozenset[Input]) -> EpisodeHeader:
        """Return what is known before the episode starts."""
        return EpisodeHeader(
            protocol=PROTOCOL,
            agent=self.agent,
            agent_checksum=self.agent_checksum,
            inputs=tuple(sorted(inputs)),
            route=self.route.id,
            town=self.route.town,
            scenario=self.scenario.key,
            repetition=self.repetition,
            seed=self.seed,
            density=self.density,
            town_checksum=town_checksum(self.route.town),
            route_checksum=self.route.checksum,
        )


class Timing(BaseModel):
    """All of an episode that depends on the clock; no score does.

    Attributes:
        wall_s: Wall time of the whole episode.
        start_up_s: Of it, until the first tick.
        simulation_s: Of it, in SUMO and the ego's model.
        privileged_s: Of it, gathering privileged facts.
        agent_s: Of it, in the agent.
        referee_s: Of it, judging.
        recording_s: Of it, writing the recording.
        simulated_s: Simulated time.
        ticks: Ticks driven.
        latency_p50_ms: Median time of one decision.
        latency_p95_ms: 95th percentile.
        latency_p99_ms: 99th percentile.
        late_share: Share of decisions that took longer than a tick.
    """

    model_config = ConfigDict(frozen=True)

    wall_s: float
    start_up_s: float
    simulation_s: float
    privileged_s: float
    agent_s: float
    referee_s: float
    recording_s: float
    simulated_s: float
    ticks: int
    latency_p50_ms: float
    latency_p95_ms: float
    latency_p99_ms: float
    late_share: float


@dataclass(frozen=True)
class Episode:
    """An episode that has ended."""

    result: EpisodeResult
    timing: Timing


class _Stopwatch:
    """Adds up the wall time spent in each part of the loop; mutable."""

    def __init__(self) -> None:
        self.begin = self._last = time.perf_counter()
        self.spent: dict[str, float] = dict.fromkeys(
            ("start_up", "simulation", "privileged", "agent", "referee", "recording"), 0.0
        )
        self.decisions: list[float] = []

    def lap(self, part: str) -> None:
        now = time.perf_counter()
        duration = now - self._last
        self._last = now
        self.spent[part] += duration
        if part == "agent":
            self.decisions.append(duration)

    def timing(self, simulated: float, ticks: int) -> Timing:
        p50, p95, p99 = np.percentile(self.decisions or [0.0], (50, 95, 99)).tolist()
        late = sum(decision > TICK for decision in self.decisions)
        return Timing(
            wall_s=time.perf_counter() - self.begin,
            **{f"{part}_s": spent for part, spent in self.spent.items()},
            simulated_s=simulated,
            ticks=ticks,
            latency_p50_ms=1000.0 * p50,
            latency_p95_ms=1000.0 * p95,
            latency_p99_ms=1000.0 * p99,
            late_share=late / max(len(self.decisions), 1),
        )


def run_episode(
    job: Job,
    *,
    recording: Path | None = None,
    progress: Callable[[float], None] | None = None,
) -> Episode:
    """Drive one episode to its end.

    Args:
        job: What to drive.
        recording: Where to write every tick, if anywhere.
        progress: Told the share of the route driven, now and then.

    Raises:
        InputError: The agent, the town or the density does not exist.
        SimulationError: SUMO fails; the episode says nothing about the agent then.
    """
    watch = _Stopwatch()
    agent = load_agent(job.agent)
    header = job.header(agent.inputs)
    recorder = None if recording is None else Recorder(recording, header.model_dump(mode="json"))
    crash: Crash | None = None
    with Simulation(job.scenario) as simulation:
        referee = Referee(simulation.town, job.route)
        try:
            _drive(agent, simulation, referee, job.route, recorder, watch, progress)
        except AgentError as error:
            crash = Crash(Status.AGENT_CRASHED, str(error))
        scene = simulation.scene
    if recorder is not None:
        recorder.add(scene)
        recorder.close(**({} if crash is None else vars(crash)))
        watch.lap("recording")
    return Episode(result_of(referee, header, crash=crash), watch.timing(scene.time, scene.tick))


def _drive(
    agent: Agent,
    simulation: Simulation,
    referee: Referee,
    route: Route,
    recorder: Recorder | None,
    watch: _Stopwatch,
    progress: Callable[[float], None] | None,
) -> None:
    """Drive until the referee ends the episode, or the agent fails."""
    inputs = agent.inputs
    privileged = Input.PRIVILEGED in inputs
    interval = decision_interval(agent)
    scene = simulation.scene
    referee.judge(scene)
    _reset(agent, route if Input.ROUTE in inputs else None)
    control = Control(0.0, 0.0)
    watch.lap("start_up")
    while referee.status is None:
        action: Plan | Control | None = None
        if scene.tick % interval == 0:
            facts = simulation.privileged() if privileged else None
            watch.lap("privileged")
            observation = observe(scene, route, referee.progress, referee.offset, inputs, facts)
            watch.lap("simulation")
            action = _act(agent, observation)
            watch.lap("agent")
            control = action if isinstance(action, Control) else follow_plan(action, scene.ego)
        if recorder is not None:
            recorder.add(scene, action)
        scene = simulation.step(control)
        watch.lap("simulation")
        referee.judge(scene)
        watch.lap("referee")
        if progress is not None and scene.tick % PROGRESS_INTERVAL == 0:
            progress(referee.completion)


def _reset(agent: Agent, route: Route | None) -> None:
    try:
        agent.reset(route)
    except Exception as error:
        message = f"reset raised {type(error).__name__}: {error}"
        raise AgentError(message) from error


def _act(agent: Agent, observation: Observation) -> Plan | Control:
    try:
        action = agent.act(observation)
    except Exception as error:
        message = f"act raised {type(error).__name__}: {error}"
        raise AgentError(message) from error
    return check_action(action)
