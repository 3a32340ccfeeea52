"""Findings of a map import: problems that were repaired, or only reported."""

from collections.abc import Sequence
from dataclasses import asdict, dataclass

REPAIRED, REPORTED = "repaired", "reported"
SHOWN = 5  # examples kept per finding


@dataclass(frozen=True)
class Finding:
    """One kind of problem of a map.

    Attributes:
        what: The problem.
        outcome: "repaired", or "reported" if it is still there.
        count: Number of occurrences.
        done: How it was repaired, or what it means for driving.
        examples: Some occurrences: ids of edges, lanes or junctions.
        lane_metres: Lanes that the repair removed, metres.
    """

    what: str
    outcome: str
    count: int
    done: str
    examples: tuple[str, ...] = ()
    lane_metres: float = 0.0

    def to_payload(self) -> dict:
        """Return the finding as JSON-able values."""
        return asdict(self) | {"examples": list(self.examples)}


def repaired(
    what: str, done: str, places: Sequence[str], lane_metres: float = 0.0
) -> list[Finding]:
    """Return the finding of a repair; empty without `places`."""
    return _finding(what, REPAIRED, done, places, lane_metres)


def reported(what: str, done: str, places: Sequence[str]) -> list[Finding]:
    """Return the finding of a problem that remains; empty without `places`."""
    return _finding(what, REPORTED, done, places)


def merged(findings: Sequence[Finding]) -> list[Finding]:
    """Return the findings with equal problem and outcome merged, repairs first."""
    found: dict[tuple[str, str], Finding] = {}
    for item in findings:
        key = item.what, item.outcome
        if key in found:
            before = found[key]
            examples = (*before.examples, *item.examples)[:SHOWN]
            count = before.count + item.count
            metres = before.lane_metres + item.lane_metres
            found[key] = Finding(item.what, item.outcome, count, item.done, examples, metres)
        else:
            found[key] = item
    return sorted(found.values(), key=lambda item: item.outcome != REPAIRED)


def _finding(
    what: str, outcome: str, done: str, places: Sequence[str], lane_metres: float = 0.0
) -> list[Finding]:
    if not places:
        return []
    return [Finding(what, outcome, len(places), done, tuple(places[:SHOWN]), lane_metres)]
