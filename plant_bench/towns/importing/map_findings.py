"""What was found on a map, and what became of it."""

from collections.abc import Sequence
from dataclasses import asdict, dataclass

REPAIRED, REPORTED = "repaired", "reported"
SHOWN = 5  # examples kept of a finding


@dataclass(frozen=True)
class Finding:
    """One kind of fault on a map.

    Attributes:
        what: The fault.
        outcome: "repaired", or "reported": it is still there.
        count: How often.
        done: What was done about it, or what it means for driving.
        examples: Some of the places: ids of edges, lanes or junctions.
    """

    what: str
    outcome: str
    count: int
    done: str
    examples: tuple[str, ...] = ()

    def to_payload(self) -> dict:
        """Return it as JSON-able values."""
        return asdict(self) | {"examples": list(self.examples)}


def repaired(what: str, done: str, places: Sequence[str]) -> list[Finding]:
    """Return the finding of a repair; none where nothing was to be repaired."""
    return _finding(what, REPAIRED, done, places)


def reported(what: str, done: str, places: Sequence[str]) -> list[Finding]:
    """Return the finding of a fault that stays; none where there is none."""
    return _finding(what, REPORTED, done, places)


def merged(findings: Sequence[Finding]) -> list[Finding]:
    """Return the findings with those of one fault and outcome put together, repairs first."""
    found: dict[tuple[str, str], Finding] = {}
    for item in findings:
        key = item.what, item.outcome
        if key in found:
            before = found[key]
            examples = (*before.examples, *item.examples)[:SHOWN]
            count = before.count + item.count
            found[key] = Finding(item.what, item.outcome, count, item.done, examples)
        else:
            found[key] = item
    return sorted(found.values(), key=lambda item: item.outcome != REPAIRED)


def _finding(what: str, outcome: str, done: str, places: Sequence[str]) -> list[Finding]:
    if not places:
        return []
    return [Finding(what, outcome, len(places), done, tuple(places[:SHOWN]))]
