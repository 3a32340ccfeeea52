"""A red light that was run: since when it was red, and when the ego's front was at its line.

The rule counts the rear (see `scoring.red_lights`), so a front that crossed at green may be the
beginning of it.
"""

from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass

from plant_bench.reports.why.incidents import Incident
from plant_bench.runner.review.review_frames import Moment
from plant_bench.world.route import Route
from plant_bench.world.scene import EGO_LENGTH, Light


@dataclass(frozen=True)
class RedLight:
    """What is known of the light.

    Attributes:
        place: Of the signal on the route, as in `Scene.lights`.
        entry: Metres along the route to its line.
        red_for: Seconds that it has been red; the whole window where it was red all the time.
        front_before: Seconds before at which the front crossed its line; None if it was earlier.
        front_state: What the light showed then.
    """

    place: int
    entry: float
    red_for: float
    front_before: float | None
    front_state: Light

    def seen_at(self, moment: Moment) -> tuple[Light, float]:
        """Return what the light shows, and the metres from the ego's front to its line."""
        route = moment.seen.route
        front = 0.5 * EGO_LENGTH + (0.0 if route is None else route.progress)
        return _state(moment, self.place), self.entry - front


def red_light_of(incident: Incident, moments: Sequence[Moment], route: Route) -> RedLight | None:
    """Return what is known of the light that was run; None where nothing was looked at."""
    place = bisect_right(route.signal_entries, incident.infraction.progress) - 1
    if place < 0 or not moments:
        return None
    entry = route.signal_entries[place]
    bare = RedLight(place, entry, 0.0, None, Light.UNKNOWN)
    since = incident.tick
    for moment in reversed(moments):
        if _state(moment, place) is not Light.RED:
            break
        since = moment.scene.tick
    crossed = next((item for item in moments if bare.seen_at(item)[1] < 0.0), moments[-1])
    within = crossed is not moments[0]
    return RedLight(
        place=place,
        entry=entry,
        red_for=incident.before(since),
        front_before=incident.before(crossed.scene.tick) if within else None,
        front_state=_state(crossed, place) if within else Light.UNKNOWN,
    )


def _state(moment: Moment, place: int) -> Light:
    return Light(int(moment.scene.lights[place]))
