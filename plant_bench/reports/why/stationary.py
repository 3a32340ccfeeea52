"""Why the ego was stationary until the episode ended as blocked."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from plant_bench.agent import Reason
from plant_bench.agents.careful.leader import corridor
from plant_bench.runner.decisions import Decision
from plant_bench.runner.review.review_frames import Moment
from plant_bench.scoring.termination import BLOCKED_SPEED
from plant_bench.world.scene import EGO_LENGTH, TICK

STARTS = 0.2  # m/s2: accelerations at or above this count as starting to drive


@dataclass(frozen=True)
class Standing:
    """Why the ego was stationary.

    Attributes:
        seconds: Seconds that it was stationary.
        starts: Number of decisions in which the expert would have driven on.
        of: Number of all its decisions in that time.
        reason: The most frequent reason of its other decisions; None if there is none.
        times: Number of decisions with this reason.
        ahead: Id of the nearest actor on the route ahead at the end; None if there is none.
        gap: Metres to it.
    """

    seconds: float
    starts: int
    of: int
    reason: Reason | None
    times: int
    ahead: int | None
    gap: float


def standing_of(moments: Sequence[Moment], answers: Sequence[Decision]) -> Standing:
    """Return why the ego was stationary, from the decisions of the expert."""
    starts = sum(answer.control.acceleration >= STARTS for answer in answers)
    waits = [answer for answer in answers if answer.control.acceleration < STARTS]
    counted = Counter(answer.reason for answer in waits if answer.reason is not None)
    reason, times = counted.most_common(1)[0] if counted else (None, 0)
    stationary = [moment for moment in moments if moment.scene.ego.speed < BLOCKED_SPEED]
    ahead, gap = _ahead(moments[-1])
    seconds = len(stationary) * TICK
    return Standing(seconds, starts, len(answers), reason, times, ahead, gap)


def _ahead(moment: Moment) -> tuple[int | None, float]:
    """Return the id of the nearest actor on the route ahead, and the bumper-to-bumper gap in m."""
    actors, route = moment.seen.actors, moment.seen.route
    if actors is None or route is None or not len(actors) or len(route.points) < 2:
        return None, np.inf
    held = corridor(route, actors, route.past, moment.scene.ego.speed)
    nearest = np.where(held.inside, held.nearest, np.inf)
    row = int(np.argmin(nearest))
    if not np.isfinite(nearest[row]):
        return None, np.inf
    return int(actors.ids[row]), float(nearest[row]) - 0.5 * EGO_LENGTH
