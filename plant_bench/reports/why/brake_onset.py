"""When a driver brakes before an incident, and for how long."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from plant_bench.agent import Reason
from plant_bench.reports.why.incidents import Incident
from plant_bench.runner.decisions import Decision
from plant_bench.runner.review.review_frames import Moment
from plant_bench.scoring.termination import BLOCKED_SPEED

BRAKES = -0.5  # m/s2 and below count as braking


@dataclass(frozen=True)
class Braking:
    """When somebody brakes, or would have braked.

    Attributes:
        before: Seconds before the incident at which it begins.
        hardest: The least acceleration asked for, m/s2.
        times: Decisions of it from then on.
        of: All decisions from then on.
        at_once: Whether it brakes from the beginning of the window, so perhaps earlier.
    """

    before: float
    hardest: float
    times: int
    of: int
    at_once: bool


def decisions(answers: Sequence[Decision | None]) -> list[Decision]:
    """Return the answers once each: between decisions the last one is held."""
    return list({answer.tick: answer for answer in answers if answer is not None}.values())


def braking_for(
    answers: Sequence[Decision], why: Callable[[Reason], bool], incident: Incident
) -> Braking | None:
    """Return the braking for one reason, from the first such decision on; None without any.

    Args:
        answers: One for each decision.
        why: Tells whether a reason is the one.
        incident: At its window's beginning a braking may have begun already.
    """
    brakes = [
        answer.reason is not None and answer.control.acceleration <= BRAKES and why(answer.reason)
        for answer in answers
    ]
    if not any(brakes):
        return None
    first = brakes.index(True)
    since = answers[first:]
    hardest = min(
        answer.control.acceleration
        for answer, does in zip(since, brakes[first:], strict=True)
        if does
    )
    start = max(answers[first].tick, incident.window.first)
    return Braking(
        before=incident.before(start),
        hardest=hardest,
        times=sum(brakes[first:]),
        of=len(since),
        at_once=first == 0 and incident.window.first > 0,
    )


def own_braking(
    moments: Sequence[Moment], incident: Incident, *, like_expert: bool
) -> Braking | None:
    """Return the braking that was executed in some moments; None without any.

    Who stands does not brake, whatever is asked for.

    Args:
        moments: In order.
        incident: Which they lead to.
        like_expert: Count only braking that is at least half as hard as the expert's is then; a
            planner may slow down a little for other reasons.
    """
    brakes = [
        moment.control.acceleration <= (_half_of_experts(moment) if like_expert else BRAKES)
        and moment.scene.ego.speed >= BLOCKED_SPEED
        for moment in moments
    ]
    if not any(brakes):
        return None
    first = brakes.index(True)
    return Braking(
        before=incident.before(moments[first].scene.tick),
        hardest=min(moment.control.acceleration for moment in moments[first:]),
        times=sum(brakes[first:]),
        of=len(brakes) - first,
        at_once=first == 0,
    )


def _half_of_experts(moment: Moment) -> float:
    expert = moment.expert
    return BRAKES if expert is None else min(0.5 * expert.control.acceleration, BRAKES)
