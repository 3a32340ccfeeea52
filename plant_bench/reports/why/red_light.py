"""Details of a red-light infraction: how long it was red, and when the ego's front crossed.

The rule checks the ego's rear (see `scoring.red_lights`), so the front may have crossed at green.
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
    """State of the light that was run.

    Attributes:
        place: Index of the signal on the route, as in `Scene.lights`.
        entry: Metres along the route to its stop line.
        red_for: Seconds that it had been red; at most the length of the window.
        front_before: Seconds before the incident at which the ego's front crossed the stop line;
            None if that was before the window.
        front_state: State of the light when the front crossed.
    """

    place: int
    entry: float
    red_for: float
    front_before: float | None
    front_state: Light

    def seen_at(self, moment: Moment) -> tuple[Light, float]:
        """Return the light's state, and the metres from the ego's front to its stop line."""
        route = moment.seen.route
        front = 0.5 * EGO_LENGTH + (0.0 if route is None else route.progress)
        return _state(moment, self.place), self.entry - front


def red_light_of(incident: Incident, moments: Sequence[Moment], route: Route) -> RedLight | None:
    """Return details of the light that was run; None if there are no moments."""
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
