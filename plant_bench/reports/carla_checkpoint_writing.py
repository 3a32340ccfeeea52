"""Writes a run as checkpoint JSON of the CARLA leaderboard 1.0, for tools that read this format.

Rates are total counts over total kilometres, in the global record too: the leaderboard's sum of
per-route rates is a known mistake (carla-simulator/leaderboard#117). Positions are in the town's
frame with y north, whereas CARLA's y points south.
"""

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from types import MappingProxyType

import numpy as np

from plant_bench.atomic_files import write_whole_text
from plant_bench.reports.carla_checkpoint_schema import (
    ALL_NAMES,
    EXTRA_FORMAT,
    EXTRA_KEY,
    NAMES,
    OUTSIDE,
    RATE_LABELS,
    SCORE_LABELS,
)
from plant_bench.scoring.infractions import Infraction, InfractionKind, Status
from plant_bench.scoring.normalised_score import LEAST_KM, counts_per_km, kilometres, outside_metres
from plant_bench.scoring.results import EpisodeResult
from plant_bench.world.scene import ActorKind

CRASHES = (Status.AGENT_CRASHED, Status.SIMULATION_CRASHED)
PLACELESS = {
    InfractionKind.RED_LIGHT: "Agent ran a red light",
    InfractionKind.ROUTE_DEVIATION: "Agent left the route",
    InfractionKind.BLOCKED: "Agent got blocked",
    InfractionKind.TIMEOUT: "Agent ran out of time",
}


def checkpoint(
    results: Sequence[EpisodeResult],
    *,
    numbers: Mapping[str, int],
    expected: int,
    walls: Mapping[tuple[str, int], float],
    towns: Mapping[str, str] = MappingProxyType({}),
) -> dict[str, object]:
    """Return the file's content, as JSON-able values.

    Args:
        results: The episodes of one run, at least one.
        numbers: A number for each route id, since other tools expect numeric route ids.
        expected: Number of episodes in a complete run.
        walls: Wall time of each route and repetition in seconds, as far as known.
        towns: CARLA's town of each route that was imported from CARLA.
    """
    ordered = sorted(results, key=lambda item: (numbers[item.route], item.repetition))
    records = [
        _record(index, item, numbers[item.route], walls.get((item.route, item.repetition), 0.0))
        for index, item in enumerate(ordered)
    ]
    for record, item in zip(records, ordered, strict=True):
        if item.route in towns:
            record["town_name"] = towns[item.route]
    scores, rates = _mean_scores(ordered), _rates(ordered)
    finished = len(ordered) >= expected
    crashed = any(item.status in CRASHES for item in ordered)
    status = "Finished with agent errors" if crashed else "Finished"
    return {
        "_checkpoint": {
            "global_record": _global_record(records, ordered, scores, rates),
            "progress": [len(ordered), max(expected, len(ordered))],
            "records": records,
        },
        "eligible": finished and not crashed,
        "entry_status": status if finished else "Started",
        "labels": [*SCORE_LABELS, *RATE_LABELS.values()],
        "sensors": [],
        "values": [f"{value:.3f}" for value in (*scores, *(rates[name] for name in RATE_LABELS))],
        EXTRA_KEY: {
            "format": EXTRA_FORMAT,
            "protocol": ordered[0].protocol,
            "agent": ordered[0].agent,
            "inputs": list(ordered[0].inputs),
            "routes": {item.route: _route_id(numbers[item.route]) for item in ordered},
        },
    }


def write_checkpoint(content: Mapping[str, object], path: Path) -> None:
    """Write a checkpoint file atomically.

    Raises:
        OSError: It cannot be written.
    """
    text = json.dumps(content, indent=1, sort_keys=True, allow_nan=False)
    write_whole_text(path, text + "\n")


def _route_id(number: int) -> str:
    return f"RouteScenario_{number}"


def _record(index: int, result: EpisodeResult, number: int, wall: float) -> dict[str, object]:
    messages: dict[str, list[str]] = {name: [] for name in ALL_NAMES}
    for item in result.infractions:
        messages[NAMES[item.kind]].append(_message(item, result))
    return {
        "index": index,
        "infractions": messages,
        "meta": {
            "duration_game": result.duration,
            "duration_system": wall,
            "route_length": result.route_length,
        },
        "route_id": _route_id(number),
        "scores": {
            "score_composed": result.driving_score,
            "score_penalty": result.infraction_score,
            "score_route": result.route_completion,
        },
        "status": result.status.value,
        EXTRA_KEY: {"result": result.model_dump(mode="json")},
    }


def _message(item: Infraction, result: EpisodeResult) -> str:
    """Return an infraction as text, in the form that common parsers expect.

    The metres come first and have a decimal point; nothing follows the brackets of a position.
    """
    if item.kind is InfractionKind.OUTSIDE_LANES:
        share = item.share or 0.0
        metres, percent = share * result.distance, 100.0 * share
        return f"Agent was outside its lanes for about {metres:.3f} meters ({percent:.2f}% of all)"
    place = f"(x={item.x}, y={item.y}, z=0.0)"
    if item.kind in PLACELESS:
        return f"{PLACELESS[item.kind]} at {place}"
    return f"Agent hit an object with type={_type(item)} and id={item.actor} at {place}"


def _type(item: Infraction) -> str:
    if item.actor_kind is None or item.actor_kind is ActorKind.STATIC:
        return "static.object"
    if item.actor_kind is ActorKind.PEDESTRIAN:
        return "walker.pedestrian"
    return f"vehicle.{item.actor_kind.name.lower()}"


def _mean_scores(results: Sequence[EpisodeResult]) -> tuple[float, float, float]:
    """Return the means of DS, RC in percent and IS, in the order of `SCORE_LABELS`."""
    table = _score_table(results).mean(axis=0)
    return float(table[0]), float(table[1]), float(table[2])


def _score_table(results: Sequence[EpisodeResult]) -> np.ndarray:
    return np.array(
        [[item.driving_score, item.route_completion, item.infraction_score] for item in results]
    )


def _rates(results: Sequence[EpisodeResult]) -> dict[str, float]:
    """Return infractions per kilometre; kilometres outside per kilometre for `OUTSIDE`."""
    counted = {NAMES[kind]: rate for kind, rate in counts_per_km(results).items()}
    outside = sum(map(outside_metres, results)) / 1000.0 / max(kilometres(results), LEAST_KM)
    return dict.fromkeys(ALL_NAMES, 0.0) | counted | {OUTSIDE: outside}


def _global_record(
    records: Sequence[Mapping[str, object]],
    results: Sequence[EpisodeResult],
    scores: tuple[float, float, float],
    rates: Mapping[str, float],
) -> dict[str, object]:
    names = ("score_composed", "score_route", "score_penalty")
    several = len(results) > 1
    spread = _score_table(results).std(axis=0, ddof=1).tolist() if several else ["NaN"] * 3
    failed = [
        [record["route_id"], record["index"], record["status"]]
        for record in records
        if record["status"] != Status.COMPLETED.value
    ]
    return {
        "index": -1,
        "infractions": dict(rates),
        "meta": {"exceptions": failed},
        "route_id": -1,
        "scores": dict(zip(names, scores, strict=True)),
        "scores_std_dev": dict(zip(names, spread, strict=True)),
        "status": "Failed" if failed else "Completed",
    }
