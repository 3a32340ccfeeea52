"""Where a run's episodes are driven: the options for it, and what they mean."""

from enum import StrEnum
from importlib.util import find_spec
from typing import Annotated

import typer

from plant_bench.cli.options import CORES
from plant_bench.errors import InputError
from plant_bench.runner.workers.executors import Executor


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
