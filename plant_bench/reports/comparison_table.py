"""Prints the comparison of two runs: the difference in DS, its verdict, and the routes."""

import math
from collections import Counter
from collections.abc import Sequence

from rich.box import SIMPLE_HEAD
from rich.table import Table
from rich.text import Text

from plant_bench.reports.tables import console, counted
from plant_bench.reports.why.incidents import KIND_NAMES
from plant_bench.scoring.comparison import (
    LEAST_ROUTES,
    LEVEL,
    PairedDifference,
    RouteDifference,
    Verdict,
)
from plant_bench.scoring.infractions import Status
from plant_bench.scoring.penalties import PenaltyScheme
from plant_bench.scoring.results import EpisodeResult
from plant_bench.text_escaping import one_line


def print_difference(
    difference: PairedDifference,
    first: str,
    second: str,
    *,
    penalties: PenaltyScheme = PenaltyScheme.LB1_0,
    routes: int | None = None,
) -> None:
    """Print the difference in DS of two runs.

    Args:
        difference: Second run minus first run.
        first: Name of the first run.
        second: Name of the second run.
        penalties: The penalty scheme.
        routes: Number of routes to list, those with the largest differences first; None for all.
    """
    known = math.isfinite(difference.low)
    interval = f", 95 % confidence interval {difference.low:+.2f} to {difference.high:+.2f}"
    console.print(
        f"{second} minus {first}: DS (penalties {penalties}) {difference.mean:+.2f}"
        f"{interval * known} ({counted(difference.pairs, 'pair')} of episodes on "
        f"{counted(difference.routes, 'route')})"
    )
    if known:
        console.print(f"Sign-flip test over routes: p = {difference.p_value:.4f}")
        console.print(
            f"These pairs can detect differences of {difference.detectable:.1f} DS or more."
        )
    if difference.unmatched_a or difference.unmatched_b:
        console.print(
            f"Not paired: {counted(difference.unmatched_a, 'episode')} of {first}, "
            f"{difference.unmatched_b} of {second}"
        )
    console.print(verdict_text(difference))
    _print_routes(difference.by_route, routes)


def verdict_text(difference: PairedDifference) -> str:
    """Return the verdict on a difference as a sentence."""
    verdict = difference.verdict
    if verdict is Verdict.TOO_FEW_ROUTES:
        return f"Too few routes for a confidence interval: expected at least {LEAST_ROUTES}."
    small = f"p is at most {LEVEL:g}"
    if verdict is Verdict.BETTER:
        return f"Better: {small}, and the interval is above zero."
    if verdict is Verdict.WORSE:
        return f"Worse: {small}, and the interval is below zero."
    reasons = []
    if difference.p_value > LEVEL:
        reasons.append(f"p is above {LEVEL:g}")
    if difference.low <= 0.0 <= difference.high:
        reasons.append("the interval contains zero")
    return f"No significant difference: {' and '.join(reasons)}."


def _print_routes(routes: Sequence[RouteDifference], count: int | None) -> None:
    """Print the routes on which the runs differ, the largest difference first."""
    differing = [
        item
        for item in routes
        if item.difference or _events(item.first_episodes) != _events(item.second_episodes)
    ]
    shown = differing[:count]
    if not shown:
        if not differing:
            console.print("On every route, both have the same score and the same infractions.")
        return
    table = Table(title="Largest differences", title_justify="left", box=SIMPLE_HEAD)
    for head in ("route", "DS, first", "DS, second", "difference"):
        table.add_column(head, justify="left" if head == "route" else "right", no_wrap=True)
    for head in ("what happened, first", "what happened, second"):
        table.add_column(head)
    for item in shown:
        table.add_row(
            Text(one_line(item.route)),
            f"{item.first:.1f}",
            f"{item.second:.1f}",
            f"{item.difference:+.1f}",
            Text(_events(item.first_episodes)),
            Text(_events(item.second_episodes)),
        )
    console.print(table)
    left, same = len(differing) - len(shown), len(routes) - len(differing)
    if left:
        console.print(f"and {counted(left, 'route')} with smaller differences (--all lists them)")
    if same:
        console.print(f"The same on {counted(same, 'route')}.")


def _events(episodes: Sequence[EpisodeResult]) -> str:
    """Return what happened in the episodes of a route, with counts above one."""
    counts = Counter(
        KIND_NAMES[infraction.kind] for item in episodes for infraction in item.infractions
    )
    crashed = (Status.AGENT_CRASHED, Status.SIMULATION_CRASHED)
    counts.update(item.status.value for item in episodes if item.status in crashed)
    events = [f"{count} x {name}" if count > 1 else name for name, count in counts.items()]
    return ", ".join(events) or "no infraction"
