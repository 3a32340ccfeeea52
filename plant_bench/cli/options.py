"""Command-line options shared by several commands, with their help texts; exit codes."""

from pathlib import Path
from typing import Annotated

import typer

from plant_bench.api.execution import ExecutorKind, cores
from plant_bench.api.numbers import MOST_PROCESSES, MOST_REPETITIONS
from plant_bench.cli.number_options import number_option
from plant_bench.errors import InputError
from plant_bench.sim.densities import DENSITIES

CORES = cores()
EXIT_FAILED = 1
EXIT_INPUT = 2
EXIT_INTERRUPTED = 130  # as a shell reports Ctrl-C

SuiteOption = Annotated[
    str, typer.Option(help="Route suite: its name, or a folder or file of routes.")
]
RoutesOption = Annotated[
    str | None,
    typer.Option(
        help="Routes of the suite: numbers, ranges and ids, e.g. 0,3-5,town02-1. Default: all."
    ),
]
HazardsOption = Annotated[
    bool,
    typer.Option(
        help="Enable the routes' hazards. Scores without hazards belong to another protocol and "
        "are not comparable."
    ),
]
RepetitionsOption = Annotated[int, number_option("Episodes per route.", 1, MOST_REPETITIONS)]
DensityOption = Annotated[str, typer.Option(help=f"Traffic density: {', '.join(DENSITIES)}.")]
WorkersOption = Annotated[
    int, number_option("Number of processes; does not change the results.", 1, MOST_PROCESSES)
]
OverwriteOption = Annotated[
    bool, typer.Option("--overwrite", help="Replace existing results instead of keeping them.")
]
PenaltiesOption = Annotated[
    str,
    typer.Option(
        help="Penalty scheme that turns infractions into scores: lb1.0 (CARLA leaderboard 1.0, as "
        "in Longest6) or lb2.1. It changes the scores shown, not the records."
    ),
]


GuiOption = Annotated[
    bool,
    typer.Option("--gui", help="Watch the episodes live in sumo-gui, one at a time."),
]
GuiSpeedOption = Annotated[
    float,
    number_option("With --gui: multiple of real time, at most.", 0.1, 100.0),
]
ExecutorOption = Annotated[
    ExecutorKind,
    typer.Option("--executor", help="Where to drive: processes on this machine, or a Ray cluster."),
]
AddressOption = Annotated[
    str | None,
    typer.Option(help="Address of the Ray cluster: auto (default), HOST:6379 or ray://HOST:10001."),
]
ManyWorkersOption = Annotated[
    int | None,
    number_option(
        f"Number of processes; does not change scores. Default: one per core ({CORES} here), "
        "on a Ray cluster one per CPU.",
        1,
        MOST_PROCESSES,
    ),
]


IsolateOption = Annotated[
    bool,
    typer.Option(
        "--isolate",
        help="Run the planner in a separate process: if it hangs, leaks memory or crashes, only "
        "its own episode fails. This is not a security sandbox.",
    ),
]
_LIMITS_RANGE = (1e-3, 999_999.0)  # seconds or GB
TickLimitOption = Annotated[
    float | None,
    number_option(
        "With --isolate: time limit of one decision, seconds. Default: 5.", *_LIMITS_RANGE
    ),
]
StartUpLimitOption = Annotated[
    float | None,
    number_option(
        "With --isolate: time limit of the start and of each reset, seconds. Default: 120.",
        *_LIMITS_RANGE,
    ),
]
MemoryLimitOption = Annotated[
    float | None,
    number_option(
        "With --isolate: memory limit of the planner's processes together, GB. Default: 4.",
        *_LIMITS_RANGE,
    ),
]


def print_note(line: str) -> None:
    """Print a note for the user to standard error."""
    typer.echo(line, err=True)


def check_build_options(seed: int | None, out: Path | None, *, check: bool) -> None:
    """Check the options of `towns build` and `routes build`; keep the built-in files as they are.

    Raises:
        InputError: The options contradict each other.
    """
    if check and (seed is not None or out is not None):
        message = "--check cannot be combined with --seed or --out: it checks the existing files."
        raise InputError(message)
    if seed is not None and out is None:
        message = "--seed requires --out: another seed must not replace the benchmark's own files."
        raise InputError(message)
