"""The data card: what a folder of collected data is, for who finds it without us."""

from collections import Counter
from collections.abc import Sequence

from plant_bench.data.statistics import DataStatistics
from plant_bench.reports.data_tables import data_tables
from plant_bench.runner.collecting_request import UNIT, CollectRequest
from plant_bench.runner.data_folder import EpisodeNote
from plant_bench.world.route import PROTOCOL

_CARD = """# Driving data of plant-bench

{frames:,} frames at 2 Hz ({units:.2f} of PlanT's 1x, {unit:,} frames): the expert, an algorithm
that is told the simulator's facts, drives in SUMO under the protocol `{protocol}`.
Made by `plant-bench collect --frames {asked} --seed {seed} --density {density} --perturb
{perturb:g}`; the same command gives the same files.

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
| `acceleration_asked`, `steering_asked` | what the expert asked for, in a disturbance too |
| `plan` | null: the expert answers with a control |
| `reason`, `reason_actor` | why it drives no faster, and for whom it brakes |
| `disturbed` | something else than the expert's answer was executed: not to be learned from |

World frame: x east, y north, yaw counter-clockwise from east. `actor_kind`: 0 car, 1 van, 2 truck,
3 bus, 4 motorcycle, 5 bicycle, 6 pedestrian, 7 static. The file's metadata
(`plant_bench.metadata`, JSON) names route, town, seed, protocol and agent, and tells what became of
the route's hazards.

## What it shares with the benchmark, and what not

In the benchmark's six towns streets are shared. Routes are not: none has more than half of its
length (or of the benchmark route's, where that is shorter) in common with any one of the
benchmark's. Hazards and traffic seeds are others. The other towns (two thirds of the frames of a
whole unit) are none that the benchmark drives in.

## What was left out

{left_out}

Collisions that others caused, in episodes that are in the data: {collisions}.
"""


def data_card(data: DataStatistics, request: CollectRequest, notes: Sequence[EpisodeNote]) -> str:
    """Return the data card, in Markdown; equal data gives equal text.

    Args:
        data: What is in the folder.
        request: What was asked for.
        notes: How each episode ended.
    """
    card = _CARD.format(
        frames=data.frames,
        units=data.frames / UNIT,
        unit=UNIT,
        protocol=PROTOCOL,
        asked=request.frames,
        seed=request.seed,
        density=request.density,
        perturb=request.perturb,
        left_out=_left_out(notes),
        collisions=sum(note.collisions for note in notes if not note.left_out),
    )
    tables = [
        f"\n## {title}\n\n| {head} | |\n|---|--:|\n" + "".join(f"| {a} | {b} |\n" for a, b in rows)
        for title, head, rows in data_tables(data)
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
