"""Why somebody stood until the episode was over."""

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

GOES = 0.2  # m/s2 and above count as a wish to go


@dataclass(frozen=True)
class Standing:
    """Why somebody stood for minutes.

    Attributes:
        seconds: How long it stood.
        wishes: Decisions at which the expert would have gone.
        of: All its decisions in that time.
        reason: The commonest reason of the others; None without any.
        times: How often it was that.
        ahead: The id of who is the nearest on the route ahead at the end; None for nobody.
        gap: Metres to it.
    """

    seconds: float
    wishes: int
    of: int
    reason: Reason | None
    times: int
    ahead: int | None
    gap: float


def standing_of(moments: Sequence[Moment], answers: Sequence[Decision]) -> Standing:
    """Return why the ego stood, given the expert's answers to that."""
    wishes = sum(answer.control.acceleration >= GOES for answer in answers)
    waits = [answer for answer in answers if answer.control.acceleration < GOES]
    counted = Counter(answer.reason for answer in waits if answer.reason is not None)
    reason, times = counted.most_common(1)[0] if counted else (None, 0)
    stands = [moment for moment in moments if moment.scene.ego.speed < BLOCKED_SPEED]
    ahead, gap = _ahead(moments[-1])
    seconds = len(stands) * TICK
    return Standing(seconds, wishes, len(answers), reason, times, ahead, gap)


def _ahead(moment: Moment) -> tuple[int | None, float]:
    """Return who is the nearest on the route ahead, and the metres from bumper to bumper."""
    actors, route = moment.seen.actors, moment.seen.route
    if actors is None or route is None or not len(actors) or len(route.points) < 2:
        return None, np.inf
    held = corridor(route, actors, route.past, moment.scene.ego.speed)
    nearest = np.where(held.inside, held.nearest, np.inf)
    row = int(np.argmin(nearest))
    if not np.isfinite(nearest[row]):
        return None, np.inf
    return int(actors.ids[row]), float(nearest[row]) - 0.5 * EGO_LENGTH
