"""Measurements about an incident: when the expert would have braked, for what, and what was ranked.

All values come from the recorded scenes and from the decisions of planner and expert in them.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import shapely

from plant_bench.agent import NO_ACTOR, Cause, Reason
from plant_bench.geometry.box import corners
from plant_bench.reports.why.brake_onset import BRAKES, Braking, braking_for, decisions, own_braking
from plant_bench.reports.why.incidents import Incident
from plant_bench.reports.why.red_light import RedLight, red_light_of
from plant_bench.reports.why.stationary import Standing, standing_of
from plant_bench.reports.why.time_use import TimeUse
from plant_bench.runner.decisions import Decision
from plant_bench.runner.review.review_frames import Moment, Postmortem
from plant_bench.scoring.infractions import InfractionKind
from plant_bench.scoring.termination import BLOCKED_SPEED
from plant_bench.world.scene import EGO_EXTENT, TICK, ActorKind, Scene

OUT_OF_TIME = (InfractionKind.BLOCKED, InfractionKind.TIMEOUT)
FIRST_FEW = 3  # top ranks that count as noticed


@dataclass(frozen=True)
class ActorRank:
    """How the planner ranked an actor.

    Attributes:
        best: Its best rank, from 1; None if it was never ranked.
        times: Number of decisions with a rank up to `FIRST_FEW`.
        of: Number of all decisions evaluated.
    """

    best: int | None
    times: int
    of: int


@dataclass(frozen=True, eq=False)
class Finding:
    """An incident and what was measured about it.

    Attributes:
        incident: The incident.
        moments: The moments of its window, in order.
        kinds: Kind of each actor in the window, by id.
        expert: The expert's braking for the actor hit, or for the light; None if it never brakes.
        expert_else: The first other reason that the expert brakes for, and this braking.
        asked: Whether there is any decision of the expert in the window.
        planner: The planner's braking. If the expert brakes: from the expert's onset on, at least
            half as hard; else any braking in the whole window.
        stood: Seconds of the same period in which the ego was stationary.
        actor_rank: Rank of the actor hit in the same period; None without a ranking.
        red_light: State of the light; None if the incident is not a red light.
        standing: Why the ego was stationary; None if the incident is not a block.
        time_use: Where the time of the episode went, for a block or a time-out; else None.
    """

    incident: Incident
    moments: tuple[Moment, ...]
    kinds: dict[int, ActorKind]
    expert: Braking | None
    expert_else: tuple[Reason, Braking] | None
    asked: bool
    planner: Braking | None
    stood: float
    actor_rank: ActorRank | None
    red_light: RedLight | None
    standing: Standing | None
    time_use: TimeUse | None = None


def find(incident: Incident, postmortem: Postmortem, time_use: TimeUse | None = None) -> Finding:
    """Return the measurements about an incident.

    Args:
        incident: The incident.
        postmortem: The review of its episode.
        time_use: Where the time of the episode went; ignored unless the time ran out.
    """
    moments = postmortem.between(incident.window)
    item = incident.infraction
    light = item.kind is InfractionKind.RED_LIGHT
    answers = decisions([moment.expert for moment in moments])

    def for_it(reason: Reason) -> bool:
        if light:
            return reason.cause is Cause.LIGHT
        return item.actor is not None and reason.actor == item.actor

    expert = braking_for(answers, for_it, incident)
    looked = incident.seconds if expert is None else expert.before
    later = [moment for moment in moments if incident.before(moment.scene.tick) <= looked]
    return Finding(
        incident=incident,
        moments=tuple(moments),
        kinds=_kinds(moments),
        expert=expert,
        expert_else=_something_else(answers, for_it, incident),
        asked=bool(answers),
        planner=own_braking(later, incident, like_expert=expert is not None),
        stood=TICK * sum(moment.scene.ego.speed < BLOCKED_SPEED for moment in later),
        actor_rank=None if item.actor is None else _actor_rank(later, item.actor),
        red_light=red_light_of(incident, moments, postmortem.route) if light else None,
        standing=standing_of(moments, answers) if item.kind is InfractionKind.BLOCKED else None,
        time_use=time_use if item.kind in OUT_OF_TIME else None,
    )


def gap_to(scene: Scene, actor: int) -> float | None:
    """Return the metres between the ego's box and an actor's; None if it is not in the scene."""
    row = np.flatnonzero(scene.actors.ids == actor)
    if not row.size:
        return None
    one = scene.actors.only(row[:1])
    ego = corners(np.array([scene.ego.pose]), np.array([EGO_EXTENT]))
    other = corners(one.poses.astype(float), one.extents.astype(float))
    return float(np.sum(shapely.distance(shapely.polygons(ego), shapely.polygons(other))))


def _something_else(
    answers: Sequence[Decision], for_it: Callable[[Reason], bool], incident: Incident
) -> tuple[Reason, Braking] | None:
    for answer in answers:
        reason = answer.reason
        if reason is None or for_it(reason) or answer.control.acceleration > BRAKES:
            continue
        braking = braking_for(answers, lambda other, this=reason: other == this, incident)
        if braking is not None:
            return reason, braking
    return None


def _actor_rank(moments: Sequence[Moment], actor: int) -> ActorRank | None:
    rankings = [
        answer.ranking
        for answer in decisions([moment.planner for moment in moments])
        if answer.ranking is not None
    ]
    if not rankings:
        return None
    places = [ranking.index(actor) + 1 for ranking in rankings if actor in ranking]
    return ActorRank(
        best=min(places, default=None),
        times=sum(place <= FIRST_FEW for place in places),
        of=len(rankings),
    )


def _kinds(moments: Sequence[Moment]) -> dict[int, ActorKind]:
    return {
        int(actor): ActorKind(int(kind))
        for actors in (moment.scene.actors for moment in moments)
        for actor, kind in zip(actors.ids, actors.kinds, strict=True)
    } | {NO_ACTOR: ActorKind.STATIC}
