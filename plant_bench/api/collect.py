"""Collects training data and writes its summary and data card."""

import json
import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from plant_bench.api.execution import cores
from plant_bench.api.numbers import (
    HIGHEST_SEED,
    MOST_FRAMES,
    MOST_PROCESSES,
    UNITS_RANGE,
    check_number,
    check_whole_number,
)
from plant_bench.api.planners import PlannerLike, spec_of
from plant_bench.data.statistics import DataStatistics, describe_data
from plant_bench.errors import InputError
from plant_bench.reports.data_card import count_left_out, data_card
from plant_bench.runner.collect.collection import CollectEvent
from plant_bench.runner.collect.collection import collect as drive_collection
from plant_bench.runner.collect.data_folder import DataFolder, EpisodeNote
from plant_bench.runner.collect.request import UNIT, CollectRequest

Listener = Callable[[CollectEvent], None]


@dataclass(frozen=True)
class CollectionResult:
    """The content of a data folder.

    Attributes:
        path: The folder.
        data: Statistics of the data.
        notes: How each episode ended, including excluded episodes.
    """

    path: Path
    data: DataStatistics
    notes: Sequence[EpisodeNote]

    @property
    def left_out(self) -> dict[str, int]:
        """Number of excluded episodes, by reason."""
        return count_left_out(self.notes)


def collect(
    out: str | os.PathLike[str],
    *,
    frames: int | None = None,
    units: float | None = None,
    seed: int = 0,
    perturb: float = 0.0,
    driver: PlannerLike | None = None,
    density: str = "dense",
    workers: int | None = None,
    on_event: Listener | None = None,
) -> CollectionResult:
    """Record training data: the expert drives training routes, as in `plant-bench collect`.

    The same call again continues an interrupted collection; with more frames it adds to the data.

    Args:
        out: Folder for the data.
        frames: Amount of data, in frames at 2 Hz.
        units: Amount of data in PlanT's units of 228,000 frames, instead of `frames`. Default: 1.
        seed: Seed of routes, traffic and perturbations.
        perturb: Fraction of episodes with perturbations, 0 to 1.
        driver: DAgger: this planner drives, and the expert's actions are recorded as labels. A
            name, "file.py:Class", or a class of a module or file.
        density: Traffic density.
        workers: Number of processes; does not change the data. Default: one per core.
        on_event: Called with each `CollectEvent` (`runner.collect.collection`).

    Raises:
        InputError: An argument is invalid, or the folder holds data of another request.
        SimulationError: Worker processes do not start, or no episode is usable.
    """
    if units is not None and frames is not None:
        message = "units and frames exclude each other: give one of them."
        raise InputError(message)
    if frames is not None:
        check_whole_number("frames", frames, 1, MOST_FRAMES)
    if units is not None:
        check_number("units", units, *UNITS_RANGE)
    if workers is not None:
        check_whole_number("workers", workers, 1, MOST_PROCESSES)
    check_whole_number("seed", seed, 0, HIGHEST_SEED)
    check_number("perturb", perturb, 0.0, 1.0)
    amount = frames if frames is not None else round(UNIT * (1.0 if units is None else units))
    name = "" if driver is None else spec_of(driver, "collect")
    request = CollectRequest(amount, seed, density, perturb, name)
    return collect_data(
        request,
        Path(out),
        workers=cores() if workers is None else workers,
        on_event=on_event or _ignore,
    )


def collect_data(
    request: CollectRequest, out: Path, *, workers: int, on_event: Listener
) -> CollectionResult:
    """Start or continue a collection until it has enough frames; write summary and data card.

    Raises:
        PlantBenchError: The collection cannot start or continue.
        KeyboardInterrupt: Ctrl-C was pressed; finished episodes are kept.
    """
    drive_collection(request, out, workers=workers, on_event=on_event)
    folder = DataFolder(out)
    result = CollectionResult(folder.path, describe_data(folder.path), folder.notes())
    summary = {
        "request": vars(request),
        "data": result.data.model_dump(mode="json"),
        "episodes_driven": len(result.notes),
        "left_out": result.left_out,
        "collisions" if request.driver else "collisions_by_others": sum(
            note.collisions for note in result.notes if not note.left_out
        ),
    }
    folder.write("data.json", json.dumps(summary, indent=1) + "\n")
    card = data_card(result.data, request, result.notes, folder.path.resolve().name)
    folder.write("README.md", card)
    return result


def _ignore(event: CollectEvent) -> None:
    del event
