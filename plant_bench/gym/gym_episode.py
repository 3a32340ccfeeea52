"""One episode of the environment, driven one decision per call instead of in a loop."""

from collections.abc import Iterable

from plant_bench.agent import Control, Observation, Plan
from plant_bench.controller import control_of
from plant_bench.gym.transition import Transition
from plant_bench.runner.episode.jobs import Job
from plant_bench.runner.episode.loop import Episode
from plant_bench.scoring.results import EpisodeResult
from plant_bench.sensing.inputs import PERCEIVED
from plant_bench.sensing.observe import Sensors
from plant_bench.world.town import Town


class DrivenEpisode:
    """A running scenario with its referee; mutable. `close` or the episode's end stops SUMO.

    Args:
        job: The episode to drive; its agent is only a name.
        inputs: The inputs of the observations; none may be privileged.

    Attributes:
        referee: Scores each tick.
        observation: The current observation.
        open: Whether the episode is still running.

    Raises:
        SimulationError: SUMO fails.
    """

    def __init__(self, job: Job, inputs: Iterable[str] = PERCEIVED) -> None:
        self._job = job
        self._sensors = Sensors(job.route, job.seed, inputs)
        self._episode = episode = Episode(job.scenario)
        self.town: Town = episode.simulation.town
        self.referee = episode.referee
        self.open = True
        self.observation: Observation = self._observe()
        self._control = Control(0.0, 0.0)
        self._result: EpisodeResult | None = None

    @property
    def under_way(self) -> bool:
        """Whether the episode is running and has made at least one step."""
        return self.open and self._episode.scene.tick > 0

    @property
    def result(self) -> EpisodeResult | None:
        """The record, as `plant-bench score` would have written it; None before the end."""
        return self._result

    def drive(self, action: Plan | Control, ticks: int) -> Transition:
        """Execute an action for some ticks, or until the episode ends.

        Raises:
            SimulationError: SUMO has lost the ego.
            RuntimeError: The episode is closed.
        """
        if not self.open:
            message = "The episode is closed."
            raise RuntimeError(message)
        episode, referee = self._episode, self.referee
        before, last_control = episode.scene, self._control
        earlier, progress = len(referee.infractions), referee.progress
        outside = referee.outside_distance
        self._control = control_of(action, before.ego)
        for _ in range(ticks):
            episode.advance(self._control)
            if episode.over:
                break
        self.observation = self._observe()
        transition = Transition(
            before=before,
            after=episode.scene,
            observation=self.observation,
            control=self._control,
            last_control=last_control,
            progress=referee.progress - progress,
            outside=referee.outside_distance - outside,
            infractions=tuple(referee.infractions[earlier:]),
            status=referee.status,
        )
        if episode.over:
            self._result = episode.result(self._job.header(self._sensors.inputs))
            self.close()
        return transition

    def close(self) -> None:
        """Stop SUMO; a second call does nothing."""
        if self.open:
            self._episode.close()
            self.open = False

    def _observe(self) -> Observation:
        referee = self.referee
        return self._sensors.observe(self._episode.scene, referee.progress, referee.offset)
