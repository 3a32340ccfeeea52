"""Where others will be if they go on speeding up, slowing down and turning as they do.

Nothing here is privileged: it is what a tracker tells (`features.tracks`). A driver that pulls away
from a stop line, or has begun to turn, is seen to do so about half a second later.
"""

import math

import numpy as np

from plant_bench.agent import Observation
from plant_bench.agents.careful.forecast import STANDING, Forecast, actors_in, margins
from plant_bench.features.motion import MotionTracker, Rates
from plant_bench.features.predicted_conflicts import FASTEST, FIRMEST, HARDEST, WIDEST
from plant_bench.features.rollouts import STEP, STEPS
from plant_bench.jit import (
    FLAGS,
    NEW_REALS,
    NEW_REALS_2D,
    REAL,
    REALS,
    SINGLE,
    SINGLES,
    SINGLES_2D,
    WHOLE,
    WHOLES,
    compiled,
)
from plant_bench.world.scene import ActorKind

HELD = 2.0  # s for which an acceleration is believed to last
TURNING = 1.0  # m/s from which a change of heading is a curve
SHARPEST = 0.25  # 1/m, the curvature of the tightest turn believed


class MotionForecast:
    """Remembers the last half second of all actors, and forecasts from it; mutable.

    Args:
        tracks: What remembers, where a planner has such tracks already.
    """

    def __init__(self, tracks: MotionTracker | None = None) -> None:
        self._tracks = MotionTracker() if tracks is None else tracks
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
        rates = self._rates
        if rates is None:
            nothing = np.empty(0, np.float32)
            rates = Rates(nothing, nothing)
        kinds, speeds = actors.kinds[keep], actors.speeds[keep]
        poses, lengths = _forecast(
            actors.ids[keep],
            actors.poses[keep],
            speeds,
            actors.extents[keep],
            kinds == ActorKind.PEDESTRIAN,
            self._ids[: len(rates.turns)],
            rates.accelerations,
            rates.turns,
            np.array((HARDEST, FIRMEST, FASTEST, WIDEST, STEP)),
            STEPS,
        )
        standing = speeds.astype(float) < STANDING
        widths = actors.extents[keep, 1].astype(float)
        return Forecast(poses, lengths, widths, standing, margins(kinds, standing))


@compiled(NEW_REALS_2D, NEW_REALS, SINGLES, SINGLE, SINGLE, REAL, REAL, REALS)
def _go(poses, lengths, pose, pace, length, pull, turn, numbers):
    """Fill in where one actor is and how long its box is, on the circle on which it turns."""
    hardest, firmest, fastest, widest, interval = numbers
    speed, x, y, yaw = (
        np.float64(pace),
        np.float64(pose[0]),
        np.float64(pose[1]),
        np.float64(pose[2]),
    )
    pull, top = min(max(pull, hardest), firmest), max(speed, fastest)
    bend = min(max(turn / max(speed, TURNING), -SHARPEST), SHARPEST) if speed > TURNING else 0.0
    last_pace = changed = gone_x = gone_y = last_cos = last_sin = last_travel = 0.0
    for step in range(len(lengths)):
        time = step * interval
        now = min(max(speed + pull * min(time, HELD), 0.0), top)
        if step:
            changed += 0.5 * interval * (now + last_pace)
        early, late = max(changed, speed * time), min(changed, speed * time)
        travel = 0.5 * (early + late)
        turned = yaw + min(max(bend * travel, -widest), widest)
        cos, sin = math.cos(turned), math.sin(turned)
        if step:
            gone_x += 0.5 * (cos + last_cos) * (travel - last_travel)
            gone_y += 0.5 * (sin + last_sin) * (travel - last_travel)
        poses[step, 0], poses[step, 1], poses[step, 2] = gone_x + x, gone_y + y, turned
        lengths[step] = length + early - late
        last_pace, last_cos, last_sin, last_travel = now, cos, sin, travel


@compiled(WHOLES, SINGLES_2D, SINGLES, SINGLES_2D, FLAGS, WHOLES, SINGLES, SINGLES, REALS, WHOLE)
def _forecast(ids, poses, speeds, extents, walking, known, accelerations, turns, numbers, steps):
    """Return the poses and lengths of a forecast; people are taken to walk straight on."""
    found, lengths = np.empty((len(ids), steps, 3)), np.empty((len(ids), steps))
    for row in range(len(ids)):
        pull = turn = np.float64(0.0)
        for place in range(len(known)):
            if known[place] == ids[row] and not walking[row]:
                pull, turn = np.float64(accelerations[place]), np.float64(turns[place])
                break
        _go(found[row], lengths[row], poses[row], speeds[row], extents[row, 0], pull, turn, numbers)
    return found, lengths
