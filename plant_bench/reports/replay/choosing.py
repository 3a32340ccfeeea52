"""Finds the episode of a run that is to be replayed."""

import re
from pathlib import Path

from plant_bench.agents.loading.spec import without_folders
from plant_bench.reports.choosing import episodes_of
from plant_bench.reports.replay.source import ReplaySource
from plant_bench.runner.run.folder import RunFolder


def source_in_run(run: Path, route: str, repetition: int | None) -> ReplaySource:
    """Return an episode of a run as a source of a replay.

    Args:
        run: A folder that `plant-bench score` wrote.
        route: The route's id, or its number in the suite.
        repetition: Of the route; the first one there is without it.

    Raises:
        InputError: It is no run, or has no such episode; says which it has.
    """
    folder = RunFolder.open(run)
    name, result = episodes_of(folder, route, repetition)[0]
    title = without_folders(result.agent)
    return ReplaySource(
        f"{run_slug(run)}/{name}", title, result.agent, folder.recording_path(name), result
    )


def run_slug(run: Path) -> str:
    """Return the name of a run's folder, in letters that may stand in addresses.

    >>> run_slug(Path("reports/my agent.py_Mine-longest6"))
    'my-agent.py_Mine-longest6'
    """
    slug = re.sub(r"[^A-Za-z0-9_.-]+", "-", run.resolve().name).strip("-.")
    return slug or "run"
