"""Options that several commands have, with one meaning and one help text, and what they mean."""

from pathlib import Path
from typing import Annotated

import typer

from plant_bench.api.execution import Where, cores
from plant_bench.errors import InputError

CORES = cores()
EXIT_FAILED = 1
EXIT_INPUT = 2
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
LawOption = Annotated[
    str,
    typer.Option(
        help="Makes infractions a score: lb1.0, as Longest6, or lb2.1; records do not depend on it."
    ),
]


ExecutorOption = Annotated[
    Where, typer.Option("--executor", help="Processes of this machine, or a Ray cluster.")
]
AddressOption = Annotated[
    str | None,
    typer.Option(help="Of the Ray cluster: auto (without it), HOST:6379 or ray://HOST:10001."),
]
ManyWorkersOption = Annotated[
    int | None,
    typer.Option(
        help=f"Processes; scores do not depend on it. Without it {CORES} here (one a core), and "
        "on a Ray cluster one a CPU.",
        min=1,
    ),
]


IsolateOption = Annotated[
    bool,
    typer.Option(
        "--isolate",
        help="Run the planner in a process of its own, so that one that hangs, leaks or crashes "
        "costs its own episode. It is no security sandbox.",
    ),
]
TickLimitOption = Annotated[
    float | None, typer.Option(help="Seconds for one decision, with --isolate; 5 without it.")
]
StartUpLimitOption = Annotated[
    float | None,
    typer.Option(help="Seconds to start, and for each reset, with --isolate; 120 without it."),
]
MemoryLimitOption = Annotated[
    float | None,
    typer.Option(help="GB that all of the planner's processes may hold; 4 without it."),
]


def say_aside(line: str) -> None:
    """Print what the user should know beside a command's output, to standard error."""
    typer.echo(line, err=True)


def refuse_overwriting(seed: int | None, out: Path | None, *, check: bool) -> None:
    """Keep another seed's layout from replacing what the benchmark is made of.

    Raises:
        InputError: The options do not go together.
    """
    if check and (seed is not None or out is not None):
        message = "--check looks at what is there: it goes with neither --seed nor --out."
        raise InputError(message)
    if seed is not None and out is None:
        message = "--seed makes something new: say with --out where it is to go."
        raise InputError(message)
