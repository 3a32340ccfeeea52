"""Ensures one simulation per process: libsumo would silently replace a running one.

An environment owns the simulation while its episode is running.
"""

import os
import weakref
from typing import Protocol, runtime_checkable

from plant_bench.errors import InputError

ADVICE = (
    "SUMO runs one simulation per process: close() the other environment first, or run each "
    "environment in its own process with gymnasium.make_vec(..., vectorization_mode='async') or "
    "stable-baselines3's SubprocVecEnv."
)


@runtime_checkable
class SimulationOwner(Protocol):
    """An environment that can own the simulation."""

    @property
    def under_way(self) -> bool:
        """Whether an episode is running and has made at least one step."""
        ...

    def leave(self) -> None:
        """End the simulation, if there is one."""
        ...


_owner: tuple[int, weakref.ref[SimulationOwner]] | None = None  # process id and owner


def acquire_simulation(owner: SimulationOwner) -> None:
    """Make an environment the owner; end another one's episode if it has not made a step.

    Raises:
        InputError: Another environment's episode is running in this process.
    """
    global _owner
    other = _owner[1]() if _owner is not None and _owner[0] == os.getpid() else None
    if other is not None and other is not owner:
        if other.under_way:
            message = f"Another environment's episode is running in this process. {ADVICE}"
            raise InputError(message)
        other.leave()
    _owner = os.getpid(), weakref.ref(owner)
