"""Writes the data card: a README of a folder of collected driving data."""

from collections import Counter
from collections.abc import Sequence
from typing import NamedTuple

from plant_bench.agents.loading.planner_spec import without_folders
from plant_bench.data.statistics import DataStatistics
from plant_bench.reports.data_tables import data_tables
from plant_bench.runner.collect.data_folder import EpisodeNote
from plant_bench.runner.collect.request import UNIT, CollectRequest
from plant_bench.world.route import PROTOCOL

_CARD = """# Driving data of plant-bench

{frames:,} frames at 2 Hz ({units:.2f} of PlanT's 1x, {unit:,} frames): {who}
in SUMO under the protocol `{protocol}`.
Made by `{command}`;
the same command gives the same files.

## What is in it

- `episodes/*.parquet`: one file per episode (zstd), one row per tick (20 Hz). Readable by pandas,
  polars, DuckDB and other Parquet readers, and by `plant_bench.data.recording.Recording`.
- `routes/*.json`: the routes, one suite file per town (`plant_bench.world.route.load_suite`).
- `towns/`: the towns that are not part of the benchmark. To drive or draw in them, set the
  environment variable `PLANT_BENCH_TOWNS` to this folder.
- `records/*.json`: how each episode ended, also of excluded ones. `data.json`: the numbers below.

| column | content |
|---|---|
| `tick` | 0.05 s each, from 0 |
| `x`, `y`, `yaw`, `speed`, `acceleration`, `steering` | the ego (box centre): m, rad, m/s, m/s2 |
| `actor_id`, `actor_x`, `actor_y`, `actor_yaw`, `actor_speed`, `actor_length`, `actor_width`, \
`actor_kind` | all actors in sight (within 80 m), as lists; null except at every 10th tick |
| `lights` | states of the route's traffic lights, in the order of its signals (0 out of view, \
1 green, 2 yellow, 3 red); null except at every 10th tick |
| `acceleration_asked`, `steering_asked` | the expert's action, whether executed or not |
| `plan` | null: the expert's action is a control |
| `reason`, `reason_actor` | why the expert does not drive faster, and the actor it brakes for |
| `disturbed` | {disturbed} |

World frame: x east, y north, yaw counter-clockwise from east. `actor_kind`: 0 car, 1 van, 2 truck,
3 bus, 4 motorcycle, 5 bicycle, 6 pedestrian, 7 static. The file's metadata
(`plant_bench.metadata`, JSON) has route, town, seed, protocol, agent ({agent}), and
the outcomes of the route's hazards.

## Overlap with the benchmark

Roads of the benchmark's six towns are shared. Routes are not: none shares more than half of its
length (or of the benchmark route's, if that is shorter) with any benchmark route. Hazards and
traffic seeds differ. The other towns (two thirds of the frames of a whole unit) are not used by
the benchmark.

## Excluded episodes

{left_out}

{collided}, in the included episodes: {collisions}.
"""


class _Wording(NamedTuple):
    """Texts that differ between drives of the expert and DAgger data of another planner."""

    who: str
    disturbed: str
    agent: str
    collided: str


_DRIVES = _Wording(
    "the expert, an algorithm\nwith privileged information from the simulator, drives",
    "an action other than the expert's was executed (perturbation): not for training",
    "the driver",
    "Collisions caused by other actors",
)


def who_drove(driver: str) -> str:
    """Return a description of data collected with DAgger."""
    return (
        f"`{driver}` drove, and the expert's action was recorded at each tick (DAgger). These "
        "are expert actions, not drives: train with `plant-bench train plant --targets "
        "expert-action`."
    )


def _answers(driver: str) -> _Wording:
    return _Wording(
        f"{who_drove(driver)}\nThe expert is an algorithm with privileged information from the "
        "simulator. All this is",
        "the driver's control was executed instead of the expert's action; not set if the two "
        "agree, or if the expert took over from a driver that was stationary while the expert "
        "would have driven on",
        "the expert",
        "Collisions of all kinds, including those caused by the driver",
    )


def data_card(
    data: DataStatistics, request: CollectRequest, notes: Sequence[EpisodeNote], out: str
) -> str:
    """Return the data card, in Markdown; equal data gives equal text.

    Args:
        data: Statistics of the data.
        request: The collection request.
        notes: How each episode ended.
        out: Name of the folder.
    """
    wording = _answers(without_folders(request.driver)) if request.driver else _DRIVES
    card = _CARD.format(
        **wording._asdict(),
        frames=data.frames,
        units=data.frames / UNIT,
        unit=UNIT,
        protocol=PROTOCOL,
        command=request.command(out),
        left_out=_left_out(notes),
        collisions=sum(note.collisions for note in notes if not note.left_out),
    )
    tables = [
        f"\n## {title}\n\n| {head} | |\n|---|--:|\n" + "".join(f"| {a} | {b} |\n" for a, b in rows)
        for title, head, rows in data_tables(data, answers=bool(request.driver))
        if rows
    ]
    return card + "".join(tables)


def count_left_out(notes: Sequence[EpisodeNote]) -> dict[str, int]:
    """Return the number of excluded episodes by reason."""
    reasons = Counter(note.left_out.partition(":")[0] for note in notes if note.left_out)
    return dict(sorted(reasons.items(), key=lambda item: (-item[1], item[0])))


def _left_out(notes: Sequence[EpisodeNote]) -> str:
    counts = count_left_out(notes)
    lines = [f"{sum(counts.values())} of {len(notes)} episodes{':' if counts else '.'}"]
    return "\n".join([*lines, *(f"- {number}: {reason}" for reason, number in counts.items())])
