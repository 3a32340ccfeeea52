"""Forecasts other actors with their present accelerations and turn rates.

Nothing here is privileged: the rates are those of a tracker (`features.motion`). It notices that a
vehicle has pulled away or begun to turn about half a second later.
"""

import math

import numpy as np

from plant_bench.agent import Observation
from plant_bench.agents.careful.forecast import STANDING, Forecast, actors_in, margins
from plant_bench.features.motion import MotionTracker, Rates
from plant_bench.features.predicted_conflicts import (
    MAX_ACCELERATION,
    MAX_SPEED,
    MAX_TURN,
    MIN_ACCELERATION,
)
from plant_bench.features.rollouts import STEP, STEPS
from plant_bench.jit import (
    BOOL_1D,
    F32,
    F32_1D,
    F32_2D,
    F64,
    F64_1D,
    INT64,
    INT64_1D,
    NEW_F64_1D,
    NEW_F64_2D,
    compiled,
)
from plant_bench.world.scene import ActorKind

HELD = 2.0  # s for which an acceleration is assumed to last
TURNING = 1.0  # m/s above which a turn rate is taken as a curve
MAX_CURVATURE = 0.25  # 1/m


class MotionForecast:
    """Tracks the actors and forecasts them from their rates; mutable.

    Args:
        tracker: A motion tracker to share; a new one by default.
    """

    def __init__(self, tracker: MotionTracker | None = None) -> None:
        self._tracker = MotionTracker() if tracker is None else tracker
        self._ids = np.empty(0, int)
        self._rates: Rates | None = None

    def reset(self) -> None:
        """Start a new episode."""
        self._tracker.reset()
        self._rates = None

    def update(self, observation: Observation) -> None:
        """Update the tracker; must be called with every observation.

        Raises:
            AgentError: The observation has no actors.
        """
        actors = actors_in(observation)
        self._rates, self._ids = self._tracker.rates(observation.time, actors), actors.ids

    def __call__(self, observation: Observation, keep: np.ndarray) -> Forecast:
        """Forecast actors; boxes cover the range between keeping and changing their speeds.

        Args:
            observation: The observation of the last `update`, perhaps with fewer actors.
            keep: Rows of the actors to forecast.

        Raises:
            AgentError: The observation has no actors.
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
            np.array((MIN_ACCELERATION, MAX_ACCELERATION, MAX_SPEED, MAX_TURN, STEP)),
            STEPS,
        )
        standing = speeds.astype(float) < STANDING
        widths = actors.extents[keep, 1].astype(float)
        return Forecast(poses, lengths, widths, standing, margins(kinds, standing))


@compiled(NEW_F64_2D, NEW_F64_1D, F32_1D, F32, F32, F64, F64, F64_1D)
def _roll_out(poses, lengths, pose, start_speed, length, acceleration, turn, numbers):
    """Fill in the poses and box lengths of one actor, which drives on a circle."""
    min_acceleration, max_acceleration, max_speed, max_turn, interval = numbers
    speed, x, y, yaw = (
        np.float64(start_speed),
        np.float64(pose[0]),
        np.float64(pose[1]),
        np.float64(pose[2]),
    )
    acceleration = min(max(acceleration, min_acceleration), max_acceleration)
    top = max(speed, max_speed)
    curvature = (
        min(max(turn / max(speed, TURNING), -MAX_CURVATURE), MAX_CURVATURE)
        if speed > TURNING
        else 0.0
    )
    last_speed = changed = moved_x = moved_y = last_cos = last_sin = last_travel = 0.0
    for step in range(len(lengths)):
        time = step * interval
        now = min(max(speed + acceleration * min(time, HELD), 0.0), top)
        if step:
            changed += 0.5 * interval * (now + last_speed)
        early, late = max(changed, speed * time), min(changed, speed * time)
        travel = 0.5 * (early + late)
        turned = yaw + min(max(curvature * travel, -max_turn), max_turn)
        cos, sin = math.cos(turned), math.sin(turned)
        if step:
            moved_x += 0.5 * (cos + last_cos) * (travel - last_travel)
            moved_y += 0.5 * (sin + last_sin) * (travel - last_travel)
        poses[step, 0], poses[step, 1], poses[step, 2] = moved_x + x, moved_y + y, turned
        lengths[step] = length + early - late
        last_speed, last_cos, last_sin, last_travel = now, cos, sin, travel


@compiled(
    INT64_1D,
    F32_2D,
    F32_1D,
    F32_2D,
    BOOL_1D,
    INT64_1D,
    F32_1D,
    F32_1D,
    F64_1D,
    INT64,
)
def _forecast(ids, poses, speeds, extents, walking, known, accelerations, turns, numbers, steps):
    """Return the poses and lengths of a forecast; pedestrians are assumed to walk straight on."""
    found, lengths = np.empty((len(ids), steps, 3)), np.empty((len(ids), steps))
    for row in range(len(ids)):
        acceleration = turn = np.float64(0.0)
        for place in range(len(known)):
            if known[place] == ids[row] and not walking[row]:
                acceleration, turn = np.float64(accelerations[place]), np.float64(turns[place])
                break
        _roll_out(
            found[row],
            lengths[row],
            poses[row],
            speeds[row],
            extents[row, 0],
            acceleration,
            turn,
            numbers,
        )
    return found, lengths
