"""Collecting data to learn from: drive, and sum up the data that is there then."""

import json
import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from plant_bench.api.execution import cores
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
class Collected:
    """What a data folder holds.

    Attributes:
        path: The folder.
        data: What is in it, in numbers.
        notes: How each episode has ended, those left out among them.
    """

    path: Path
    data: DataStatistics
    notes: Sequence[EpisodeNote]

    @property
    def left_out(self) -> dict[str, int]:
        """How many episodes are not in the data, by reason."""
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
) -> Collected:
    """Let the expert drive training routes and keep what it saw and did, as `plant-bench collect`.

    The same call again goes on where it was interrupted; with more frames it adds to what is there.

    Args:
        out: The data's folder.
        frames: How many, at 2 Hz.
        units: How much in PlanT's units of 228,000 frames, instead; 1 without both.
        seed: Of routes, traffic and disturbances; others give other data.
        perturb: Share of episodes with disturbances from which the expert recovers.
        driver: Lets this planner drive, and keeps what the expert would do (DAgger): a name,
            "file.py:Class", or a class of a module or file.
        density: Of the traffic.
        workers: Processes; one a core without it. The data does not depend on it.
        on_event: Told of towns and episodes (`runner.collect.collection`).

    Raises:
        InputError: The request cannot be met, or the folder holds data of another origin.
        SimulationError: Worker processes do not start, or no episode is of use.
    """
    if units is not None and frames is not None:
        message = "units and frames both say how much: give one of them."
        raise InputError(message)
    wanted = frames if frames is not None else round(UNIT * (1.0 if units is None else units))
    name = "" if driver is None else spec_of(driver, "collect")
    request = CollectRequest(wanted, seed, density, perturb, name)
    return collect_data(
        request,
        Path(out),
        workers=cores() if workers is None else workers,
        on_event=on_event or _ignore,
    )


def collect_data(
    request: CollectRequest, out: Path, *, workers: int, on_event: Listener
) -> Collected:
    """Collect data, or go on with it, until there is enough; write what it holds then.

    Raises:
        PlantBenchError: It cannot be started or cannot go on.
        KeyboardInterrupt: It was stopped; what was driven is kept.
    """
    drive_collection(request, out, workers=workers, on_event=on_event)
    folder = DataFolder(out)
    found = Collected(folder.path, describe_data(folder.path), folder.notes())
    summary = {
        "request": vars(request),
        "data": found.data.model_dump(mode="json"),
        "episodes_driven": len(found.notes),
        "left_out": found.left_out,
        "collisions" if request.driver else "collisions_by_others": sum(
            note.collisions for note in found.notes if not note.left_out
        ),
    }
    folder.write("data.json", json.dumps(summary, indent=1) + "\n")
    card = data_card(found.data, request, found.notes, folder.path.resolve().name)
    folder.write("README.md", card)
    return found


def _ignore(event: CollectEvent) -> None:
    del event
