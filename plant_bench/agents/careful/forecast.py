"""Where others will be: along their true lanes (privileged), or straight on."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float, UInt8

from plant_bench.agent import PATH_STEP, Observation
from plant_bench.errors import AgentError
from plant_bench.features.rollouts import STEP, STEPS
from plant_bench.jit import (
    FLAGS,
    REAL,
    REALS,
    REALS_3D,
    SINGLES,
    SINGLES_2D,
    WHOLE,
    WHOLES,
    compiled,
)
from plant_bench.world.scene import ActorKind, Actors

TIMES = np.arange(STEPS) * STEP
STANDING = 0.1  # m/s
FIRM_BRAKING = 4.5  # m/s2, SUMO's default
PULLING_AWAY = 0.5  # m/s2
NEAR_STOP = 10.0  # m
GENTLE_ACCELERATION = 1.0  # m/s2 that a moving driver who is free to go may use
MARGIN_ALONG = 1.0  # m in front of and behind others
WAITING_MARGIN = 0.25  # m around people who stand: at a kerb they face the road


class Forecast(NamedTuple):
    """Boxes of others over the instants `TIMES`.

    Attributes:
        poses: Box centres.
        lengths: Metres; longer than the vehicle by what its place is uncertain.
        widths: Metres.
        standing: Which of them stand now.
        margins: Metres to be kept in front of and behind them.
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
    """Forecast by what only the simulator knows (PlanT, section 4: the expert).

    Each actor follows its true lanes; how far it gets lies between going on as now and speeding up
    or slowing down, and its box covers that range.

    Raises:
        AgentError: The observation holds no privileged facts.
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


@compiled(WHOLES, REALS_3D, REALS, REALS, REALS, SINGLES, SINGLES_2D, FLAGS, REAL, REAL, WHOLE)
def _along(keep, paths, pulls, desired, stops, speeds, extents, walking, spacing, pause, count):
    """Return where some actors are on their paths, and how long their boxes become."""
    poses, lengths = np.empty((len(keep), count, 3)), np.empty((len(keep), count))
    for row in range(len(keep)):
        actor = keep[row]
        speed, pull, length = float(speeds[actor]), pulls[actor], float(extents[actor, 0])
        top, room = max(desired[actor], speed), max(stops[actor], 0.0)
        # Who cannot stop any more, or speeds up just before the place, goes on: SUMO's word is a
        # wish. People stop within a step, and walk no faster than they do.
        goes_on = speed * speed > 2.0 * FIRM_BRAKING * room
        goes_on = goes_on or (pull > PULLING_AWAY and room < NEAR_STOP)
        # Who stands goes on standing until it moves: two who wait for each other would wait for
        # ever.
        drives = speed > STANDING and not walking[actor]
        if goes_on and drives:
            room = np.inf
        most, least = max(pull, GENTLE_ACCELERATION if drives else 0.0), min(pull, 0.0)
        fast = slow = min(max(speed, 0.0), top)
        early = late = 0.0
        for step in range(count):
            if step:
                faster = min(max(speed + most * (step * pause), 0.0), top)
                slower = min(max(speed + least * (step * pause), 0.0), top)
                early += 0.5 * pause * (faster + fast)
                late += 0.5 * pause * (slower + slow)
                fast, slow = faster, slower
            farthest, nearest = min(early, room), min(late, room)
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

    Raises:
        AgentError: The observation holds no actors.
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
        AgentError: It holds none.
    """
    if observation.actors is None:
        message = "The forecast needs the input 'objects'."
        raise AgentError(message)
    return observation.actors


def margins(
    kinds: UInt8[np.ndarray, " actors"], standing: Bool[np.ndarray, " actors"]
) -> Float[np.ndarray, " actors"]:
    """Return the metres to be kept in front of and behind others."""
    waits = standing & (kinds == ActorKind.PEDESTRIAN)
    return np.where(waits, WAITING_MARGIN, MARGIN_ALONG)
