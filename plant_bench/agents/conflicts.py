"""Which accelerations keep clear of the forecast boxes of others."""

import math
from typing import NamedTuple

import numpy as np
from jaxtyping import Float, Int

from plant_bench.agents.forecast import TIMES, Forecast
from plant_bench.geometry.box import overlap
from plant_bench.world.scene import EGO_EXTENT, EGO_LENGTH, EGO_WIDTH

MARGIN_ASIDE = 0.25  # m on each side of others
TOUCHING = 0.3  # share of the margins within which others are as good as touched


class Conflicts(NamedTuple):
    """The first overlap that each choice runs into.

    Attributes:
        times: Seconds; infinite for none.
        actors: Whose box it is, a row of the forecast; -1 for none.
    """

    times: Float[np.ndarray, " choices"]
    actors: Int[np.ndarray, " choices"]


def first_conflicts(
    poses: Float[np.ndarray, "choices steps 3"], forecast: Forecast, boldness: float
) -> Conflicts:
    """Return for each choice the first overlap within the margins; of several, the nearest box.

    Args:
        poses: The ego's poses, one row a choice.
        forecast: The others.
        boldness: 0 keeps the full margins, 1 none towards who stands.
    """
    return _near(poses, forecast).first(boldness, 1.0)


def clearest(
    poses: Float[np.ndarray, "choices steps 3"], forecast: Forecast, boldness: float
) -> int:
    """Return the gentlest braking that keeps the margins, else going on if that keeps them.

    Where nothing keeps them, it is the hardest braking that does not touch, else what touches last.

    Args:
        poses: The ego's poses for going on, the first row, and for ever harder braking.
        forecast: The others.
        boldness: As of `first_conflicts`.
    """
    near = _near(poses, forecast)
    clear = np.flatnonzero(near.first(boldness, 1.0).times == math.inf)
    if clear.size:
        return int(clear[min(clear.size - 1, int(clear[0] == 0))])
    times = near.first(boldness, TOUCHING).times
    return len(times) - 1 - int(np.argmax(times[::-1]))


class _Near(NamedTuple):
    """The pairs of an ego's pose and a forecast box that are near each other."""

    choices: int
    forecast: Forecast
    choice: Int[np.ndarray, " pairs"]
    actor: Int[np.ndarray, " pairs"]
    step: Int[np.ndarray, " pairs"]
    square: Float[np.ndarray, " pairs"]
    poses: Float[np.ndarray, "pairs 3"]

    def first(self, boldness: float, caution: float) -> Conflicts:
        """Return the first overlaps with a share of the margins kept."""
        times, actors = np.full(self.choices, np.inf), np.full(self.choices, -1)
        if not self.choice.size:
            return Conflicts(times, actors)
        forecast, actor, step = self.forecast, self.actor, self.step
        share = caution * np.where(forecast.standing, 1.0 - boldness, 1.0)[actor]
        lengths = forecast.lengths[actor, step] + 2 * forecast.margins[actor] * share
        extents = np.stack((lengths, forecast.widths[actor] + 2 * MARGIN_ASIDE * share), axis=1)
        ego_extents = np.broadcast_to(np.array(EGO_EXTENT), extents.shape)
        hits = overlap(self.poses, ego_extents, forecast.poses[actor, step], extents)
        if not hits.any():
            return Conflicts(times, actors)
        choice, actor, step = self.choice[hits], actor[hits], step[hits]
        order = np.lexsort((self.square[hits], step, choice))
        found, first = np.unique(choice[order], return_index=True)
        times[found] = TIMES[step[order][first]]
        actors[found] = actor[order][first]
        return Conflicts(times, actors)


def _near(poses: Float[np.ndarray, "choices steps 3"], forecast: Forecast) -> _Near:
    lengths = forecast.lengths + 2 * forecast.margins[:, None]
    widths = forecast.widths + 2 * MARGIN_ASIDE
    dx = poses[:, None, :, 0] - forecast.poses[None, :, :, 0]
    dy = poses[:, None, :, 1] - forecast.poses[None, :, :, 1]
    reach = 0.5 * (EGO_LENGTH + EGO_WIDTH + lengths + widths[:, None])
    square = dx * dx + dy * dy
    choice, actor, step = (square < reach * reach).nonzero()
    return _Near(
        len(poses), forecast, choice, actor, step, square[choice, actor, step], poses[choice, step]
    )
