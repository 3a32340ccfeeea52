"""Who has the process's one SUMO: libsumo starts a second simulation over the first without a word.

An environment keeps the seat while its episode goes on, and gives it up when that has ended.
"""

import os
import weakref
from typing import Protocol, runtime_checkable

from plant_bench.errors import InputError

ADVICE = (
    "SUMO runs one simulation a process: close() the other environment first, or use one process "
    "for each, with gymnasium.make_vec(..., vectorization_mode='async') or stable-baselines3's "
    "SubprocVecEnv."
)


@runtime_checkable
class SimulationOwner(Protocol):
    """Somebody with an episode."""

    @property
    def under_way(self) -> bool:
        """Whether an episode would be lost without the simulation: it goes on, and has moved."""
        ...

    def leave(self) -> None:
        """End the simulation, if there is one."""
        ...


_seated: tuple[int, weakref.ref[SimulationOwner]] | None = None  # and the process it was seated in


def take_seat(sitter: SimulationOwner) -> None:
    """Become the one who may start a simulation; who has one that has not moved is sent away.

    Raises:
        InputError: Another's episode is under way in this process.
    """
    global _seated
    other = _seated[1]() if _seated is not None and _seated[0] == os.getpid() else None
    if other is not None and other is not sitter:
        if other.under_way:
            message = f"Another environment's episode is under way in this process. {ADVICE}"
            raise InputError(message)
        other.leave()
    _seated = os.getpid(), weakref.ref(sitter)
