"""Tables on the terminal: of a run, of its speed, and of two runs compared."""

import math
from collections.abc import Sequence

from rich.console import Console
from rich.table import Table

from plant_bench.runner.episode import Timing
from plant_bench.scoring.infractions import InfractionKind
from plant_bench.scoring.metrics import Difference, Scores, Spread, Summary

DEADLINE = "50 ms"  # a tick: 20 decisions a second
_console = Console(highlight=False)


def print_summary(summary: Summary) -> None:
    """Print the scores, in all and by town, the infractions and how the episodes ended."""
    count = f"{summary.episodes}/{summary.expected} episodes"
    table = Table(title=f"{summary.agent}, {summary.protocol}, {count}", title_justify="left")
    table.add_column("town")
    for head in ("DS", "RC %", "IS", "CV /km"):
        table.add_column(head, justify="right")
    for town, scores in summary.towns.items():
        table.add_row(town, *_cells(scores))
    table.add_section()
    table.add_row("all", *_cells(summary.scores), style="bold")
    _console.print(table)
    print_rows(
        f"Infractions per km ({summary.km:.2f} km along the routes)",
        ["kind", "per km"],
        [
            [_kind_name(kind), f"{rate:.3f}"]
            for kind, rate in summary.infractions_per_km.items()
            if rate > 0.0
        ],
    )
    if not math.isnan(summary.ego_share):
        _console.print(f"Collisions that the ego drove into: {summary.ego_share:.0%}")
    endings = [f"{count} {status}" for status, count in summary.statuses.items()]
    _console.print(f"Episodes: {'; '.join(endings)}")


def print_latency(timings: Sequence[Timing]) -> None:
    """Print how long the planner took to decide; it is no part of the score."""
    ticks = sum(timing.ticks for timing in timings)
    if not ticks:
        return

    def mean(name: str) -> float:
        return sum(getattr(timing, name) * timing.ticks for timing in timings) / ticks

    _console.print(
        f"Decision time (not scored): p50 {mean('latency_p50_ms'):.2f} ms, "
        f"p95 {mean('latency_p95_ms'):.2f} ms, p99 {mean('latency_p99_ms'):.2f} ms "
        f"(means of the episodes'), {mean('late_share'):.2%} over {DEADLINE}"
    )


def print_speed(timings: Sequence[Timing], *, wall_s: float, workers: int) -> None:
    """Print how fast this command drove.

    Args:
        timings: Of the episodes driven by it.
        wall_s: From start to end.
        workers: Number of processes.
    """
    if not timings:
        _console.print("Nothing was left to drive: all episodes were finished before.")
        return
    simulated = sum(timing.simulated_s for timing in timings)
    spent = {
        "simulation": sum(timing.simulation_s + timing.privileged_s for timing in timings),
        "planner": sum(timing.agent_s for timing in timings),
        "referee": sum(timing.referee_s for timing in timings),
    }
    whole = sum(timing.wall_s for timing in timings)
    parts = [f"{name} {seconds / whole:.0%}" for name, seconds in spent.items()]
    rest = 1.0 - sum(spent.values()) / whole
    _console.print(
        f"Driven now: {len(timings)} episodes, {simulated / 3600:.2f} h simulated in "
        f"{wall_s / 60:.1f} min with {workers} workers, {simulated / wall_s:.0f} x real time "
        f"({', '.join(parts)}, rest {rest:.0%})"
    )


def print_difference(difference: Difference, first: str, second: str) -> None:
    """Print by how much the second run is better than the first."""
    _console.print(str(difference), first, second)


def print_rows(title: str, heads: Sequence[str], rows: Sequence[Sequence[object]]) -> None:
    """Print a plain table; numbers to the right."""
    if not rows:
        return
    table = Table(title=title, title_justify="left")
    for place, head in enumerate(heads):
        numeric = all(isinstance(row[place], int | float) for row in rows)
        table.add_column(head, justify="right" if numeric or place else "left")
    for row in rows:
        table.add_row(*map(_text, row))
    _console.print(table)


def _cells(scores: Scores) -> list[str]:
    return [
        _spread(scores.driving_score, 1),
        _spread(scores.route_completion, 1),
        _spread(scores.infraction_score, 2),
        _spread(scores.vehicle_collisions, 2),
    ]


def _spread(spread: Spread, digits: int) -> str:
    mean = f"{spread.mean:.{digits}f}"
    return mean if math.isnan(spread.std) else f"{mean} ± {spread.std:.{digits}f}"


def _kind_name(kind: InfractionKind) -> str:
    note = " (km)" if kind is InfractionKind.OUTSIDE_LANES else ""
    return kind.value.replace("_", " ") + note


def _text(value: object) -> str:
    if isinstance(value, float):
        return f"{value:.2f}"
    if isinstance(value, tuple):
        return " x ".join(_text(item) for item in value)
    if isinstance(value, dict):
        return ", ".join(f"{count} {name}" for name, count in value.items())
    return str(value)
