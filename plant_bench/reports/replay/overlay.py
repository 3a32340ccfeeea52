"""Overlay data of a replay: plans, reasons, route progress, infractions and hazards."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int

from plant_bench.agent import NO_ACTOR, PLAN_STEPS, Plan
from plant_bench.data.recording import Recording
from plant_bench.reports.replay.replay_frames import FRAME_TICKS
from plant_bench.reports.replay.replay_source import ReplaySource
from plant_bench.runner.review.expert_braking import EXPERT, ExpertView, recorded_expert_view
from plant_bench.scoring.infractions import Infraction
from plant_bench.scoring.results import EpisodeResult, HazardRecord
from plant_bench.world.hazard_table import HAZARDS
from plant_bench.world.route import Passage, Route
from plant_bench.world.route_progress import RouteProgress
from plant_bench.world.scene import EGO_WIDTH, TICK

NO_CAUSE = -1  # no reason is known


@dataclass(frozen=True, eq=False)
class Plans:
    """The planner's waypoints.

    Attributes:
        ticks: Tick at which each plan was made, ascending.
        waypoints: Waypoints in the ego frame of that tick, metres.
    """

    ticks: Int[np.ndarray, " plans"]
    waypoints: Float[np.ndarray, "plans waypoints 2"]


@dataclass(frozen=True, eq=False)
class Reasons:
    """The planner's reasons, one row per frame.

    Attributes:
        causes: `Cause` values, `NO_CAUSE` if not known.
        actors: Ids of actors, `NO_ACTOR` if the cause is not an actor.
    """

    causes: Int[np.ndarray, " frames"]
    actors: Int[np.ndarray, " frames"]


@dataclass(frozen=True, eq=False)
class Progress:
    """The ego's position on its route, one row per tick.

    Attributes:
        along: Arc length along the route, metres.
        offsets: Lateral offset, metres to the left of the route.
    """

    along: Float[np.ndarray, " ticks"]
    offsets: Float[np.ndarray, " ticks"]


def plans_of(recording: Recording) -> Plans:
    """Return all plans; empty for a planner that returns controls."""
    actions = recording.actions
    ticks = [row for row, action in enumerate(actions) if isinstance(action, Plan)]
    waypoints = [action.waypoints for action in actions if isinstance(action, Plan)]
    shape = (-1, PLAN_STEPS, 2)
    return Plans(np.array(ticks, int), np.array(waypoints, float).reshape(shape))


def reasons_of(recording: Recording) -> Reasons:
    """Return the latest reason at each frame."""
    causes = np.full(len(recording), NO_CAUSE)
    actors = np.full(len(recording), NO_ACTOR)
    cause, actor = NO_CAUSE, NO_ACTOR
    for row, reason in enumerate(recording.reasons):
        if reason is not None:
            cause, actor = int(reason.cause), reason.actor
        causes[row], actors[row] = cause, actor
    return Reasons(causes[::FRAME_TICKS], actors[::FRAME_TICKS])


def expert_view_of(source: ReplaySource, recording: Recording, route: Route) -> ExpertView | None:
    """Return the actors that the expert would brake for; None if they are not requested.

    They are in the recording if the expert drove, else the expert is queried.
    """
    if source.result.agent == EXPERT:
        return recorded_expert_view(recording)
    ask = source.ask_expert
    return None if ask is None else ask(recording, source.result, route)


def progress_of(recording: Recording, route: Route) -> Progress:
    """Return the ego's progress along its route, computed as by the referee."""
    place = RouteProgress(route)
    along, offsets = np.empty(len(recording)), np.empty(len(recording))
    for row, (x, y) in enumerate(recording.egos[:, :2].tolist()):
        place.follow(x, y)
        along[row], offsets[row] = place.progress, place.offset
    return Progress(along, offsets)


def limit_steps(route: Route) -> list[list[float]]:
    """Return the changes of the speed limit: metres along the route, new limit in m/s."""
    changes = np.flatnonzero(np.diff(route.speed_limits, prepend=-1.0))
    return [
        [round(float(route.along[row]), 1), round(float(route.speed_limits[row]), 2)]
        for row in changes
    ]


def stop_line(route: Route, passage: Passage) -> list[float]:
    """Return the stop line of a light on the route: x, y, heading, half its width."""
    return [*place_at(route, passage.entry), round(0.75 * EGO_WIDTH, 2)]


def place_at(route: Route, at: float) -> list[float]:
    """Return x, y and heading at an arc length of the route, rounded."""
    x, y = (float(np.interp(at, route.along, column)) for column in route.points.T)
    heading = float(np.interp(at, route.along, route.headings))
    return [round(x, 2), round(y, 2), round(heading, 3)]


def infraction_facts(item: Infraction, recording: Recording) -> dict[str, object]:
    """Return an infraction as JSON values for the page.

    `speed` is the ego's at the recorded tick nearest to its time, m/s.
    """
    tick = round(min(max(item.time / TICK, 0.0), len(recording) - 1.0))
    return {
        "kind": item.kind.value,
        "time": round(item.time, 2),
        "x": round(item.x, 2),
        "y": round(item.y, 2),
        "progress": round(item.progress, 1),
        "actor": item.actor,
        "actorKind": None if item.actor_kind is None else item.actor_kind.name.lower(),
        "cause": item.cause,
        "share": item.share,
        "factor": round(item.factor, 4),
        "speed": round(float(recording.egos[tick, 3]), 2),
    }


def hazard_facts(item: HazardRecord, route: Route) -> dict[str, object]:
    """Return a hazard as JSON values for the page."""
    return {
        "kind": item.kind.value,
        "letter": HAZARDS[item.kind].letter,
        "sentence": HAZARDS[item.kind].sentence,
        "time": round(item.time, 2),
        "place": place_at(route, item.at),
        "phase": item.phase.value,
        "reason": item.reason,
    }


def result_facts(result: EpisodeResult) -> dict[str, object]:
    """Return the episode's result as JSON values for the page."""
    return {
        "status": result.status.value,
        "reason": result.reason,
        "completion": round(result.route_completion, 2),
        "infractionScore": round(result.infraction_score, 4),
        "drivingScore": round(result.driving_score, 2),
        "duration": round(result.duration, 2),
        "length": round(result.route_length, 1),
    }
