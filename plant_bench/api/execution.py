"""Who drives a run's episodes, and in which process its planner lives."""

import os
from collections.abc import Callable, Mapping
from enum import StrEnum
from importlib.util import find_spec
from typing import TYPE_CHECKING

from plant_bench.errors import InputError

if TYPE_CHECKING:  # commands come here before their workers begin: what is slow to load waits
    from plant_bench.runner.workers.executors import Executor
    from plant_bench.runner.workers.isolation import Isolation


class Where(StrEnum):
    """Who drives the episodes of a run."""

    LOCAL = "local"
    RAY = "ray"


def cores() -> int:
    """Return how many cores this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def chosen_executor(
    where: str, address: str | None, workers: int | None, say: Callable[[str], None] = print
) -> "Executor | None":
    """Return who drives elsewhere; None for processes of this machine.

    Args:
        where: A value of `Where`.
        address: Of the Ray cluster; None for the one that this machine is part of.
        workers: The most that work at a time; None for one on each CPU of the cluster.
        say: Told in one line what the user should know of the cluster's nodes.

    Raises:
        InputError: Ray is wanted and not installed, or the arguments contradict each other.
    """
    if where not in list(Where):
        message = f"executor: expected '{Where.LOCAL}' or '{Where.RAY}', got '{where}'."
        raise InputError(message)
    if where == Where.LOCAL:
        if address is not None:
            message = "--address is of a Ray cluster: choose the executor 'ray' with it."
            raise InputError(message)
        return None
    if find_spec("ray") is None:
        message = "Ray is not installed. Install it with: pip install 'plant-bench[ray]'"
        raise InputError(message)
    from plant_bench.runner.ray.executor import RayExecutor

    return RayExecutor(address or "auto", workers, say)


def isolation_for(
    spec: str, *, isolate: bool, limits: Mapping[str, float | None] | None = None
) -> "Isolation | None":
    """Return how a planner is kept in a process of its own; None where the workers load it.

    Args:
        spec: Names the planner; one that is a command is always kept apart.
        isolate: Whether it is wanted for others.
        limits: Of `Limits`, by name; None for what it has without.

    Raises:
        InputError: A limit is given for a planner that the workers load, or it does not start.
    """
    from plant_bench.agents.loading.spec import is_command

    given = {name: value for name, value in (limits or {}).items() if value is not None}
    if not isolate and not is_command(spec):
        if given:
            option = f"--{next(iter(given)).replace('_', '-')}-limit"
            message = f"{option} limits a planner in a process of its own: give --isolate, too."
            raise InputError(message)
        return None
    from plant_bench.agents.remote.process import Limits
    from plant_bench.runner.workers.isolation import isolation_of

    return isolation_of(spec, Limits(**given))
