"""Terminal tables: summary of a run, planner time, speed, RFDS."""

import math
import sys
import unicodedata
from collections.abc import Mapping, Sequence

from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.table import Table

from plant_bench.runner.run.speed import Speed
from plant_bench.scoring.comparison import Detectable
from plant_bench.scoring.infractions import InfractionKind
from plant_bench.scoring.metrics import Scores, Summary
from plant_bench.scoring.metrics_table import Metric, Shown, score_metrics, shown_metrics
from plant_bench.scoring.relevance import RelativeScore
from plant_bench.world.hazard import Phase

DEADLINE = "50 ms"  # one tick
PIPED_WIDTH = 140  # columns if the output is not a terminal
console = Console(
    highlight=False, markup=False, emoji=False, width=None if sys.stdout.isatty() else PIPED_WIDTH
)


def counted(number: int, noun: str) -> str:
    """Return a count with its noun, in the plural if the count is not one.

    >>> counted(1, "route"), counted(1200, "episode")
    ('1 route', '1,200 episodes')
    """
    return f"{number:,} {noun}" if number == 1 else f"{number:,} {noun}s"


def print_summary(summary: Summary) -> None:
    """Print the scores by town and overall, the infractions and how the episodes ended."""
    count = f"{summary.episodes}/{summary.expected} episodes"
    head = f"{summary.agent}, {summary.protocol}, penalties {summary.penalties}, {count}"
    console.print(head, style="bold")
    console.print(f"inputs: {', '.join(summary.inputs) or 'ego state only'}")
    table = Table()
    table.add_column("town")
    for metric in score_metrics():
        table.add_column(f"{metric.label} {metric.unit}".strip(), justify="right")
    for town, scores in summary.towns.items():
        table.add_row(town, *_cells(scores))
    table.add_section()
    table.add_row("all", *_cells(summary.scores), style="bold")
    console.print(table)
    legend = ", ".join(f"{metric.label} {metric.long_name}" for metric in score_metrics())
    console.print(legend, style="dim")
    if summary.detectable is not None:
        console.print(_least_difference(summary.detectable))
    print_rows(f"Infractions ({summary.km:.1f} km)", ["kind", "per km"], _rates(summary))
    count = f" ({summary.measures.episodes} of {summary.episodes} episodes)"
    title = "Other metrics" + count * (summary.measures.episodes < summary.episodes)
    print_rows(title, ["measure", "value"], _measures(summary))
    endings = [f"{count} {status}" for status, count in summary.statuses.items()]
    console.print(f"Episodes: {'; '.join(endings)}")
    if summary.hazards:
        console.print(_hazards(summary.hazards))


def _hazards(phases: dict[Phase, int]) -> str:
    done, void = (phases.get(phase, 0) for phase in (Phase.DONE, Phase.VOID))
    return (
        f"Hazards: {done} of {sum(phases.values())} completed, {void} void (cancelled because they "
        "could not be fair), the others not reached"
    )


def _least_difference(detectable: Detectable) -> str:
    return (
        f"With {counted(detectable.repetitions, 'repetition')}, differences below "
        f"{detectable.difference:.1f} DS cannot be distinguished from chance."
    )


def _rates(summary: Summary) -> list[list[str]]:
    rates = {_kind_name(kind): rate for kind, rate in summary.infractions_per_km.items()}
    rates["collision vehicle: bicycles"] = summary.cyclists_per_km
    for metric in shown_metrics(Shown.INFRACTION):
        rates[metric.long_name] = summary.measures[metric.name]
    return [[name, f"{rate:.3f}"] for name, rate in rates.items() if rate > 0.0]


def _measures(summary: Summary) -> list[list[str]]:
    """Return the measures as rows of text; measures with the same title share a row."""
    if not summary.measures.episodes:
        return []
    rows: dict[str, list[str]] = {}
    for metric in shown_metrics(Shown.MEASURE):
        rows.setdefault(metric.long_name, []).append(
            _measured(metric, summary.measures[metric.name])
        )
    share = "-" if math.isnan(summary.ego_share) else f"{summary.ego_share:.0%}"
    rows["collisions that the ego caused"] = [share]
    return [[title, " / ".join(texts)] for title, texts in rows.items()]


def _measured(metric: Metric, value: float) -> str:
    """Return a measure as text; a minimum time is infinite if there was no near miss."""
    if not math.isfinite(value):
        return "-" if math.isnan(value) else "none"
    if metric.unit == "share":
        return f"{value:.{max(metric.digits - 2, 0)}%}"
    unit = "" if "per km" in metric.unit else metric.unit  # the title contains it
    return unicodedata.normalize("NFKC", f"{value:.{metric.digits}f} {unit}").strip()


def print_planner_time(speed: Speed) -> None:
    """Print the planner's decision time and inference time, which are not part of the score."""
    if math.isnan(speed.p50_ms):
        return
    decision = (
        f"p50 {speed.p50_ms:.2f} ms, p95 {speed.p95_ms:.2f} ms, p99 {speed.p99_ms:.2f} ms; "
        f"{speed.late_share:.2%} of decisions took over {DEADLINE}"
    )
    rows = [
        ["decision time (mean over episodes)", decision],
        ["inference time IT (median of one forward pass)", inference_time(speed)],
        ["processor", "; ".join(speed.processors) or "-"],
    ]
    print_rows("Planner time (not scored)", ["what", "value"], rows)


def inference_time(speed: Speed) -> str:
    """Return the median time of a forward pass as text; "-" if the planner reports none."""
    if math.isnan(speed.inference_ms):
        return "-"
    return f"{speed.inference_ms:.2f} ms at {speed.inference_tokens:.0f} tokens"


def print_speed(speed: Speed, *, wall_s: float, workers: str) -> None:
    """Print the simulation speed of a command.

    Args:
        speed: Speed of the episodes that it drove.
        wall_s: Wall time of the command, seconds.
        workers: Description of the processes, such as "2 workers".
    """
    if not speed.episodes:
        return
    parts = ", ".join(f"{name} {share:.0%}" for name, share in speed.shares.items())
    console.print(
        f"Driven now: {counted(speed.episodes, 'episode')}, {speed.simulated_s / 3600:.2f} h "
        f"simulated in {wall_s / 60:.1f} min with {workers}: {speed.simulated_s / wall_s:.0f} x "
        f"real time ({parts})"
    )


def print_rows(title: str, heads: Sequence[str], rows: Sequence[Sequence[object]]) -> None:
    """Print a plain table; numbers are right-aligned."""
    if not rows:
        return
    table = Table(title=title, title_justify="left", box=SIMPLE_HEAD, padding=(0, 1, 0, 0))
    for place, head in enumerate(heads):
        numeric = all(isinstance(row[place], int | float) for row in rows)
        table.add_column(head, justify="right" if numeric or place else "left")
    for row in rows:
        table.add_row(*map(_text, row))
    console.print(table)


def _cells(scores: Scores) -> list[str]:
    return [scores[metric.name].text(metric.digits) for metric in score_metrics()]


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


def print_relative_scores(scores: Mapping[str, RelativeScore]) -> None:
    """Print a row for each ranker, in the given order."""
    some = next(iter(scores.values()))
    rows = [
        [name, item.score.text(2), item.filtered.text(2), item.whole.text(2), item.episodes]
        for name, item in scores.items()
    ]
    title = (
        f"RFDS: the expert's DS with one vehicle in sight, in % ({some.protocol}, {some.penalties})"
    )
    print_rows(title, ["ranker", "RFDS", "DS, one vehicle", "DS, all", "episodes"], rows)
