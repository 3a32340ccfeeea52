"""Brake onset: when the planner or the expert starts to brake before an incident."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from plant_bench.agent import Reason
from plant_bench.reports.why.incidents import Incident
from plant_bench.runner.decisions import Decision
from plant_bench.runner.review.review_frames import Moment
from plant_bench.scoring.termination import BLOCKED_SPEED

BRAKES = -0.5  # m/s2: accelerations at or below this count as braking


@dataclass(frozen=True)
class Braking:
    """Onset and strength of braking, executed or proposed.

    Attributes:
        before: Seconds before the incident at which it begins.
        hardest: The lowest acceleration requested, m/s2.
        times: Number of braking decisions from the onset on.
        of: Number of all decisions from the onset on.
        from_start: Whether it begins with the window, so that the onset may be earlier.
    """

    before: float
    hardest: float
    times: int
    of: int
    from_start: bool


def decisions(answers: Sequence[Decision | None]) -> list[Decision]:
    """Return each decision once; the input repeats a decision until the next one."""
    return list({answer.tick: answer for answer in answers if answer is not None}.values())


def braking_for(
    answers: Sequence[Decision], why: Callable[[Reason], bool], incident: Incident
) -> Braking | None:
    """Return the braking for one reason, from the first such decision on; None if there is none.

    Args:
        answers: The decisions, in order.
        why: Whether a reason is the one looked for.
        incident: The incident; braking at the start of its window may have begun earlier.
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
        from_start=first == 0 and incident.window.first > 0,
    )


def own_braking(
    moments: Sequence[Moment], incident: Incident, *, like_expert: bool
) -> Braking | None:
    """Return the braking that was executed in these moments; None if there is none.

    Braking requests of a stationary ego do not count.

    Args:
        moments: In order of time.
        incident: The incident that they lead to.
        like_expert: Count only braking at least half as hard as the expert's at the same moment; a
            planner may slow down slightly for other reasons.
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
        from_start=first == 0,
    )


def _half_of_experts(moment: Moment) -> float:
    expert = moment.expert
    return BRAKES if expert is None else min(0.5 * expert.control.acceleration, BRAKES)
