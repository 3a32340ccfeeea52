"""Where others will be: along their true lanes (privileged), or straight on."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float, UInt8

from plant_bench.agent import PATH_POSES, PATH_STEP, Observation
from plant_bench.errors import AgentError
from plant_bench.world.scene import ActorKind, Actors

STEP = 0.25  # s between two instants of a forecast
STEPS = 28  # instants, the first now: 6.75 s, in which a large junction is crossed from standing
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
    speed = actors.speeds[keep].astype(float)[:, None]
    pull = facts.accelerations[keep][:, None]
    top = np.maximum(facts.desired_speeds[keep][:, None], speed)
    room = np.maximum(facts.stop_distances[keep][:, None], 0.0)
    # Who cannot stop any more, or speeds up just before the place, goes on: SUMO's word is a wish.
    goes_on = (speed**2 > 2.0 * FIRM_BRAKING * room) | ((pull > PULLING_AWAY) & (room < NEAR_STOP))
    # People stop within a step, and walk no faster than they do.
    drives = (speed > STANDING) & (actors.kinds[keep] != ActorKind.PEDESTRIAN)[:, None]
    room = np.where(goes_on & drives, np.inf, room)
    # Who stands goes on standing until it moves: two who wait for each other would wait for ever.
    gentle = np.where(drives, GENTLE_ACCELERATION, 0.0)
    pulls = np.stack((np.maximum(pull, gentle), np.minimum(pull, 0.0)))
    early, late = np.minimum(_travel(speed, pulls, top), room)
    poses = _gather(facts.paths[keep], 0.5 * (early + late))
    extents = actors.extents[keep].astype(float)
    lengths = extents[:, 0, None] + early - late
    standing = speed[:, 0] < STANDING
    return Forecast(poses, lengths, extents[:, 1], standing, margins(actors.kinds[keep], standing))


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


def _travel(
    speed: Float[np.ndarray, "actors 1"],
    pulls: Float[np.ndarray, "pulls actors 1"],
    top: Float[np.ndarray, "actors 1"],
) -> Float[np.ndarray, "pulls actors steps"]:
    """Return how far constant accelerations get between standing and a top speed."""
    speeds = np.minimum(np.maximum(speed + pulls * TIMES, 0.0), top)
    travel = np.zeros_like(speeds)
    np.cumsum(0.5 * STEP * (speeds[..., 1:] + speeds[..., :-1]), axis=2, out=travel[..., 1:])
    return travel


def _gather(
    paths: Float[np.ndarray, "actors samples 3"], at: Float[np.ndarray, "actors steps"]
) -> Float[np.ndarray, "actors steps 3"]:
    """Return the poses at distances along each actor's path."""
    place = np.minimum(at / PATH_STEP, PATH_POSES - 1.001)
    index = place.astype(np.intp)
    share = place - index
    flat = paths.reshape(-1, 3)
    index += PATH_POSES * np.arange(len(paths))[:, None]
    poses = flat.take(index, axis=0)
    onward = flat.take(index + 1, axis=0)
    poses[..., :2] += share[..., None] * (onward[..., :2] - poses[..., :2])
    return poses
