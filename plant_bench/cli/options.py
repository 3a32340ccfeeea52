"""Options that several commands have, with one meaning and one help text, and what they mean."""

import os
from enum import StrEnum
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from plant_bench.errors import InputError
from plant_bench.runner.workers.executors import Executor

if TYPE_CHECKING:
    from plant_bench.runner.workers.isolation import Isolation


def _cores() -> int:
    """Return how many cores this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


CORES = _cores()
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


class Where(StrEnum):
    """Who drives the episodes of a run."""

    LOCAL = "local"
    RAY = "ray"


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


def chosen_executor(where: Where, address: str | None, workers: int | None) -> Executor | None:
    """Return who drives elsewhere; None for processes of this machine.

    Raises:
        InputError: Ray is wanted and not installed, or the options contradict each other.
    """
    if where is Where.LOCAL:
        if address is not None:
            message = "--address is of a Ray cluster: give --executor ray with it."
            raise InputError(message)
        return None
    if find_spec("ray") is None:
        message = "Ray is not installed. Install it with: pip install 'plant-bench[ray]'"
        raise InputError(message)
    from plant_bench.runner.ray.executor import RayExecutor

    return RayExecutor(address or "auto", workers, lambda line: typer.echo(line, err=True))


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


def isolation_for(
    agent: str,
    *,
    isolate: bool,
    tick: float | None,
    start_up: float | None,
    memory: float | None,
) -> "Isolation | None":
    """Return how the planner is to be kept apart; None where it is loaded by the workers.

    Raises:
        InputError: A limit is given without `--isolate`, or the planner does not start.
    """
    from plant_bench.agents.loading.spec import is_command

    given = {"tick": tick, "start_up": start_up, "memory": memory}
    limits = {name: value for name, value in given.items() if value is not None}
    if not isolate and not is_command(agent):
        if limits:
            option = f"--{next(iter(limits)).replace('_', '-')}-limit"
            message = f"{option} limits a planner in a process of its own: give --isolate, too."
            raise InputError(message)
        return None
    from plant_bench.agents.remote.process import Limits
    from plant_bench.runner.workers.isolation import isolation_of

    return isolation_of(agent, Limits(**limits))


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
