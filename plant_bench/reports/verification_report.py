"""What `plant-bench verify` found: for people, and for machines."""

import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass

import typer

from plant_bench.reports.tables import print_rows
from plant_bench.runner.review.differences import Checked
from plant_bench.runner.review.submission import Submission
from plant_bench.runner.review.submission_checks import Finding
from plant_bench.text_escaping import one_line

VERIFICATION_FORMAT = 1
_SHOWN = 20  # findings in a table; a file for machines has all of them
_LONGEST = 60  # characters of a value


@dataclass(frozen=True)
class Verification:
    """The result of a verification.

    Attributes:
        submission: The run.
        checked: Episodes that were simulated again.
        way: "agent" or "controls": what drove them.
        seed: Of the sample.
    """

    submission: Submission
    checked: Sequence[Checked]
    way: str
    seed: int

    @property
    def different(self) -> int:
        """How many episodes are not as the run says."""
        return sum(item.difference is not None for item in self.checked)

    @property
    def confirmed(self) -> bool:
        """Whether nothing differs."""
        return not self.different and not self.submission.findings

    def to_json(self) -> str:
        """Return all of it as JSON."""
        told = self.submission.provenance
        payload = {
            "format": VERIFICATION_FORMAT,
            "confirmed": self.confirmed,
            "agent": told.agent,
            "agent_checksum": told.agent_checksum,
            "suite": told.suite,
            "protocol": told.protocol,
            "base_seed": told.seed,
            "density": told.density,
            "records": len(self.submission.records),
            "way": self.way,
            "sample_seed": self.seed,
            "episodes": [
                asdict(item) | {"equal": item.difference is None} for item in self.checked
            ],
            "findings": [asdict(item) for item in self.submission.findings],
            "notes": list(self.submission.notes),
        }
        return json.dumps(payload, indent=1) + "\n"


def print_submission(submission: Submission) -> None:
    """Print what the run says it is, and what is wrong with it before anything is simulated."""
    told = submission.provenance
    hazards = "" if told.hazards else ", no hazards"
    typer.echo(
        f"{_clean(told.agent)} on {_clean(told.suite)}: {len(submission.records)} records, "
        f"protocol {_clean(told.protocol)}, base seed {told.seed}, density "
        f"{_clean(told.density)}{hazards}"
    )
    for note in submission.notes:
        typer.echo(_clean(note, len(note)))
    findings = submission.findings
    rows = [_row(item) for item in findings[:_SHOWN]]
    print_rows("Not as it should be", ["file", "what", "found", "wanted"], rows)
    if len(findings) > _SHOWN:
        typer.echo(f"and {len(findings) - _SHOWN} more (--json FILE has all of them)")


def print_verification(found: Verification) -> None:
    """Print the episodes that were simulated again, and the verdict."""
    rows = []
    for item in found.checked:
        cells = ("", "", "")
        if (other := item.difference) is not None:
            cells = (_clean(other.field), _clean(other.told), _clean(other.again))
        rows.append(
            [_clean(item.name), _clean(item.town), "different" if other else "equal", *cells]
        )
    how = "the agent" if found.way == "agent" else "the recorded controls"
    title = f"Simulated again by {how} (sample seed {found.seed})"
    heads = ["episode", "town", "record", "first difference", "told", "again"]
    print_rows(title, heads, rows)
    typer.echo(_verdict(found))


def _verdict(found: Verification) -> str:
    checked = f"{len(found.checked)} of {len(found.submission.records)} episodes simulated again"
    if found.confirmed:
        return (
            f"CONFIRMED: {checked}, all equal byte for byte; no episode is missing or doubled, and "
            "the summary follows from the records."
        )
    count = len(found.submission.findings)
    return f"NOT CONFIRMED: {checked}, {found.different} different; {count} other findings."


def _row(item: Finding) -> list[str]:
    return [_clean(text) for text in (item.place, item.what, item.found, item.wanted)]


def _clean(text: str, longest: int = _LONGEST) -> str:
    """Return text of a stranger's as it can be printed: one line, no control characters."""
    return one_line(text, longest, instead="?")
