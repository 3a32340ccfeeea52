"""Reads an untrusted run and checks it against the routes, towns and rules installed here.

Nothing in the run is executed or changed.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from plant_bench.errors import InputError
from plant_bench.runner.episode.jobs import Job, select_routes
from plant_bench.runner.review.submission_checks import (
    Finding,
    check_names,
    choices_of,
    count_findings,
    episode_of,
    inputs_findings,
    record_findings,
    run_findings,
    summary_findings,
)
from plant_bench.runner.run.folder import RunFolder
from plant_bench.runner.run.provenance import Provenance
from plant_bench.scoring.results import LARGEST_RECORD, EpisodeResult
from plant_bench.untrusted_files import check_file, read_text
from plant_bench.world.route import Route, load_suite, suite_names


@dataclass(frozen=True)
class Submission:
    """A run to be verified.

    Attributes:
        folder: Where it lies.
        provenance: What it says it was made with.
        routes: The suite's routes by id, as they are here.
        records: By the name of their files.
        findings: What is not as it should be.
        notes: What the reader should know.
    """

    folder: RunFolder
    provenance: Provenance
    routes: Mapping[str, Route]
    records: Mapping[str, EpisodeResult]
    findings: tuple[Finding, ...]
    notes: tuple[str, ...]

    def job(self, result: EpisodeResult) -> Job:
        """Return the episode that a record should be of: from the suite here, not from it.

        Raises:
            KeyError: The suite has no such route.
        """
        return episode_of(self.provenance, self.routes[result.route], result.repetition)


def read_submission(
    path: Path,
    *,
    suite: str | None = None,
    selection: str | None = None,
    repetitions: int | None = None,
) -> Submission:
    """Read a run and check everything that needs no simulator.

    Args:
        path: Its folder.
        suite: The suite it should be of; None for the one of ours that it names.
        selection: The routes it should have driven; None for all of the suite.
        repetitions: Of each route; None for as many as it says.

    Raises:
        InputError: It is no run, or its suite is not known here.
    """
    folder = RunFolder.open(path)
    check_place(folder.path)
    provenance = Provenance.load(folder.run_file)
    routes = _suite(provenance, suite)
    wanted = select_routes(list(routes.values()), selection)
    records, findings = _records(folder)
    if not records:
        message = f"{path} has no episode records that can be read: there is nothing to verify."
        raise InputError(message)
    known = {name: result for name, result in records.items() if result.route in routes}
    for name, result in records.items():
        findings += record_findings(name, result, provenance, routes)
    if repetitions is None:
        repetitions = max([provenance.repetitions, *(r.repetition + 1 for r in records.values())])
    findings += inputs_findings(records)
    findings += run_findings(provenance, routes)
    findings += count_findings(records.values(), wanted, repetitions)
    findings += summary_findings(folder, list(records.values()))
    keys, notes = check_names(known, provenance, routes)
    notes += choices_of(folder, provenance, repetitions)
    return Submission(folder, provenance, routes, known, (*findings, *keys), tuple(notes))


def check_place(path: Path) -> None:
    """Check that the parts of a run are its own, not links to elsewhere.

    Raises:
        InputError: One is a link.
    """
    for part in ("run.json", "summary.json", "summary.csv", "episodes", "recordings"):
        if (path / part).is_symlink():
            message = f"{path / part} is a link: a run to be verified holds its files itself."
            raise InputError(message)


def _suite(provenance: Provenance, suite: str | None) -> dict[str, Route]:
    if suite is None and provenance.suite not in suite_names():
        message = (
            f"The run is of the suite {provenance.suite[:100]!r}, which is none of plant-bench's "
            f"({', '.join(suite_names())}). Give the routes you trust with --suite."
        )
        raise InputError(message)
    return {route.id: route for route in load_suite(suite or provenance.suite)}


def _records(folder: RunFolder) -> tuple[dict[str, EpisodeResult], list[Finding]]:
    records, findings = {}, []
    for path in folder.record_files():
        place = f"episodes/{path.name}"
        try:
            if path.is_symlink():
                message = "it is a link"
                raise InputError(message)
            check_file(path, largest=LARGEST_RECORD)
            records[path.stem] = result = EpisodeResult.load(path)
        except (InputError, OSError, ValueError) as error:
            findings.append(Finding(place, "record", str(error), "an episode record"))
            continue
        if result.to_json() != read_text(path, largest=LARGEST_RECORD):
            findings.append(Finding(place, "text", "another", "as plant-bench writes records"))
    return records, findings
