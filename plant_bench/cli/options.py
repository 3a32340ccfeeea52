"""Options that several commands have, with one meaning and one help text."""

import os
from typing import Annotated

import typer

from plant_bench.cli.runs import LAW_HELP


def _cores() -> int:
    """Return how many cores this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


CORES = _cores()
EXIT_INTERRUPTED = 130  # as a shell reports Ctrl-C

SuiteOption = Annotated[str, typer.Option(help="A suite's name, or a folder or file of routes.")]
RoutesOption = Annotated[
    str | None,
    typer.Option(help="Numbers, ranges and ids, as in 0,3-5,town02-1; all without it."),
]
RepetitionsOption = Annotated[int, typer.Option(help="Episodes on each route.", min=1)]
DensityOption = Annotated[str, typer.Option(help="Of the traffic.")]
WorkersOption = Annotated[int, typer.Option(help="Processes; scores do not depend on it.", min=1)]
OverwriteOption = Annotated[bool, typer.Option("--overwrite", help="Run again what is finished.")]
LawOption = Annotated[str, typer.Option(help=LAW_HELP)]
