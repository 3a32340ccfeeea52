"""What `plant-bench why RUN ROUTE` does: look at episodes again, print and draw what was found."""

from collections.abc import Sequence
from pathlib import Path

import typer
from rich.progress import TaskProgressColumn

from plant_bench.cli.bars import progress_bars
from plant_bench.data.recording import Recording
from plant_bench.errors import InputError
from plant_bench.reports.choosing import episodes_of
from plant_bench.reports.why.findings import Finding, find
from plant_bench.reports.why.incidents import check_recorded, incidents
from plant_bench.reports.why.picture import save_picture
from plant_bench.reports.why.text import episode_line, print_episode
from plant_bench.runner.review.hindsight import look_back
from plant_bench.runner.review.moments import Hindsight
from plant_bench.runner.run.folder import RunFolder
from plant_bench.scoring.results import EpisodeResult
from plant_bench.world.route import Route, load_suite


def explain_route(
    folder: RunFolder, route: str, repetition: int | None, out: Path | None, before: float
) -> None:
    """Explain each infraction of a route's episodes.

    Args:
        folder: The run.
        route: Id or number of the route.
        repetition: The only one that is wanted; None for all.
        out: A PNG file or a folder for the pictures; None for `why/` in the run.
        before: Seconds to look at before each infraction.

    Raises:
        InputError: There is no such episode, or no recording of it.
        SimulationError: SUMO fails.
    """
    episodes = episodes_of(folder, route, repetition)
    for name, result in episodes:
        if not result.infractions:
            typer.echo(f"{episode_line(result)}: no infraction.")
            continue
        recording = _recording(folder, name)
        check_recorded(result, len(recording))
        hindsight = _look(recording, result, _route_of(folder, result), before)
        findings = [find(item, hindsight) for item in incidents(result, before)]
        print_episode(hindsight, findings)
        pictures = _picture_paths(out or folder.path / "why", name, findings, len(episodes) > 1)
        for finding, path in zip(findings, pictures, strict=True):
            save_picture(finding, hindsight, path)
            typer.echo(f"Picture: {path}")


def _look(recording: Recording, result: EpisodeResult, route: Route, before: float) -> Hindsight:
    windows = [item.window for item in incidents(result, before)]
    with progress_bars(len(result.route) + 18, TaskProgressColumn()) as bars:
        task = bars.add_task(f"{result.route}, repetition {result.repetition}", total=1.0)
        found = look_back(
            recording, result, route, windows, lambda share: bars.update(task, completed=share)
        )
        bars.update(task, completed=1.0)
    return found


def _recording(folder: RunFolder, name: str) -> Recording:
    path = folder.recording_path(name)
    if not path.is_file():
        message = (
            f"{folder.path} has no recording of {name}: nothing can be seen of it. Score the run "
            "again, with --recordings."
        )
        raise InputError(message)
    return Recording.load(path)


def _route_of(folder: RunFolder, result: EpisodeResult) -> Route:
    told = folder.provenance()
    suite = "" if told is None else told.suite
    found = [route for route in load_suite(suite) if route.id == result.route]
    if not found:
        message = f"The suite {suite} has no route {result.route} any more."
        raise InputError(message)
    return found[0]


def _picture_paths(out: Path, name: str, findings: Sequence[Finding], several: bool) -> list[Path]:
    """Return where each picture goes."""
    if out.suffix.lower() != ".png":
        return [
            out / f"{name}_{item.incident.number}_{item.incident.infraction.kind.value}.png"
            for item in findings
        ]
    if len(findings) == 1 and not several:
        return [out]
    tag = f"_{name}" if several else ""
    return [out.with_name(f"{out.stem}{tag}_{item.incident.number}.png") for item in findings]
