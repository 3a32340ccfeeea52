"""What can be measured about an incident: when the expert would have braked, and for whom.

Nothing is guessed: each value is counted from the recorded scenes and the answers to them.
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
from plant_bench.runner.decisions import Decision
from plant_bench.runner.review.review_frames import Moment, Postmortem
from plant_bench.scoring.infractions import InfractionKind
from plant_bench.scoring.termination import BLOCKED_SPEED
from plant_bench.world.scene import EGO_EXTENT, TICK, ActorKind, Scene

FIRST_FEW = 3  # who ranks among so many is noticed


@dataclass(frozen=True)
class Noticed:
    """How an actor ranked with the planner.

    Attributes:
        best: Its best place, from 1; None where it was never ranked.
        times: Decisions at which it was among the first few.
        of: All decisions looked at.
    """

    best: int | None
    times: int
    of: int


@dataclass(frozen=True, eq=False)
class Finding:
    """An incident and what was measured about it.

    Attributes:
        incident: The incident.
        moments: Of its window, in order.
        kinds: The kind of each actor that was seen, by id.
        expert: The expert's braking for the one hit, or for the light; None where it never brakes.
        expert_else: The first other thing that it brakes for in the window, and how.
        asked: Whether the expert was asked in the window at all.
        planner: The planner's own braking: from the expert's on, where it is at least half as hard;
            in the whole window where the expert does not brake.
        stood: Seconds of the same time that the ego stood.
        noticed: How the one hit ranked in the same time; None without a ranking.
        red_light: For a red light.
        standing: For a block.
    """

    incident: Incident
    moments: tuple[Moment, ...]
    kinds: dict[int, ActorKind]
    expert: Braking | None
    expert_else: tuple[Reason, Braking] | None
    asked: bool
    planner: Braking | None
    stood: float
    noticed: Noticed | None
    red_light: RedLight | None
    standing: Standing | None


def find(incident: Incident, postmortem: Postmortem) -> Finding:
    """Return what was measured about an incident."""
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
        noticed=None if item.actor is None else _noticed(later, item.actor),
        red_light=red_light_of(incident, moments, postmortem.route) if light else None,
        standing=standing_of(moments, answers) if item.kind is InfractionKind.BLOCKED else None,
    )


def gap_to(scene: Scene, actor: int) -> float | None:
    """Return the metres between the ego's box and an actor's; None where it is out of sight."""
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


def _noticed(moments: Sequence[Moment], actor: int) -> Noticed | None:
    rankings = [
        answer.ranking
        for answer in decisions([moment.planner for moment in moments])
        if answer.ranking is not None
    ]
    if not rankings:
        return None
    places = [ranking.index(actor) + 1 for ranking in rankings if actor in ranking]
    return Noticed(
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
