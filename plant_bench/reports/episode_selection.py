"""Selects the episodes of a run by route and repetition."""

from plant_bench.errors import InputError
from plant_bench.runner.episode.jobs import select_ids
from plant_bench.runner.run.folder import RunFolder
from plant_bench.scoring.results import EpisodeResult


def episodes_of(
    folder: RunFolder, route: str, repetition: int | None
) -> list[tuple[str, EpisodeResult]]:
    """Return the names and records of a route's episodes, by repetition.

    Args:
        folder: The run.
        route: A route's id or its number in the suite.
        repetition: The only repetition to return; None for all.

    Raises:
        InputError: There are none; the message suggests similar ones.
    """
    run = folder.provenance()
    records = {path.stem: EpisodeResult.load(path) for path in folder.record_files()}
    known = list(dict.fromkeys([*(run.routes if run else ()), *_routes(records)]))
    chosen = select_ids(known, route)
    if len(chosen) != 1:
        message = f"'{route}' selects {len(chosen)} routes: expected one."
        raise InputError(message)
    here = sorted(
        ((name, item) for name, item in records.items() if item.route == chosen[0]),
        key=lambda pair: pair[1].repetition,
    )
    found = [pair for pair in here if repetition in (None, pair[1].repetition)]
    if not found:
        numbers = ", ".join(str(item.repetition) for _, item in here)
        there = f"its repetitions are {numbers}" if here else "the route was not driven"
        wanted = "" if repetition is None else f", repetition {repetition}"
        message = f"{folder.path} has no episode of {chosen[0]}{wanted}: {there}."
        raise InputError(message)
    return found


def _routes(records: dict[str, EpisodeResult]) -> list[str]:
    return sorted({item.route for item in records.values()})
