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
    count_findings,
    episode_of,
    inputs_findings,
    nonstandard_settings,
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
        folder: The run's folder.
        provenance: Settings and versions that the run claims.
        routes: The installed suite's routes by id.
        records: Episode records by the name of their files.
        findings: Values that differ from the expected ones.
        notes: Remarks for the reader that are not findings.
    """

    folder: RunFolder
    provenance: Provenance
    routes: Mapping[str, Route]
    records: Mapping[str, EpisodeResult]
    findings: tuple[Finding, ...]
    notes: tuple[str, ...]

    def job(self, result: EpisodeResult) -> Job:
        """Return the episode that a record should belong to, made from the installed suite.

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
        path: The run's folder.
        suite: The expected suite; None for the built-in suite that the run names.
        selection: The expected routes; None for all of the suite.
        repetitions: Expected repetitions of each route; None for the number that the run claims.

    Raises:
        InputError: The folder holds no run, or its suite is not installed.
    """
    folder = RunFolder.open(path)
    check_no_links(folder.path)
    provenance = Provenance.load(folder.run_file)
    routes = _suite(provenance, suite)
    expected = select_routes(list(routes.values()), selection)
    records, findings = _records(folder)
    if not records:
        message = f"{path} has no readable episode records: there is nothing to verify."
        raise InputError(message)
    known = {name: result for name, result in records.items() if result.route in routes}
    for name, result in records.items():
        findings += record_findings(name, result, provenance, routes)
    if repetitions is None:
        repetitions = max([provenance.repetitions, *(r.repetition + 1 for r in records.values())])
    findings += inputs_findings(records)
    findings += run_findings(provenance, routes)
    findings += count_findings(records.values(), expected, repetitions)
    findings += summary_findings(folder, list(records.values()))
    keys, notes = check_names(known, provenance, routes)
    notes += nonstandard_settings(folder, provenance, repetitions)
    return Submission(folder, provenance, routes, known, (*findings, *keys), tuple(notes))


def check_no_links(path: Path) -> None:
    """Check that the parts of a run are not symbolic links.

    Raises:
        InputError: One is a symbolic link.
    """
    for part in ("run.json", "summary.json", "summary.csv", "episodes", "recordings"):
        if (path / part).is_symlink():
            message = (
                f"{path / part} is a symbolic link. A run to be verified must contain its files."
            )
            raise InputError(message)


def _suite(provenance: Provenance, suite: str | None) -> dict[str, Route]:
    if suite is None and provenance.suite not in suite_names():
        message = (
            f"The run names the suite {provenance.suite[:100]!r}, which is not built in "
            f"({', '.join(suite_names())}). Pass routes that you trust with --suite."
        )
        raise InputError(message)
    return {route.id: route for route in load_suite(suite or provenance.suite)}


def _records(folder: RunFolder) -> tuple[dict[str, EpisodeResult], list[Finding]]:
    records, findings = {}, []
    for path in folder.record_files():
        place = f"episodes/{path.name}"
        try:
            if path.is_symlink():
                message = "symbolic link"
                raise InputError(message)
            check_file(path, largest=LARGEST_RECORD)
            records[path.stem] = result = EpisodeResult.load(path)
        except (InputError, OSError, ValueError) as error:
            findings.append(Finding(place, "record", str(error), "an episode record"))
            continue
        if result.to_json() != read_text(path, largest=LARGEST_RECORD):
            findings.append(
                Finding(place, "text", "other formatting", "the text that plant-bench writes")
            )
    return records, findings
