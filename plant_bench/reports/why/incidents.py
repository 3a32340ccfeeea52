"""The incidents of an episode: each infraction with the time window to evaluate, and its name."""

from dataclasses import dataclass

from plant_bench.agent import MOST_INTERVAL
from plant_bench.errors import InputError
from plant_bench.runner.review.review_frames import Window
from plant_bench.scoring.infractions import Infraction, InfractionKind
from plant_bench.scoring.results import EpisodeResult
from plant_bench.scoring.termination import BLOCKED_TIME
from plant_bench.world.actor_ids import is_parked
from plant_bench.world.scene import TICK, ActorKind

KIND_NAMES: dict[InfractionKind, str] = {
    InfractionKind.COLLISION_PEDESTRIAN: "collision with a pedestrian",
    InfractionKind.COLLISION_VEHICLE: "collision with a vehicle",
    InfractionKind.COLLISION_STATIC: "collision with an object",
    InfractionKind.RED_LIGHT: "red light",
    InfractionKind.OUTSIDE_LANES: "outside the lanes",
    InfractionKind.ROUTE_DEVIATION: "off the route",
    InfractionKind.BLOCKED: "blocked",
    InfractionKind.TIMEOUT: "out of time",
}


@dataclass(frozen=True)
class Incident:
    """One infraction and the time window before it.

    Attributes:
        number: Its place in the episode's list of infractions, from 1.
        infraction: The infraction.
        tick: The tick at which it happened.
        window: The ticks to evaluate.
    """

    number: int
    infraction: Infraction
    tick: int
    window: Window

    def before(self, tick: int) -> float:
        """Return the seconds from a tick to the incident."""
        return (self.tick - tick) * TICK

    @property
    def seconds(self) -> float:
        """Length of the window in seconds."""
        return self.before(self.window.first)


def check_recorded(result: EpisodeResult, ticks: int) -> None:
    """Check that the times of an episode's infractions lie within its recording.

    Args:
        result: The episode's record.
        ticks: Number of ticks in its recording.

    Raises:
        InputError: An infraction's time is outside the recording.
    """
    for item in result.infractions:
        if not 0.0 <= item.time <= ticks * TICK:
            message = (
                f"The record of {result.route} has an infraction at {item.time:g} s, but its "
                f"recording lasts {ticks * TICK:g} s. Score the route again."
            )
            raise InputError(message)


def incidents(result: EpisodeResult, before: float) -> list[Incident]:
    """Return an episode's incidents, in order of time.

    For a block, the window also covers the whole time that the ego was stationary.

    Args:
        result: The episode's record.
        before: Seconds to evaluate before each incident.
    """
    found = []
    for number, item in enumerate(result.infractions, start=1):
        tick = round(item.time / TICK)
        near = tick - round(before / TICK)
        stood = round(BLOCKED_TIME / TICK) if item.kind is InfractionKind.BLOCKED else 0
        window = Window(
            first=max(near - stood, 0), last=tick, ranked_from=max(near - MOST_INTERVAL, 0)
        )
        found.append(Incident(number, item, tick, window))
    return found


def actor_name(actor: int, kind: ActorKind | None) -> str:
    """Return the display name of an actor: its kind and its id.

    >>> actor_name(17, ActorKind.CAR), actor_name(1000002, ActorKind.VAN)
    ('car 17', 'parked van 1000002')
    """
    parked = "parked " if is_parked(actor) else ""
    return f"{parked}{'actor' if kind is None else kind.name.lower()} {actor}"
