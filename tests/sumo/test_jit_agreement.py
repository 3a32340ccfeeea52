"""Compiled functions give the results of plain Python on inputs from real episodes."""

import importlib
import pkgutil
import random
from collections.abc import Callable, Iterator
from types import ModuleType
from typing import Any

import numpy as np
import pytest
from numba.core.dispatcher import Dispatcher

import plant_bench.agents
import plant_bench.features
from plant_bench.runner.episode.jobs import Job
from plant_bench.runner.episode.loop import run_episode
from plant_bench.scoring.infractions import Status
from plant_bench.world.route import Route

pytestmark = pytest.mark.sumo

SAMPLED = 0.1  # of all calls
MOST = 60


def modules() -> Iterator[ModuleType]:
    for package in (plant_bench.agents, plant_bench.features):
        for found in pkgutil.iter_modules(package.__path__, f"{package.__name__}."):
            if not found.ispkg:
                yield importlib.import_module(found.name)


class Held:
    """Calls the compiled function and, for some calls, the Python original too; mutable.

    An error in a planner ends its episode, so differences are collected instead of raised.
    """

    def __init__(self, function: Dispatcher) -> None:
        self._function, self._chance = function, random.Random(0)
        self.compared, self.differs = 0, False

    def __call__(self, *arguments: Any) -> Any:
        found = self._function(*arguments)
        if self.compared < MOST and self._chance.random() < SAMPLED:
            self.compared += 1
            self.differs |= not same(found, self._function.py_func(*arguments))
        return found


def same(found: Any, wanted: Any) -> bool:
    if isinstance(found, tuple):
        return all(same(one, other) for one, other in zip(found, wanted, strict=True))
    if isinstance(found, np.ndarray):
        return found.dtype == wanted.dtype and found.tobytes() == wanted.tobytes()
    return found == wanted


def test_compiled_functions_equal_plain_python_bit_for_bit(
    monkeypatch: pytest.MonkeyPatch, beginning: Callable[[int], Route]
) -> None:
    held: dict[Dispatcher, Held] = {}
    for module in modules():
        for name, item in list(vars(module).items()):
            if isinstance(item, Dispatcher):
                monkeypatch.setattr(module, name, held.setdefault(item, Held(item)))
    for agent in ("expert", "plant"):
        episode = run_episode(Job(agent, "", beginning(250), 0, 5, "dense", hazards=False))
        assert episode.result.status is Status.COMPLETED
    names = {item.py_func.__name__: function for item, function in held.items()}
    assert [name for name, function in names.items() if function.differs] == []
    assert [name for name, function in names.items() if not function.compared] == []
