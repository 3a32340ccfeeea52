"""Interpolates an episode at a point in time, for drawing images and videos."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int

from plant_bench.agent import NO_ACTOR, Cause
from plant_bench.reports.replay.overlay import NO_CAUSE
from plant_bench.reports.replay.replay_episode import EpisodeReplay
from plant_bench.reports.replay.replay_frames import FRAME
from plant_bench.runner.review.expert_braking import EXPERT
from plant_bench.world.scene import TICK

FRESH = 1.3  # s for which a plan or an attention sample is shown


@dataclass(frozen=True, eq=False)
class Snapshot:
    """State of an episode at one point in time.

    Attributes:
        time: Seconds.
        ego: x, y, yaw, speed, acceleration, steering.
        ids: Ids of the actors in sight.
        kinds: `ActorKind` values of these actors.
        poses: Poses of these actors.
        extents: Length and width of these actors, metres.
        lights: `Light` values of the route's signals.
        plan: Waypoints in the world frame, metres; empty if there is none.
        shares: Relevance of these actors, 0 to 1.
        brakes_for: Id of the actor that the planner brakes for, or `NO_ACTOR`; of the expert's
            own drives it is in `expert_brakes_for` only.
        expert_brakes_for: Id of the actor that the expert would brake for, or `NO_ACTOR`.
        reason: Why the planner does not drive faster; empty if not known.
        limit: Speed limit, m/s.
    """

    time: float
    ego: Float[np.ndarray, " 6"]
    ids: Int[np.ndarray, " actors"]
    kinds: np.ndarray
    poses: Float[np.ndarray, "actors 3"]
    extents: Float[np.ndarray, "actors 2"]
    lights: np.ndarray
    plan: Float[np.ndarray, "waypoints 2"]
    shares: Float[np.ndarray, " actors"]
    brakes_for: int
    expert_brakes_for: int
    reason: str
    limit: float


def snapshot_at(episode: EpisodeReplay, seconds: float) -> Snapshot:
    """Return the state at a time, clipped to the duration of the episode."""
    frames = episode.frames
    frame = float(np.clip(seconds / FRAME, 0, len(frames) - 1))
    row = int(frame + 1e-6)
    tracks = frames.tracks
    counts = np.diff(tracks.starts)
    here = np.flatnonzero((tracks.first <= frame) & (frame < tracks.first + counts))
    at = tracks.starts[here] + np.minimum(frame - tracks.first[here], counts[here] - 1)
    low = np.floor(at).astype(int)
    high = np.minimum(low + 1, tracks.starts[here + 1] - 1)
    part = (at - low)[:, None]
    cause, actor = int(episode.reasons.causes[row]), int(episode.reasons.actors[row])
    ids = tracks.ids[here]
    return Snapshot(
        time=frame * FRAME,
        ego=_ego(episode, frame),
        ids=ids,
        kinds=tracks.kinds[here],
        poses=tracks.poses[low] * (1.0 - part) + tracks.poses[high] * part,
        extents=tracks.extents[here],
        lights=frames.lights[row],
        plan=_plan(episode, seconds),
        shares=_shares(episode, seconds, ids),
        brakes_for=NO_ACTOR if cause == NO_CAUSE or _expert_drove(episode) else actor,
        expert_brakes_for=_expert(episode, seconds),
        reason="" if cause == NO_CAUSE else Cause(cause).name.lower(),
        limit=_limit(episode, row),
    )


def _ego(episode: EpisodeReplay, frame: float) -> Float[np.ndarray, " 6"]:
    egos = episode.frames.egos
    low = int(frame)
    high = min(low + 1, len(egos) - 1)
    return egos[low] + (egos[high] - egos[low]) * (frame - low)


def _limit(episode: EpisodeReplay, row: int) -> float:
    route = episode.route
    place = int(np.searchsorted(route.along, episode.progress[row], side="right")) - 1
    return float(route.speed_limits[max(place, 0)])


def _latest(ticks: Int[np.ndarray, " asked"], seconds: float) -> int:
    """Return the row of the newest tick, -1 if it is older than `FRESH`."""
    row = int(np.searchsorted(ticks, seconds / TICK + 1e-6, side="right")) - 1
    return row if row >= 0 and seconds - ticks[row] * TICK <= FRESH else -1


def _expert_drove(episode: EpisodeReplay) -> bool:
    return episode.source.result.agent == EXPERT


def _expert(episode: EpisodeReplay, seconds: float) -> int:
    view = episode.expert
    row = -1 if view is None else _latest(view.ticks, seconds)
    return NO_ACTOR if view is None or row < 0 else int(view.actors[row])


def _plan(episode: EpisodeReplay, seconds: float) -> Float[np.ndarray, "waypoints 2"]:
    plans = episode.plans
    row = _latest(plans.ticks, seconds)
    if row < 0:
        return np.zeros((0, 2))
    x, y, yaw = _ego(episode, min(plans.ticks[row] * TICK / FRAME, len(episode.frames) - 1.0))[:3]
    turn = np.array([[np.cos(yaw), np.sin(yaw)], [-np.sin(yaw), np.cos(yaw)]])
    return plans.waypoints[row] @ turn + (x, y)


def _shares(
    episode: EpisodeReplay, seconds: float, ids: Int[np.ndarray, " actors"]
) -> Float[np.ndarray, " actors"]:
    attention = episode.attention
    shares = np.zeros(len(ids))
    row = _latest(attention.ticks, seconds)
    if row >= 0:
        part = slice(attention.starts[row], attention.starts[row + 1])
        for actor, share in zip(attention.actors[part], attention.shares[part], strict=True):
            shares[ids == actor] = share
    return shares
