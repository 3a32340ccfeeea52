"""Builds a CARLA checkpoint from a run folder."""

import shlex
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise

from plant_bench.errors import InputError
from plant_bench.reports.carla_checkpoint_writing import checkpoint
from plant_bench.runner.episode.jobs import select_ids
from plant_bench.runner.episode.timing import Timing
from plant_bench.runner.run.folder import RunFolder
from plant_bench.runner.run.provenance import Provenance
from plant_bench.scoring.results import EpisodeResult
from plant_bench.untrusted_files import read_text


@dataclass(frozen=True)
class RunCheckpoint:
    """A run as a checkpoint file.

    Attributes:
        content: Content of the file, as JSON values.
        episodes: Number of episodes.
        expected: Number of episodes in a complete run.
    """

    content: dict[str, object]
    episodes: int
    expected: int


def run_checkpoint(folder: RunFolder, repetition: int | None = None) -> RunCheckpoint:
    """Return a run's checkpoint.

    Args:
        folder: The run.
        repetition: The only one to write; None for all.

    Raises:
        InputError: The run is broken, or has no such episodes.
    """
    provenance = folder.provenance()
    results = [item for item in folder.results() if repetition in (None, item.repetition)]
    if provenance is None or not results:
        what = "episodes" if repetition is None else f"episodes of repetition {repetition}"
        message = f"{folder.path} has no {what}. Run 'plant-bench score' to drive them."
        raise InputError(message)
    known = list(dict.fromkeys([*provenance.routes, *sorted(item.route for item in results)]))
    numbers = _numbers(known, provenance.carla_routes)
    towns = {route: town for route, (_, town) in provenance.carla_routes.items()}
    planned = {place for place in _planned(provenance) if repetition in (None, place[1])}
    expected = len(planned | {(item.route, item.repetition) for item in results})
    walls = _walls(folder)
    content = checkpoint(results, numbers=numbers, expected=expected, walls=walls, towns=towns)
    return RunCheckpoint(content, len(results), expected)


def _numbers(routes: Sequence[str], sources: Mapping[str, tuple[str, str]]) -> dict[str, int]:
    """Return a number for each route: CARLA's own where all have one, else the place in the run."""
    own = [sources.get(route, ("", ""))[0] for route in routes]
    if all(number.isdecimal() for number in own) and len(set(map(int, own))) == len(own):
        return dict(zip(routes, map(int, own), strict=True))
    return {route: number for number, route in enumerate(routes)}


def _planned(provenance: Provenance) -> set[tuple[str, int]]:
    """Return the routes and repetitions that the run's last command selected."""
    try:
        words = shlex.split(provenance.command)
    except ValueError:  # not a valid shell command
        words = []
    inline = [word.partition("=")[2] for word in words if word.startswith("--routes=")]
    separate = [value for word, value in pairwise(words) if word == "--routes"]
    selection = next(iter([*inline, *separate]), None)
    chosen = select_ids(list(provenance.routes), selection)
    return {(route, number) for route in chosen for number in range(provenance.repetitions)}


def _walls(folder: RunFolder) -> dict[tuple[str, int], float]:
    """Return the wall time of each route and repetition in seconds, as far as known."""
    walls = {}
    for path in folder.record_files():
        timing = folder.path / "timing" / path.name
        if not timing.is_file():
            continue
        try:
            wall = Timing.model_validate_json(read_text(timing)).wall_s
        except (OSError, ValueError):
            continue  # the wall time is optional
        result = EpisodeResult.load(path)
        walls[result.route, result.repetition] = wall
    return walls
