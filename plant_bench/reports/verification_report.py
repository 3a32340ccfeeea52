"""The result of `plant-bench verify`, as terminal output and as JSON."""

import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass

import typer

from plant_bench.reports.tables import counted, print_rows
from plant_bench.runner.review.differences import EpisodeCheck
from plant_bench.runner.review.submission import Submission
from plant_bench.runner.review.submission_checks import Finding
from plant_bench.text_escaping import one_line

VERIFICATION_FORMAT = 1
_SHOWN = 20  # findings in a table; the JSON file has all of them
_LONGEST = 60  # characters of a value


@dataclass(frozen=True)
class Verification:
    """The result of a verification.

    Attributes:
        submission: The run.
        checked: Episodes that were simulated again.
        way: "agent" or "controls": what they were driven by.
        seed: Random seed of the sample.
        rescored: Episodes whose recording was scored again without the simulator.
    """

    submission: Submission
    checked: Sequence[EpisodeCheck]
    way: str
    seed: int
    rescored: Sequence[EpisodeCheck]

    @property
    def different(self) -> int:
        """Number of episodes that differ from their records when they are simulated again."""
        return sum(item.difference is not None for item in self.checked)

    @property
    def rescored_different(self) -> int:
        """Number of episodes that differ from their records when they are scored again."""
        return sum(item.difference is not None for item in self.rescored)

    @property
    def confirmed(self) -> bool:
        """Whether there is no difference and no other finding."""
        return not (self.different or self.rescored_different or self.submission.findings)

    def to_json(self) -> str:
        """Return the complete result as JSON."""
        run = self.submission.provenance
        payload = {
            "format": VERIFICATION_FORMAT,
            "confirmed": self.confirmed,
            "agent": run.agent,
            "agent_checksum": run.agent_checksum,
            "suite": run.suite,
            "protocol": run.protocol,
            "base_seed": run.seed,
            "density": run.density,
            "records": len(self.submission.records),
            "way": self.way,
            "sample_seed": self.seed,
            "episodes": [
                asdict(item) | {"equal": item.difference is None} for item in self.checked
            ],
            "rescored": [
                asdict(item) | {"equal": item.difference is None} for item in self.rescored
            ],
            "findings": [asdict(item) for item in self.submission.findings],
            "notes": list(self.submission.notes),
        }
        return json.dumps(payload, indent=1) + "\n"


def print_submission(submission: Submission) -> None:
    """Print the run's description, and the problems found without simulation."""
    run = submission.provenance
    hazards = "" if run.hazards else ", no hazards"
    typer.echo(
        f"{_clean(run.agent)} on {_clean(run.suite)}: {len(submission.records)} records, "
        f"protocol {_clean(run.protocol)}, base seed {run.seed}, density "
        f"{_clean(run.density)}{hazards}"
    )
    for note in submission.notes:
        typer.echo(_clean(note, len(note)))
    findings = submission.findings
    rows = [_row(item) for item in findings[:_SHOWN]]
    print_rows("Problems", ["file", "what", "found", "expected"], rows)
    if len(findings) > _SHOWN:
        typer.echo(f"and {len(findings) - _SHOWN} more (--json FILE has all of them)")


def print_verification(verification: Verification) -> None:
    """Print the episodes that were scored or simulated again, and the verdict."""
    rescored = [
        [_clean(item.name), _clean(item.town), *map(_clean, vars(item.difference).values())]
        for item in verification.rescored
        if item.difference is not None
    ]
    heads = ["episode", "town", "first difference", "record", "recording"]
    print_rows("Scored again from the recording: different", heads, rescored[:_SHOWN])
    if len(rescored) > _SHOWN:
        typer.echo(f"and {len(rescored) - _SHOWN} more (--json FILE has all of them)")
    rows = []
    for item in verification.checked:
        cells = ("", "", "")
        if (other := item.difference) is not None:
            cells = (_clean(other.field), _clean(other.told), _clean(other.again))
        rows.append(
            [_clean(item.name), _clean(item.town), "different" if other else "equal", *cells]
        )
    how = "the agent" if verification.way == "agent" else "the recorded controls"
    title = f"Simulated again with {how} (sample seed {verification.seed})"
    heads = ["episode", "town", "record", "first difference", "recorded", "simulated"]
    print_rows(title, heads, rows)
    typer.echo(_verdict(verification))


def _verdict(verification: Verification) -> str:
    count = len(verification.submission.records)
    recorded = len(verification.rescored)
    checked = (
        f"{recorded} of {counted(count, 'episode')} scored again from the recording, "
        f"{len(verification.checked)} simulated again"
    )
    if verification.confirmed:
        return (
            f"CONFIRMED: {checked}, all equal byte for byte; no episode is missing or duplicated, "
            "and the summary follows from the records."
        )
    different = f"{verification.rescored_different} and {verification.different} different"
    others = counted(len(verification.submission.findings), "other finding")
    return f"NOT CONFIRMED: {checked}, {different}; {others}."


def _row(item: Finding) -> list[str]:
    return [_clean(text) for text in (item.place, item.what, item.found, item.wanted)]


def _clean(text: str, longest: int = _LONGEST) -> str:
    """Return untrusted text as one printable line without control characters."""
    return one_line(text, longest, instead="?")
