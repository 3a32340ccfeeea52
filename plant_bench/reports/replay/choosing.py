"""Finds the episode of a run that is to be replayed."""

import re
from pathlib import Path

from plant_bench.errors import InputError
from plant_bench.reports.replay.source import ReplaySource
from plant_bench.runner.provenance import without_folders
from plant_bench.runner.run_folder import RunFolder
from plant_bench.scoring.results import EpisodeResult


def source_in_run(run: Path, route: str, repetition: int | None) -> ReplaySource:
    """Return an episode of a run as a source of a replay.

    Args:
        run: A folder that `plant-bench score` wrote.
        route: The route's id.
        repetition: Of the route; the first one there is without it.

    Raises:
        InputError: It is no run, or has no such episode; says which it has.
    """
    found: dict[int, Path] = {}
    routes: set[str] = set()
    for path in RunFolder.open(run).record_files():
        name, _, number = path.stem.rpartition("_")[0].rpartition("_r")
        routes.add(name)
        if name == route and number.isdigit():
            found[int(number)] = path
    if not found:
        some = ", ".join(sorted(routes)[:12]) or "none"
        more = "" if len(routes) <= 12 else f" and {len(routes) - 12} more"
        message = f"{run} has no episode on route '{route}'. Routes there: {some}{more}."
        raise InputError(message)
    wanted = min(found) if repetition is None else repetition
    if wanted not in found:
        numbers = ", ".join(map(str, sorted(found)))
        message = f"{run} has no repetition {wanted} of {route}. There: {numbers}."
        raise InputError(message)
    path = found[wanted]
    result = EpisodeResult.load(path)
    recording = RunFolder(run).recording_path(path.stem)
    title = without_folders(result.agent)
    return ReplaySource(f"{run_slug(run)}/{path.stem}", title, result.agent, recording, result)


def run_slug(run: Path) -> str:
    """Return the name of a run's folder, in letters that may stand in addresses.

    >>> run_slug(Path("reports/my agent.py_Mine-longest6"))
    'my-agent.py_Mine-longest6'
    """
    slug = re.sub(r"[^A-Za-z0-9_.-]+", "-", run.resolve().name).strip("-.")
    return slug or "run"
