"""Verdicts: the measurements about an incident as sentences."""

from plant_bench.agent import NO_ACTOR, Cause, Reason
from plant_bench.reports.why.brake_onset import Braking
from plant_bench.reports.why.incident_findings import FIRST_FEW, ActorRank, Finding
from plant_bench.reports.why.incidents import actor_name
from plant_bench.reports.why.stationary import Standing
from plant_bench.reports.why.time_use import TimeUse
from plant_bench.runner.review.review_frames import Postmortem
from plant_bench.scoring.infractions import InfractionKind
from plant_bench.world.scene import ActorKind

CAUSES: dict[Cause, str] = {
    Cause.FREE: "free",
    Cause.LIMIT: "limit or curve",
    Cause.LIGHT: "light",
    Cause.LEADER: "leader",
    Cause.CONFLICT: "conflict",
    Cause.JUNCTION: "no space beyond junction",
}


def verdict(finding: Finding, postmortem: Postmortem) -> str:
    """Return the measurements about an incident as a few sentences."""
    kind = finding.incident.infraction.kind
    time = "" if finding.time_use is None else f"{_of_time_use(finding.time_use)} "
    if kind is InfractionKind.TIMEOUT and time:
        return time.strip()
    if not finding.asked:
        why = postmortem.expert_note or "it was not queried"
        return f"{time}What the expert would have done is not known: {why}."
    if kind is InfractionKind.BLOCKED and finding.standing is not None:
        return time + _of_standing(finding.standing, finding.kinds)
    if kind is InfractionKind.OUTSIDE_LANES:
        share = finding.incident.infraction.share or 0.0
        return f"{share:.2%} of the distance was driven outside the lanes or against the direction."
    parts = [_of_light(finding), _of_expert(finding), _of_planner(finding)]
    if finding.actor_rank is not None:
        parts.append(_of_ranking(finding, finding.actor_rank, postmortem.ranked_itself))
    elif finding.incident.infraction.actor is not None and postmortem.planner_note:
        parts.append(f"Its ranking is not known: {postmortem.planner_note}.")
    return " ".join(part for part in parts if part)


def subject(finding: Finding) -> str:
    """Return the name of the object of the infraction: the actor hit, or the light."""
    item = finding.incident.infraction
    if item.kind is InfractionKind.RED_LIGHT:
        return "the light"
    return "" if item.actor is None else actor_name(item.actor, item.actor_kind)


def reason_text(reason: Reason | None, kinds: dict[int, ActorKind]) -> str:
    """Return a reason as text: its cause, and the actor if it has one."""
    if reason is None:
        return "-"
    if reason.actor == NO_ACTOR:
        return CAUSES[reason.cause]
    return f"{CAUSES[reason.cause]}: {actor_name(reason.actor, kinds.get(reason.actor))}"


def stop_reason(reason: Reason, kinds: dict[int, ActorKind]) -> str:
    """Return the reason of a stop as text; a stop for no reason is "nothing"."""
    return "nothing" if reason.cause is Cause.FREE else reason_text(reason, kinds)


def _of_time_use(use: TimeUse) -> str:
    total = sum(use.stationary.values())
    if not use.stops:
        return f"The ego was never stationary in {use.seconds:.0f} s."
    parts = ", ".join(
        f"{seconds:.0f} s for {stop_reason(Reason(cause), {})}"
        for cause, seconds in use.stationary.items()
    )
    how = "as the planner recorded" if use.recorded else "by what was close ahead"
    stop = use.stops[0]
    return (
        f"The ego was stationary for {total:.0f} of {use.seconds:.0f} s ({how}: {parts}). The "
        f"longest stop lasted {stop.seconds:.0f} s, {stop.progress:.0f} m along the route."
    )


def _since(braking: Braking) -> str:
    return f"{braking.before:.1f} s before" + (" or earlier" if braking.from_start else "")


def _of_expert(finding: Finding) -> str:
    what = subject(finding)
    if finding.expert is not None:
        found = finding.expert
        return (
            f"The expert would have braked for {what} from {_since(found)} "
            f"({found.times} of {found.of} decisions, {found.hardest:.1f} m/s2 at the hardest)."
        )
    never = f" for {what}" if what else ""
    first = f"The expert would not have braked{never} in these {finding.incident.seconds:.1f} s"
    if finding.expert_else is None:
        return f"{first}."
    reason, found = finding.expert_else
    return f"{first}, but from {_since(found)} ({reason_text(reason, finding.kinds)})."


def _of_planner(finding: Finding) -> str:
    own, half = finding.planner, finding.expert is not None
    stood = f" The ego was stationary for {finding.stood:.1f} s." if finding.stood else ""
    if own is None:
        how = "never braked half as hard" if half else "did not brake"
        return f"The planner {how}.{stood}"
    how = "at least half as hard " if half else ""
    since = f"from {own.before:.1f} s before ({own.hardest:.1f} m/s2)"
    return f"The planner braked {how}{since}.{stood}"


def _of_ranking(finding: Finding, rank: ActorRank, itself: bool) -> str:
    what, how = subject(finding), "" if itself else " (by masking)"
    few = f"first {FIRST_FEW}"
    if rank.times:
        return f"It had {what} among its {few} in {rank.times} of {rank.of} decisions{how}."
    best = "" if rank.best is None else f" (number {rank.best} at best)"
    return f"It did not rank {what} among its {few}{best}{how}."


def _of_light(finding: Finding) -> str:
    found = finding.red_light
    if found is None:
        return ""
    seconds = finding.incident.seconds
    longer = " or longer" if found.red_for >= seconds else ""
    red = f"The light had been red for {found.red_for:.1f} s{longer} when the rear crossed its line"
    if found.front_before is None:
        return f"{red}; the front had crossed it more than {seconds:.1f} s before."
    state = found.front_state.name.lower()
    return f"{red}; the front had crossed it {found.front_before:.1f} s before, at {state}."


def _of_standing(found: Standing, kinds: dict[int, ActorKind]) -> str:
    ahead = "There is no actor on the route ahead"
    if found.ahead is not None:
        name = actor_name(found.ahead, kinds.get(found.ahead))
        ahead = f"{name[0].upper()}{name[1:]} is {max(found.gap, 0.0):.1f} m ahead on the route"
    parts = [f"The ego was stationary for {found.seconds:.0f} s. {ahead}."]
    if found.starts:
        parts.append(f"The expert would have driven on in {found.starts} of {found.of} decisions.")
    else:
        parts.append(f"The expert would not have driven on in any of {found.of} decisions either.")
    if found.reason is not None:
        reason = reason_text(found.reason, kinds)
        parts.append(f"Its most frequent reason to wait: {reason} ({found.times} decisions).")
    return " ".join(parts)
