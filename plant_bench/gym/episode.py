"""One episode driven from outside: the loop of `runner.episode`, one decision at a time."""

from plant_bench.agent import Control, Input, Observation, Plan
from plant_bench.controller import control_of
from plant_bench.gym.transition import Transition
from plant_bench.runner.episode.jobs import Job
from plant_bench.scoring.referee import Referee, result_of
from plant_bench.scoring.results import EpisodeResult, HazardRecord
from plant_bench.sensing.observe import observe
from plant_bench.sim.simulation import Simulation
from plant_bench.world.town import Town

INPUTS = frozenset({Input.OBJECTS, Input.ROUTE, Input.LIGHT})  # nothing privileged


class DrivenEpisode:
    """A scenario in motion and its referee; mutable. SUMO ends with the episode, or by `close`.

    Args:
        job: What to drive; its agent is a name only.

    Attributes:
        referee: Judges each tick.
        observation: What a planner is given now.

    Raises:
        SimulationError: SUMO fails.
    """

    def __init__(self, job: Job) -> None:
        self._job = job
        self._simulation: Simulation | None = Simulation(job.scenario)
        self.town: Town = self._simulation.town
        self.referee = Referee(self.town, job.route)
        self._scene = self._simulation.scene
        self.referee.judge(self._scene)
        self.observation: Observation = self._observe()
        self._control = Control(0.0, 0.0)
        self._result: EpisodeResult | None = None

    @property
    def under_way(self) -> bool:
        """Whether it goes on, and has moved."""
        return self._simulation is not None and self._scene.tick > 0

    @property
    def open(self) -> bool:
        """Whether it can be driven on."""
        return self._simulation is not None

    @property
    def result(self) -> EpisodeResult | None:
        """The record, as `plant-bench score` would have written it; None before the end."""
        return self._result

    def drive(self, action: Plan | Control, ticks: int) -> Transition:
        """Carry an action out for some ticks, or until the episode ends.

        Raises:
            SimulationError: SUMO has lost the ego.
            RuntimeError: The episode is closed.
        """
        if self._simulation is None:
            message = "The episode is closed."
            raise RuntimeError(message)
        before, referee = self._scene, self.referee
        noted, progress = len(referee.infractions), referee.progress
        outside, last_control = referee.outside_distance, self._control
        self._control = control_of(action, before.ego)
        for _ in range(ticks):
            self._scene = self._simulation.step(self._control)
            referee.judge(self._scene)
            if referee.status is not None:
                break
        self.observation = self._observe()
        transition = Transition(
            before=before,
            after=self._scene,
            observation=self.observation,
            control=self._control,
            last_control=last_control,
            progress=referee.progress - progress,
            outside=referee.outside_distance - outside,
            infractions=tuple(referee.infractions[noted:]),
            status=referee.status,
        )
        if referee.status is not None:
            self._finish(self._simulation)
        return transition

    def close(self) -> None:
        """End SUMO; asked again, do nothing."""
        if self._simulation is not None:
            self._simulation.close()
            self._simulation = None

    def _observe(self) -> Observation:
        referee, route = self.referee, self._job.route
        return observe(self._scene, route, referee.progress, referee.offset, INPUTS, None)

    def _finish(self, simulation: Simulation) -> None:
        hazards = tuple(
            HazardRecord.model_validate(outcome._asdict()) for outcome in simulation.outcomes
        )
        self._result = result_of(self.referee, self._job.header(INPUTS), hazards=hazards)
        self.close()
