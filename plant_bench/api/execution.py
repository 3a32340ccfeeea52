"""Chooses where episodes are driven (local or Ray) and whether the planner is isolated."""

import os
from collections.abc import Callable, Mapping
from enum import StrEnum
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING

from plant_bench.errors import InputError

if TYPE_CHECKING:  # this module is imported before the workers start: defer heavy imports
    from plant_bench.runner.workers.executors import Executor
    from plant_bench.runner.workers.isolation import Isolation


class ExecutorKind(StrEnum):
    """Where the episodes of a run are driven."""

    LOCAL = "local"
    RAY = "ray"


def cores() -> int:
    """Return the number of CPU cores that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def chosen_executor(
    where: str, address: str | None, workers: int | None, say: Callable[[str], None] = print
) -> "Executor | None":
    """Return a Ray executor; None for processes on this machine.

    Args:
        where: A value of `ExecutorKind`.
        address: Address of the Ray cluster; None for the cluster that this machine is part of.
        workers: Maximum number of workers; None for one per CPU of the cluster.
        say: Called with one-line notes for the user about the cluster's nodes.

    Raises:
        InputError: Ray is requested but not installed, or the arguments contradict each other.
    """
    if where not in list(ExecutorKind):
        message = (
            f"executor: expected '{ExecutorKind.LOCAL}' or '{ExecutorKind.RAY}', got '{where}'."
        )
        raise InputError(message)
    if where == ExecutorKind.LOCAL:
        if address is not None:
            message = "--address requires --executor ray, because it is the address of a cluster."
            raise InputError(message)
        return None
    if find_spec("ray") is None:
        message = (
            "Ray is not installed. Install it with: pip install '.[ray]' in a checkout of "
            "plant-bench."
        )
        raise InputError(message)
    from plant_bench.runner.ray.executor import RayExecutor

    return RayExecutor(address or "auto", workers, say)


def isolation_for(
    spec: str,
    *,
    isolate: bool,
    limits: Mapping[str, float | None] | None = None,
    log: Path | None = None,
) -> "Isolation | None":
    """Return the isolation of a planner; None if the workers load it themselves.

    Args:
        spec: Name of the planner; a "command:" planner is always isolated.
        isolate: Whether to isolate any other planner.
        limits: Values of `Limits` by field name; None for a field's default.
        log: File for the traceback if the planner's code fails; None to drop it.

    Raises:
        InputError: A limit is set for a planner that is not isolated, or the planner does not
            start.
    """
    from plant_bench.agents.loading.planner_spec import is_command

    chosen = {name: value for name, value in (limits or {}).items() if value is not None}
    if not isolate and not is_command(spec):
        if chosen:
            option = f"--{next(iter(chosen)).replace('_', '-')}-limit"
            message = f"{option} requires --isolate: it limits a planner in a separate process."
            raise InputError(message)
        return None
    from plant_bench.agents.remote.process import Limits
    from plant_bench.runner.workers.isolation import isolation_of

    return isolation_of(spec, Limits(**chosen), log)
