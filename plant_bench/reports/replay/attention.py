"""The planner's attention to actors, recomputed on observations rebuilt from the recording."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int

from plant_bench.agent import Agent, Input, Observation, Plan, Ranker
from plant_bench.agents.loading.checksum import agent_checksum
from plant_bench.agents.loading.planner_spec import without_folders
from plant_bench.agents.loading.registry import load_agent
from plant_bench.data.recording import Recording
from plant_bench.data.tick_log import Action
from plant_bench.errors import PlantBenchError
from plant_bench.reports.replay.overlay import Progress
from plant_bench.runner.decisions import PlannerSession
from plant_bench.runner.review.actor_ranking import relevance_of
from plant_bench.scoring.results import EpisodeResult
from plant_bench.user_code import contained
from plant_bench.world.route import Route

SPACING = 10  # ticks between two samples: 2 Hz, as the planner's own history of actors
MOST_SHOWN = 8  # actors per sample
LEAST_SHOWN = 0.04  # least relevance shown, as a fraction of the largest
PROBES = 40  # plans to compare if the checksum differs
SAME_PLAN = 0.01  # m: tolerance between compared plans


@dataclass(frozen=True, eq=False)
class Attention:
    """Relevance of actors to the planner over time.

    Attributes:
        ticks: Ticks of the samples, ascending.
        starts: Index at which each sample begins in `actors` and `shares`, and the total length.
        actors: Ids, the most relevant first.
        shares: Relevance divided by that of the most relevant actor, 0 to 1.
        note: Why there is no attention; empty if there is.
    """

    ticks: Int[np.ndarray, " asked"]
    starts: Int[np.ndarray, " bounds"]
    actors: Int[np.ndarray, " shown"]
    shares: Float[np.ndarray, " shown"]
    note: str = ""

    @classmethod
    def absent(cls, note: str) -> "Attention":
        """Return an empty attention with the reason."""
        nothing = np.zeros(0, int)
        return cls(nothing, np.zeros(1, int), nothing, np.zeros(0), note)


@contained()
def attention_of(
    result: EpisodeResult, agent: str, recording: Recording, route: Route, progress: Progress
) -> Attention:
    """Return the relevance of actors twice a second, or why it is not available.

    If the planner's code or weights have changed since the recording, it is used only if it still
    makes the recorded plans.

    Args:
        result: The episode's record.
        agent: Name of the planner, for `load_agent`.
        recording: The episode's recording.
        route: The route driven.
        progress: The ego's progress along the route.
    """
    try:
        planner = load_agent(agent)
    except PlantBenchError:
        return Attention.absent(f"The planner {without_folders(agent)} cannot be loaded.")
    try:
        if not isinstance(planner, Ranker):
            return Attention.absent("The planner does not rank actors.")
        if Input.PRIVILEGED in planner.inputs:
            return Attention.absent("The planner's privileged input is not in the recording.")
        drive = _Drive(planner, planner, recording, route, result.seed, progress)
        if agent_checksum(agent) != result.agent_checksum and not drive.plans_as_recorded():
            return Attention.absent(
                "The planner's code or weights have changed since the recording, and it no longer "
                "makes the recorded plans, so its attention is not known."
            )
        return drive.attention()
    except Exception as error:  # noqa: BLE001  an external planner may raise anything
        return Attention.absent(f"The planner raised {type(error).__name__} when it was called.")


class _Drive:
    """A recorded drive, and its planner to be called again."""

    def __init__(
        self,
        planner: Agent,
        ranker: Ranker,
        recording: Recording,
        route: Route,
        seed: int,
        progress: Progress,
    ) -> None:
        self._planner = PlannerSession(planner, route, seed)
        self._ranker = ranker
        self._recording = recording
        self._progress = progress
        self._actions: list[Action] = recording.actions

    def attention(self) -> Attention:
        """Return the planner's attention at decisions about half a second apart."""
        ticks, starts, actors, shares = self._sample_ticks(), [0], [], []
        self._planner.start()
        for tick in ticks:
            observation = self._observation(tick)
            ids = np.zeros(0, int) if observation.actors is None else observation.actors.ids
            top, share = most_relevant(relevance_of(self._ranker, observation).astype(float), ids)
            actors.append(top)
            shares.append(share)
            starts.append(starts[-1] + len(top))
        empty = np.zeros(0)
        return Attention(
            np.array(ticks, int),
            np.array(starts, int),
            np.concatenate([empty.astype(int), *actors]),
            np.concatenate([empty, *shares]),
        )

    def plans_as_recorded(self) -> bool:
        """Return whether the planner makes the recorded plans at the first `PROBES` samples."""
        self._planner.start()
        compared = 0
        for tick in self._sample_ticks()[: PROBES + 1]:
            scene, recorded = self._recording[tick], self._actions[tick]
            planned = self._planner.decide(scene, self._observation(tick)).action
            if not isinstance(planned, Plan) or not isinstance(recorded, Plan):
                return False
            if tick < SPACING:
                continue  # the planner has no history yet
            if np.abs(planned.waypoints - recorded.waypoints).max() > SAME_PLAN:
                return False
            compared += 1
        return compared > 0

    def _sample_ticks(self) -> list[int]:
        ticks: list[int] = []
        for tick, action in enumerate(self._actions):
            if action is not None and (not ticks or tick - ticks[-1] >= SPACING):
                ticks.append(tick)
        return ticks

    def _observation(self, tick: int) -> Observation:
        along, offset = self._progress.along[tick], self._progress.offsets[tick]
        return self._planner.observe(self._recording[tick], float(along), float(offset), None)


def most_relevant(
    ranks: Float[np.ndarray, " actors"], ids: Int[np.ndarray, " actors"]
) -> tuple[Int[np.ndarray, " shown"], Float[np.ndarray, " shown"]]:
    """Return the ids of the most relevant actors, and their relevance relative to the largest.

    Negative ranks give an order only: if all are negative, only the first actor is returned.

    >>> most_relevant(np.array([0.5, 2.0, -7.0]), np.array([4, 5, 6]))
    (array([5, 4]), array([1.  , 0.25]))
    """
    order = np.lexsort((ids, -ranks))[:MOST_SHOWN]
    if not len(order):
        return ids[order], ranks[order]
    top = float(ranks[order[0]])
    if top <= 0.0:
        return ids[order[:1]], np.ones(1)
    order = order[ranks[order] >= LEAST_SHOWN * top]
    return ids[order], ranks[order] / top
