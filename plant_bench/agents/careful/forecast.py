"""Forecasts of other actors: along their true lanes (privileged), or at constant velocity."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float, UInt8

from plant_bench.agent import PATH_STEP, Observation
from plant_bench.errors import AgentError
from plant_bench.features.rollouts import STEP, STEPS
from plant_bench.jit import (
    BOOL_1D,
    F32_1D,
    F32_2D,
    F64,
    F64_1D,
    F64_3D,
    INT64,
    INT64_1D,
    compiled,
)
from plant_bench.world.scene import ActorKind, Actors

TIMES = np.arange(STEPS) * STEP
STANDING = 0.1  # m/s below which an actor is stationary
FIRM_BRAKING = 4.5  # m/s2, SUMO's default
PULLING_AWAY = 0.5  # m/s2
NEAR_STOP = 10.0  # m
GENTLE_ACCELERATION = 1.0  # m/s2 that a moving vehicle is assumed to use at least, if free to go
MARGIN_ALONG = 1.0  # m in front of and behind other actors
WAITING_MARGIN = 0.25  # m around stationary pedestrians: at a kerb they face the road


class Forecast(NamedTuple):
    """Predicted boxes of other actors at the instants `TIMES`.

    Attributes:
        poses: Poses of the box centres.
        lengths: Box lengths, metres; the actor's length plus the uncertainty of its position.
        widths: Box widths, metres.
        standing: Which actors are stationary now.
        margins: Distance to keep in front of and behind each actor, metres.
    """

    poses: Float[np.ndarray, "actors steps 3"]
    lengths: Float[np.ndarray, "actors steps"]
    widths: Float[np.ndarray, " actors"]
    standing: Bool[np.ndarray, " actors"]
    margins: Float[np.ndarray, " actors"]

    def only(self, keep: np.ndarray) -> "Forecast":
        """Return the forecast of the actors that a mask selects."""
        return Forecast(*(values[keep] for values in self))


def along_true_lanes(observation: Observation, keep: np.ndarray) -> Forecast:
    """Forecast from simulator-only facts (PlanT, section 4: the expert).

    Each actor follows its true lanes. Its box covers the range of distances between keeping its
    speed and accelerating or braking.

    Args:
        observation: The observation.
        keep: Rows of the actors to forecast.

    Raises:
        AgentError: The observation has no privileged facts.
    """
    actors, facts = observation.actors, observation.privileged
    if actors is None or facts is None:
        message = "The privileged forecast needs the inputs 'objects' and 'privileged'."
        raise AgentError(message)
    poses, lengths = _along(
        keep,
        facts.paths,
        facts.accelerations,
        facts.desired_speeds,
        facts.stop_distances,
        actors.speeds,
        actors.extents,
        actors.kinds == ActorKind.PEDESTRIAN,
        PATH_STEP,
        STEP,
        STEPS,
    )
    widths = actors.extents[keep, 1].astype(float)
    standing = actors.speeds[keep].astype(float) < STANDING
    return Forecast(poses, lengths, widths, standing, margins(actors.kinds[keep], standing))


@compiled(
    INT64_1D,
    F64_3D,
    F64_1D,
    F64_1D,
    F64_1D,
    F32_1D,
    F32_2D,
    BOOL_1D,
    F64,
    F64,
    INT64,
)
def _along(
    keep, paths, accelerations, desired, stops, speeds, extents, walking, spacing, interval, count
):
    """Return the poses of some actors on their paths, and the lengths of their boxes."""
    poses, lengths = np.empty((len(keep), count, 3)), np.empty((len(keep), count))
    for row in range(len(keep)):
        actor = keep[row]
        speed, length = float(speeds[actor]), float(extents[actor, 0])
        acceleration = accelerations[actor]
        top, stop = max(desired[actor], speed), max(stops[actor], 0.0)
        # A vehicle that can no longer stop, or accelerates just before its stop, is predicted to
        # continue, whatever SUMO announces. Pedestrians stop at once and do not walk faster.
        continues = speed * speed > 2.0 * FIRM_BRAKING * stop
        continues = continues or (acceleration > PULLING_AWAY and stop < NEAR_STOP)
        # Stationary actors are predicted to stay; otherwise two yielding drivers deadlock.
        drives = speed > STANDING and not walking[actor]
        if continues and drives:
            stop = np.inf
        most = max(acceleration, GENTLE_ACCELERATION if drives else 0.0)
        least = min(acceleration, 0.0)
        fast = slow = min(max(speed, 0.0), top)
        early = late = 0.0
        for step in range(count):
            if step:
                faster = min(max(speed + most * (step * interval), 0.0), top)
                slower = min(max(speed + least * (step * interval), 0.0), top)
                early += 0.5 * interval * (faster + fast)
                late += 0.5 * interval * (slower + slow)
                fast, slow = faster, slower
            farthest, nearest = min(early, stop), min(late, stop)
            lengths[row, step] = length + farthest - nearest
            place = 0.5 * (farthest + nearest) / spacing
            place = min(place, paths.shape[1] - 1.001)
            index = int(place)
            for axis in range(2):
                begin = paths[actor, index, axis]
                gained = (place - index) * (paths[actor, index + 1, axis] - begin)
                poses[row, step, axis] = begin + gained
            poses[row, step, 2] = paths[actor, index, 2]
    return poses, lengths


def straight_on(observation: Observation, keep: np.ndarray) -> Forecast:
    """Forecast with constant speed and heading (PlanT, section 4: the rule-based planner).

    Args:
        observation: The observation.
        keep: Rows of the actors to forecast.

    Raises:
        AgentError: The observation has no actors.
    """
    actors = actors_in(observation)
    poses = actors.poses[keep].astype(float)
    extents = actors.extents[keep].astype(float)
    speeds = actors.speeds[keep].astype(float)
    travel = speeds[:, None] * TIMES
    x = poses[:, 0, None] + travel * np.cos(poses[:, 2, None])
    y = poses[:, 1, None] + travel * np.sin(poses[:, 2, None])
    yaw = np.broadcast_to(poses[:, 2, None], x.shape)
    lengths = np.broadcast_to(extents[:, 0, None], x.shape)
    standing = speeds < STANDING
    places = np.stack((x, y, yaw), axis=2)
    return Forecast(places, lengths, extents[:, 1], standing, margins(actors.kinds[keep], standing))


def actors_in(observation: Observation) -> Actors:
    """Return the actors of an observation.

    Raises:
        AgentError: It has none.
    """
    if observation.actors is None:
        message = "The forecast needs the input 'objects'."
        raise AgentError(message)
    return observation.actors


def margins(
    kinds: UInt8[np.ndarray, " actors"], standing: Bool[np.ndarray, " actors"]
) -> Float[np.ndarray, " actors"]:
    """Return the distance to keep in front of and behind each actor, metres."""
    waits = standing & (kinds == ActorKind.PEDESTRIAN)
    return np.where(waits, WAITING_MARGIN, MARGIN_ALONG)
