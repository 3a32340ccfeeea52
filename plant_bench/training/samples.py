"""From a recording to what a learner needs: scenes at 2 Hz, and what became of them.

Scenes become inputs by the very functions that a planner uses while it drives.
"""

from dataclasses import dataclass, fields
from typing import Literal

import numpy as np
from jaxtyping import Bool, Float, Int, UInt8

from plant_bench.agent import PLAN_INTERVAL, PLAN_STEPS, Control, Observation
from plant_bench.agents.careful.driver import RESTING_INTERVAL
from plant_bench.agents.careful.forecast import STEP
from plant_bench.agents.careful.rollouts import ego_poses, rollout
from plant_bench.data.recorder import Action
from plant_bench.data.recording import Recording
from plant_bench.errors import InputError
from plant_bench.features.inputs import SceneInput, scene_input
from plant_bench.features.limits import allowed_speed
from plant_bench.features.tokens import ATTRIBUTES, NOWHERE, Tokens, TokenSpec, actor_attributes
from plant_bench.features.tracks import Rates, rates_between, rows_of
from plant_bench.geometry.pose import to_frame
from plant_bench.sensing.inputs import PERCEIVED
from plant_bench.sensing.observe import Sensors
from plant_bench.world.route import PROTOCOL, Route
from plant_bench.world.route_progress import RouteProgress
from plant_bench.world.scene import TICK, Actors, Scene

SAMPLE_TICKS = round(PLAN_INTERVAL / TICK)  # 10: data at 2 Hz (PlanT, section 4)
HORIZON = PLAN_STEPS * SAMPLE_TICKS  # ticks
SKIPPED_FIRST = 5  # samples of each episode (PlanT, dataset.py)
SKIPPED_LAST = 2  # as above; the last four have no whole future anyway
ROLLED = slice(
    round(PLAN_INTERVAL / STEP),
    round(PLAN_STEPS * PLAN_INTERVAL / STEP) + 1,
    round(PLAN_INTERVAL / STEP),
)  # the instants of a rollout at which waypoints lie

STANDING, STAYING = 0.1, 0.2  # m/s, and metres in two seconds
_OF_TOKENS = frozenset({"attributes", "kinds", "futures"})

TargetKind = Literal["future", "answer"]


@dataclass(frozen=True, eq=False, slots=True)
class Samples:
    """Scenes and their futures; the tokens of all samples lie one after the other.

    Everything is in the ego frame of the sample's own instant.

    Attributes:
        starts: Where the tokens of each sample start, and at the end their number.
        attributes: Of the tokens (`plant_bench.features.tokens`).
        kinds: `TokenKind` values.
        futures: Attributes of the same actors 0.5 s later, NaN for those gone and for the route.
        red: 1 where the next light is red or yellow.
        target: A route point ahead, metres.
        speed: The ego's, m/s.
        limit: m/s.
        waypoints: Where the ego's centre should be 0.5, 1.0, 1.5 and 2.0 s later, metres.
    """

    starts: Int[np.ndarray, " ends"]
    attributes: Float[np.ndarray, "tokens attributes"]
    kinds: UInt8[np.ndarray, " tokens"]
    futures: Float[np.ndarray, "tokens 6"]
    red: Float[np.ndarray, " batch"]
    target: Float[np.ndarray, "batch 2"]
    speed: Float[np.ndarray, " batch"]
    limit: Float[np.ndarray, " batch"]
    waypoints: Float[np.ndarray, "batch waypoints 2"]

    def __len__(self) -> int:
        return len(self.red)

    @property
    def counts(self) -> Int[np.ndarray, " batch"]:
        """Number of tokens of each sample."""
        return np.diff(self.starts)

    @property
    def resting(self) -> Bool[np.ndarray, " batch"]:
        """Where the ego stands and should go on standing."""
        return (self.speed < STANDING) & (np.abs(self.waypoints[:, -1, 0]) < STAYING)

    def picked(self, chosen: Int[np.ndarray, " chosen"]) -> "Samples":
        """Return some samples, in the given order."""
        counts = self.counts[chosen]
        ends = _ends(counts)
        within = np.arange(ends[-1]) - np.repeat(ends[:-1], counts)
        tokens = np.repeat(self.starts[:-1][chosen], counts) + within
        columns = {
            item.name: getattr(self, item.name)[tokens if item.name in _OF_TOKENS else chosen]
            for item in fields(self)
            if item.name != "starts"
        }
        return Samples(starts=ends, **columns)

    def only(self, part: slice) -> "Samples":
        """Return the samples of a slice, which must have a start, a stop and no step."""
        first, last = (int(self.starts[at]) for at in (part.start, part.stop))
        columns = {
            item.name: getattr(self, item.name)[
                slice(first, last) if item.name in _OF_TOKENS else part
            ]
            for item in fields(self)
            if item.name != "starts"
        }
        return Samples(starts=_ends(self.counts[part]), **columns)


def samples_of(
    recording: Recording, route: Route, spec: TokenSpec, targets: TargetKind = "future"
) -> Samples:
    """Return the samples of an episode.

    Ego poses are wanted at every tick, actors at every tenth only.

    Args:
        recording: Of the episode.
        route: That it was driven on.
        spec: What becomes a token.
        targets: What the waypoints are. "future": where the ego went, as PlanT; where something
            disturbed the driver within that future it is not the driver's own, and the sample is
            left out. "answer": where the acceleration that the driver answered with leads if it is
            held, along the route; the driver need not have been the one who drove.

    Raises:
        InputError: The recording is of another route or protocol, or a tick or answer is missing.
    """
    known = recording.metadata.get("route_checksum")
    if known != route.checksum:
        message = (
            f"A recording of route {recording.metadata.get('route')} ({str(known)[:12]}) does not "
            f"fit route {route.id} ({route.checksum[:12]}): keep the routes it was driven on."
        )
        raise InputError(message)
    protocol = str(recording.metadata.get("protocol"))
    if not protocol.startswith(PROTOCOL):
        message = (
            f"A recording of the protocol '{protocol}', of another world than '{PROTOCOL}'. "
            "Collect anew."
        )
        raise InputError(message)
    places = recording.egos[:, :2]
    place = RouteProgress(route)
    sensors = Sensors(route, int(recording.metadata.get("seed", 0)), PERCEIVED)
    rows: list[_Row] = []
    actions = recording.actions if targets == "answer" else []
    followed = 0
    for chosen in _kept_rows(len(recording)):
        for x, y in places[followed : chosen + 1].tolist():
            place.follow(x, y)
        followed = chosen + 1
        if targets == "future" and recording.disturbed[chosen : chosen + HORIZON].any():
            continue
        scene = recording[chosen]
        if scene.tick != chosen:
            message = f"Row {chosen} of a recording holds tick {scene.tick}: all ticks are wanted."
            raise InputError(message)
        observation = sensors.observe(scene, place.progress, place.offset)
        rates = _rates(recording, chosen) if spec.tracks else None
        given = scene_input(observation, spec, rates)
        later = recording[chosen + SAMPLE_TICKS].actors
        if targets == "answer":
            future = _answered(actions, chosen, observation)
        else:
            future = places[_future_rows(chosen)]
        waypoints = to_frame(future, *scene.ego.pose)
        rows.append(_Row(given, _futures(scene, given.tokens, later), waypoints))
    return _stacked(rows, spec)


def joined(parts: list[Samples]) -> Samples:
    """Return the samples of several episodes as one."""
    columns = {
        field.name: np.concatenate([getattr(part, field.name) for part in parts])
        for field in fields(Samples)
        if field.name != "starts"
    }
    counts = np.concatenate([part.counts for part in parts])
    return Samples(starts=_ends(counts), **columns)


@dataclass(frozen=True, eq=False, slots=True)
class _Row:
    given: SceneInput
    futures: Float[np.ndarray, "tokens 6"]
    waypoints: Float[np.ndarray, "waypoints 2"]


def _kept_rows(length: int) -> range:
    """Return the rows that become samples: those with a whole future, the ends left out."""
    first = SKIPPED_FIRST * SAMPLE_TICKS
    last_sample = (length - 1) // SAMPLE_TICKS - SKIPPED_LAST
    last = min(last_sample * SAMPLE_TICKS, length - 1 - HORIZON)
    return range(first, last + 1, SAMPLE_TICKS)


def _future_rows(row: int) -> slice:
    return slice(row + SAMPLE_TICKS, row + HORIZON + 1, SAMPLE_TICKS)


def _answered(
    actions: list[Action], row: int, observation: Observation
) -> Float[np.ndarray, "waypoints 2"]:
    """Return where the last answer leads if its acceleration is held, in the world frame."""
    answers = (actions[at] for at in range(row, max(row - RESTING_INTERVAL, -1), -1))
    answer = next((action for action in answers if action is not None), None)
    if not isinstance(answer, Control) or observation.route is None:
        message = (
            f"Row {row} of a recording holds no acceleration: only where an expert answered can "
            "its answers be learned. --targets future learns where the ego went."
        )
        raise InputError(message)
    top = allowed_speed(observation.route)
    travel = rollout(observation.ego.speed, np.array([answer.acceleration]), top)
    return ego_poses(observation.route, travel)[0, ROLLED, :2]


def _rates(recording: Recording, row: int) -> Rates:
    """Return how the actors of a row have changed since the sample before."""
    before, now = recording[row - SAMPLE_TICKS].actors, recording[row].actors
    return rates_between(before, now, SAMPLE_TICKS * TICK)


def _futures(scene: Scene, tokens: Tokens, later: Actors) -> Float[np.ndarray, "tokens 6"]:
    """Return the later attributes of the tokens' actors in the frame of the ego now."""
    futures = np.full((len(tokens), ATTRIBUTES), np.nan)
    mine = (tokens.places != NOWHERE).nonzero()[0]
    ids = scene.actors.ids[tokens.places[mine]]
    there, found = rows_of(ids, later.ids)
    futures[mine[there]] = actor_attributes(scene.ego, later, found)
    return futures


def _ends(counts: np.ndarray) -> Int[np.ndarray, " ends"]:
    return np.concatenate(([0], np.cumsum(counts, dtype=np.int64)))


def _stacked(rows: list[_Row], spec: TokenSpec) -> Samples:
    count = len(rows)
    tokens = [row.given.tokens for row in rows]
    none = np.empty((0, ATTRIBUTES), np.float32)
    nothing = np.empty((0, spec.attributes), np.float32)
    given = [row.given for row in rows]
    return Samples(
        starts=_ends(np.array([len(item) for item in tokens], np.int64)),
        attributes=np.concatenate([nothing, *(item.attributes for item in tokens)]),
        kinds=np.concatenate([np.empty(0, np.uint8), *(item.kinds for item in tokens)]),
        futures=np.concatenate([none, *(row.futures for row in rows)]).astype(np.float32),
        red=np.array([item.red for item in given], np.float32),
        target=np.array([item.target for item in given], np.float32).reshape(count, 2),
        speed=np.array([item.speed for item in given], np.float32),
        limit=np.array([item.limit for item in given], np.float32),
        waypoints=np.array([row.waypoints for row in rows], np.float32).reshape(
            count, PLAN_STEPS, 2
        ),
    )
