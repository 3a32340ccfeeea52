"""Prints the list of a run's infractions, worst routes first."""

import sys
from collections.abc import Sequence

import numpy as np
from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.table import Table
from rich.text import Text

from plant_bench.reports.tables import PIPED_WIDTH, counted
from plant_bench.reports.why.incidents import KIND_NAMES, actor_name
from plant_bench.scoring.infractions import Infraction, Status
from plant_bench.scoring.results import EpisodeResult
from plant_bench.text_escaping import one_line

FEW = 3  # infractions listed per episode
_console = Console(
    highlight=False, markup=False, emoji=False, width=None if sys.stdout.isatty() else PIPED_WIDTH
)


def worst_first(results: Sequence[EpisodeResult]) -> list[EpisodeResult]:
    """Return the episodes with infractions or a crash, the routes with the lowest DS first."""
    scores: dict[str, list[float]] = {}
    for item in results:
        scores.setdefault(item.route, []).append(item.driving_score)
    means = {route: float(np.mean(values)) for route, values in scores.items()}
    marred = [item for item in results if item.infractions or item.status is not Status.COMPLETED]
    return sorted(marred, key=lambda item: (means[item.route], item.route, item.repetition))


def print_infractions(results: Sequence[EpisodeResult], run: str) -> None:
    """Print a table of the infractions of a run."""
    marred = worst_first(results)
    count = sum(len(item.infractions) for item in results)
    episodes = f"{len(marred)} of {counted(len(results), 'episode')}"
    line = f"{counted(count, 'infraction')}. {episodes} have infractions or failed."
    _console.print(Text(line, style="bold"))
    if not marred:
        return
    table = Table(box=SIMPLE_HEAD, pad_edge=False)
    for head in ("route", "repetition", "DS", "infractions"):
        table.add_column(head, justify="right" if head in ("repetition", "DS") else "left")
    for item in marred:
        table.add_row(
            Text(one_line(item.route)),
            str(item.repetition),
            f"{item.driving_score:.1f}",
            Text(_infractions(item)),
        )
    _console.print(table)
    first = marred[0]
    _console.print(
        Text(f"To explain one: plant-bench why {run} {one_line(first.route)} ", end="")
        + Text(f"--repetition {first.repetition}")
    )


def _infractions(result: EpisodeResult) -> str:
    named = [_named(item) for item in result.infractions[:FEW]]
    more = len(result.infractions) - FEW
    named += [f"and {more} more"] * (more > 0)
    if not named or result.reason:
        named.append(f"{result.status.value}: {one_line(result.reason)}".strip(": "))
    return "; ".join(named)


def _named(item: Infraction) -> str:
    who = "" if item.actor is None else f" ({actor_name(item.actor, item.actor_kind)})"
    return f"{KIND_NAMES[item.kind]}{who} at {item.time:.1f} s"
