"""Whom the planner attended to: asked again, on observations rebuilt from the recording."""

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
from plant_bench.world.route import Route

SPACING = 10  # ticks between two questions: 2 Hz, as the planner's own memory of who was where
MOST_SHOWN = 8  # actors of each question; the rest matters little
LEAST_SHOWN = 0.04  # of the largest relevance
PROBES = 40  # plans compared where the checksum is another
SAME_PLAN = 0.01  # m by which compared plans may differ


@dataclass(frozen=True, eq=False)
class Attention:
    """How relevant whom was to the planner, and when.

    Attributes:
        ticks: When it was asked, rising.
        starts: Where each answer begins in the other two; one more than there are ticks.
        actors: Ids, the most relevant first.
        shares: Relevance over that of the most relevant, 0 to 1.
        note: Why there is none; empty where there is.
    """

    ticks: Int[np.ndarray, " asked"]
    starts: Int[np.ndarray, " bounds"]
    actors: Int[np.ndarray, " shown"]
    shares: Float[np.ndarray, " shown"]
    note: str = ""

    @classmethod
    def absent(cls, note: str) -> "Attention":
        """Return no attention, and why."""
        nothing = np.zeros(0, int)
        return cls(nothing, np.zeros(1, int), nothing, np.zeros(0), note)


def attention_of(
    result: EpisodeResult, agent: str, recording: Recording, route: Route, progress: Progress
) -> Attention:
    """Return the relevance of actors twice a second, or why it cannot be had.

    A planner whose code or weights are not those recorded is asked only if it still plans what was
    recorded: then its attention is what it was.

    Args:
        result: The episode.
        agent: The planner, as `load_agent` reads it.
        recording: Of the episode.
        route: That was driven.
        progress: Of the ego on it.
    """
    try:
        planner = load_agent(agent)
    except PlantBenchError:
        return Attention.absent(f"The planner {without_folders(agent)} cannot be loaded here.")
    try:
        if not isinstance(planner, Ranker):
            return Attention.absent("The planner does not rank others.")
        if Input.PRIVILEGED in planner.inputs:
            return Attention.absent("What the planner was told is not in the recording.")
        drive = _Drive(planner, planner, recording, route, result.seed, progress)
        if agent_checksum(agent) != result.agent_checksum and not drive.plans_as_recorded():
            return Attention.absent(
                "The planner's code or weights are not those of the recording, and it plans "
                "something else now: its attention then is not known."
            )
        return drive.asked()
    except Exception as error:  # noqa: BLE001  whatever an outsider's planner raises
        return Attention.absent(f"The planner raised {type(error).__name__} when it was asked.")


class _Drive:
    """A recorded drive and the planner of it, which is asked again."""

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

    def asked(self) -> Attention:
        """Ask whom it attends to, at decisions about half a second apart."""
        ticks, starts, actors, shares = self._questions(), [0], [], []
        self._planner.start()
        for tick in ticks:
            observation = self._observation(tick)
            ids = np.zeros(0, int) if observation.actors is None else observation.actors.ids
            who, share = most_relevant(relevance_of(self._ranker, observation).astype(float), ids)
            actors.append(who)
            shares.append(share)
            starts.append(starts[-1] + len(who))
        empty = np.zeros(0)
        return Attention(
            np.array(ticks, int),
            np.array(starts, int),
            np.concatenate([empty.astype(int), *actors]),
            np.concatenate([empty, *shares]),
        )

    def plans_as_recorded(self) -> bool:
        """Tell whether it plans what was recorded, at the first decisions asked about."""
        self._planner.start()
        compared = 0
        for tick in self._questions()[: PROBES + 1]:
            scene, recorded = self._recording[tick], self._actions[tick]
            planned = self._planner.decide(scene, self._observation(tick)).action
            if not isinstance(planned, Plan) or not isinstance(recorded, Plan):
                return False
            if tick < SPACING:
                continue  # it had no memory yet
            if np.abs(planned.waypoints - recorded.waypoints).max() > SAME_PLAN:
                return False
            compared += 1
        return compared > 0

    def _questions(self) -> list[int]:
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
    """Return who is most relevant, and the share of each in the largest relevance.

    Ranks below 0 say an order alone, so only the first is shown where all are.

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
