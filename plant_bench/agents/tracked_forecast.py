"""Where others will be if they go on speeding up, slowing down and turning as they do.

Nothing here is privileged: it is what a tracker tells (`features.tracks`). A driver that pulls away
from a stop line, or has begun to turn, is seen to do so about half a second later.
"""

import numpy as np
from jaxtyping import Float

from plant_bench.agent import Observation
from plant_bench.agents.forecast import (
    STANDING,
    STEP,
    TIMES,
    Forecast,
    actors_in,
    margins,
)
from plant_bench.features.meetings import FASTEST, FIRMEST, HARDEST, WIDEST
from plant_bench.features.tracks import Rates, Tracks, no_rates, rows_of
from plant_bench.world.scene import ActorKind, Actors

HELD = 2.0  # s for which an acceleration is believed to last
TURNING = 1.0  # m/s from which a change of heading is a curve
SHARPEST = 0.25  # 1/m, the curvature of the tightest turn believed


class TrackedForecast:
    """Remembers the last half second of all actors, and forecasts from it; mutable.

    Args:
        tracks: What remembers, where a planner has such tracks already.
    """

    def __init__(self, tracks: Tracks | None = None) -> None:
        self._tracks = Tracks() if tracks is None else tracks
        self._ids = np.empty(0, int)
        self._rates: Rates | None = None

    def forget(self) -> None:
        """Start a new episode."""
        self._tracks.forget()
        self._rates = None

    def watch(self, observation: Observation) -> None:
        """Remember who is where; to be called with every observation.

        Raises:
            AgentError: The observation holds no actors.
        """
        actors = actors_in(observation)
        self._rates, self._ids = self._tracks.rates(observation.time, actors), actors.ids

    def __call__(self, observation: Observation, keep: np.ndarray) -> Forecast:
        """Forecast some actors; how far they get lies between keeping and changing their speeds.

        Args:
            observation: The one watched last, or some of its actors.
            keep: The places of the actors wanted.

        Raises:
            AgentError: The observation holds no actors.
        """
        actors = actors_in(observation)
        chosen = actors.only(keep)
        rates = self._rates_of(chosen)
        speeds = chosen.speeds.astype(float)
        early, late = _travel(speeds, rates.accelerations.astype(float))
        poses = _curves(chosen.poses.astype(float), speeds, rates.turns, 0.5 * (early + late))
        extents = chosen.extents.astype(float)
        standing = speeds < STANDING
        lengths = extents[:, 0, None] + early - late
        return Forecast(poses, lengths, extents[:, 1], standing, margins(chosen.kinds, standing))

    def _rates_of(self, actors: Actors) -> Rates:
        """Return how actors change; people are taken to walk straight on."""
        rates = no_rates(actors)
        if self._rates is None:
            return rates
        known, rows = rows_of(actors.ids, self._ids)
        rates.accelerations[known] = self._rates.accelerations[rows]
        rates.turns[known] = self._rates.turns[rows]
        walking = actors.kinds == ActorKind.PEDESTRIAN
        rates.accelerations[walking] = rates.turns[walking] = 0.0
        return rates


def _travel(
    speeds: Float[np.ndarray, " actors"], pulls: Float[np.ndarray, " actors"]
) -> tuple[Float[np.ndarray, "actors steps"], Float[np.ndarray, "actors steps"]]:
    """Return how far actors get at most and at least."""
    pulls = pulls.clip(HARDEST, FIRMEST)
    tops = np.maximum(speeds, FASTEST)[:, None]
    paces = (speeds[:, None] + pulls[:, None] * np.minimum(TIMES, HELD)).clip(0.0, tops)
    changing = np.zeros_like(paces)
    np.cumsum(0.5 * STEP * (paces[:, 1:] + paces[:, :-1]), axis=1, out=changing[:, 1:])
    keeping = speeds[:, None] * TIMES
    return np.maximum(changing, keeping), np.minimum(changing, keeping)


def _curves(
    poses: Float[np.ndarray, "actors 3"],
    speeds: Float[np.ndarray, " actors"],
    turns: Float[np.ndarray, " actors"],
    travel: Float[np.ndarray, "actors steps"],
) -> Float[np.ndarray, "actors steps 3"]:
    """Return the poses after some distances along the circles on which actors turn."""
    bends = np.where(speeds > TURNING, turns / np.maximum(speeds, TURNING), 0.0)
    turned = (bends.clip(-SHARPEST, SHARPEST)[:, None] * travel).clip(-WIDEST, WIDEST)
    yaws = poses[:, 2, None] + turned
    cos, sin = np.cos(yaws), np.sin(yaws)
    ahead = np.diff(travel, axis=1)
    found = np.empty((*travel.shape, 3))
    found[:, 0, :2] = 0.0
    np.cumsum(0.5 * (cos[:, 1:] + cos[:, :-1]) * ahead, axis=1, out=found[:, 1:, 0])
    np.cumsum(0.5 * (sin[:, 1:] + sin[:, :-1]) * ahead, axis=1, out=found[:, 1:, 1])
    found[..., :2] += poses[:, None, :2]
    found[..., 2] = yaws
    return found
