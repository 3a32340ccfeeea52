"""The data card: what a folder of collected data is, for who finds it without us."""

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

- `episodes/*.parquet`: one episode a file (zstd), one row a tick (20 Hz). Readable by pandas,
  polars, DuckDB and all that reads Parquet, and by `plant_bench.data.recording.Recording`.
- `routes/*.json`: the routes, a suite file a town (`plant_bench.world.route.load_suite`).
- `towns/`: the towns that the benchmark does not have. To drive or draw in them, set the
  environment variable `PLANT_BENCH_TOWNS` to that folder.
- `records/*.json`: how each episode ended, also of those left out. `data.json`: the numbers below.

| column | is |
|---|---|
| `tick` | 0.05 s each, from 0 |
| `x`, `y`, `yaw`, `speed`, `acceleration`, `steering` | the ego (box centre): m, rad, m/s, m/s2 |
| `actor_id`, `actor_x`, `actor_y`, `actor_yaw`, `actor_speed`, `actor_length`, `actor_width`, \
`actor_kind` | all others within sight (80 m), as lists; null but at every 10th tick |
| `lights` | what the route's traffic lights show, in the order of its signals (0 out of view, \
1 green, 2 yellow, 3 red); null but at every 10th tick |
| `acceleration_asked`, `steering_asked` | what the expert asked for, whatever was executed |
| `plan` | null: the expert answers with a control |
| `reason`, `reason_actor` | why it drives no faster, and for whom it brakes |
| `disturbed` | {disturbed} |

World frame: x east, y north, yaw counter-clockwise from east. `actor_kind`: 0 car, 1 van, 2 truck,
3 bus, 4 motorcycle, 5 bicycle, 6 pedestrian, 7 static. The file's metadata
(`plant_bench.metadata`, JSON) names route, town, seed, protocol and agent ({agent}), and
tells what became of the route's hazards.

## What it shares with the benchmark, and what not

In the benchmark's six towns streets are shared. Routes are not: none has more than half of its
length (or of the benchmark route's, where that is shorter) in common with any one of the
benchmark's. Hazards and traffic seeds are others. The other towns (two thirds of the frames of a
whole unit) are none that the benchmark drives in.

## What was left out

{left_out}

{collided}, in episodes that are in the data: {collisions}.
"""


class _Wording(NamedTuple):
    """What differs between data of the expert's drives and data of its answers."""

    who: str
    disturbed: str
    agent: str
    collided: str


_DRIVES = _Wording(
    "the expert, an algorithm\nthat is told the simulator's facts, drives",
    "something else than the expert's answer was executed: not to be learned from",
    "who drove",
    "Collisions that others caused",
)


def who_drove(driver: str) -> str:
    """Return what data is in which another planner drove, in one sentence."""
    return (
        f"`{driver}` drove, and the expert answered what it would have done there (DAgger). These "
        "are expert actions, not drives: train with `plant-bench train plant --targets "
        "expert-action`."
    )


def _answers(driver: str) -> _Wording:
    return _Wording(
        f"{who_drove(driver)}\nThe expert is an algorithm that is told the simulator's facts. "
        "All this is",
        "the driver's control was executed and not the expert's answer; unmarked where the two "
        "agree or the expert relieved a driver that stood against its wish",
        "who answered",
        "Collisions of all kinds, the driver's own included",
    )


def data_card(
    data: DataStatistics, request: CollectRequest, notes: Sequence[EpisodeNote], out: str
) -> str:
    """Return the data card, in Markdown; equal data gives equal text.

    Args:
        data: What is in the folder.
        request: What was asked for.
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
    """Return how many episodes were left out, by reason."""
    reasons = Counter(note.left_out.partition(":")[0] for note in notes if note.left_out)
    return dict(sorted(reasons.items(), key=lambda item: (-item[1], item[0])))


def _left_out(notes: Sequence[EpisodeNote]) -> str:
    counts = count_left_out(notes)
    lines = [f"{sum(counts.values())} of {len(notes)} episodes{':' if counts else '.'}"]
    return "\n".join([*lines, *(f"- {number}: {reason}" for reason, number in counts.items())])
