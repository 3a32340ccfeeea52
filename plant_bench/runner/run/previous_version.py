"""Finds the episodes of a planner's previous version among the superseded ones of a run."""

from pathlib import Path

from plant_bench.errors import InputError
from plant_bench.runner.run.folder import RunFolder
from plant_bench.scoring.results import EpisodeResult

SUPERSEDED = "superseded"


def previous_folder(folder: RunFolder) -> RunFolder:
    """Return the folder with the superseded episodes of a run; it has no `run.json`."""
    return RunFolder(folder.path / SUPERSEDED)


def previous_records(folder: RunFolder) -> dict[str, EpisodeResult]:
    """Return the records of the planner's previous version, by the name of their files.

    Superseded records may be of several versions of the planner, and also of the present one with
    other rules. The previous version is the one, other than the present one, that has the newest
    record file. If a scenario has several records of it, the newest is returned.

    Args:
        folder: The run.

    Raises:
        InputError: There are none, or a record is broken.
    """
    current = {EpisodeResult.load(path).agent_checksum for path in folder.record_files()}
    newest_first = sorted(
        previous_folder(folder).record_files(),
        key=lambda path: (path.stat().st_mtime_ns, path.name),
        reverse=True,
    )
    found: dict[str, EpisodeResult] = {}
    scenarios: set[tuple[str, str]] = set()
    version = ""
    for path in newest_first:
        record = EpisodeResult.load(path)
        if record.agent_checksum in current:
            continue
        version = version or record.agent_checksum
        scenario = record.scenario, record.town_checksum
        if record.agent_checksum == version and scenario not in scenarios:
            found[path.stem] = record
            scenarios.add(scenario)
    if not found:
        message = (
            f"{folder.path} has no episodes of a previous version of its planner. 'plant-bench "
            f"score' moves them to {Path(folder.path.name, SUPERSEDED)} when it runs again after "
            "the planner's code has changed."
        )
        raise InputError(message)
    return dict(sorted(found.items()))
