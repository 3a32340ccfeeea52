"""Fingerprints: equal for equal code in every process, different for any change in driving."""

import json
import os
import subprocess
import sys
from typing import Any

import numpy as np
import pytest

from plant_bench.api.fingerprint import fingerprint

CELLS = """
import enum
from dataclasses import dataclass, field
import numpy as np
from plant_bench.agent import Control, Input

GAP = 8.0
WEIGHTS = np.arange(3.0)

class Mood(enum.Enum):
    CALM = 1

@dataclass
class Memory:
    seen: dict = field(default_factory=dict)

def room(ego):
    return GAP - ego.speed

class Base:
    inputs = frozenset({Input.ROUTE, Input.OBJECTS, Input.LIGHT})
    interval = 2

class Mine(Base):
    '''Says what it is.'''

    def __init__(self, most=2.0):
        self.most, self.mood, self.memory = most, Mood.CALM, Memory({'a': {'x', 'y', 'z'}})

    def reset(self, route):
        self.memory = Memory()

    @property
    def least(self):
        return -self.most

    def act(self, observation):  # decides
        pick = [value for value in WEIGHTS if value > 0]
        return Control(min(self.most, room(observation.ego)) + sum(pick), 0.0)
"""
CHANGES = [
    ("GAP = 8.0", "GAP = 9.0"),
    ("np.arange(3.0)", "np.arange(4.0)"),
    ("GAP - ego.speed", "GAP + ego.speed"),
    ("interval = 2", "interval = 1"),
    ("value > 0", "value > 1"),
    ("return -self.most", "return -2.0 * self.most"),
    ("{'x', 'y', 'z'}", "{'x', 'y', 'w'}"),
    ("CALM = 1", "CALM = 2"),
    ("def __init__(self, most=2.0)", "def __init__(self, most=3.0)"),
    ("Input.LIGHT})", "})"),
]
SAME = [
    ("  # decides", "  # decides\n        # at last"),
    ("GAP = 8.0", "\n\nOTHER = 1\nGAP = 8.0"),
    ("'''Says what it is.'''", "'''Says it otherwise.'''"),
]


def run(cells: str) -> dict[str, Any]:
    """Run code as a notebook does, in a module `__main__` without a file."""
    names: dict[str, Any] = {"__name__": "__main__"}
    exec(cells, names)  # noqa: S102
    return names


def marks(cells: str) -> tuple[str, str]:
    mine = run(cells)["Mine"]
    return fingerprint(mine), fingerprint(mine())


@pytest.mark.parametrize(("old", "new"), CHANGES)
def test_fingerprint_changes_with_anything_that_affects_driving(old: str, new: str) -> None:
    assert old in CELLS
    before, after = marks(CELLS), marks(CELLS.replace(old, new))

    assert before[1] != after[1]
    assert before[0] != after[0]


@pytest.mark.parametrize(("old", "new"), SAME)
def test_fingerprint_ignores_what_does_not_affect_driving(old: str, new: str) -> None:
    assert marks(CELLS) == marks(CELLS.replace(old, new))


@pytest.mark.parametrize("seed", ["1", "2"])
def test_fingerprint_is_equal_in_every_process(seed: str) -> None:
    code = (
        "import json, sys\nfrom plant_bench.api.fingerprint import fingerprint\n"
        f"exec({CELLS!r})\nprint(json.dumps([fingerprint(Mine), fingerprint(Mine())]))"
    )
    done = subprocess.run(
        [sys.executable, "-c", code],
        env=os.environ | {"PYTHONHASHSEED": seed},
        capture_output=True,
        text=True,
        check=True,
    )

    assert tuple(json.loads(done.stdout)) == marks(CELLS)


def test_self_referencing_values_have_a_fingerprint() -> None:
    ring: list[object] = [1]
    ring.append(ring)

    assert fingerprint(ring) == fingerprint(ring) != fingerprint([1, [1]])


def test_arrays_of_different_types_have_different_fingerprints() -> None:
    kinds = [np.zeros(2), np.zeros(2, np.float32), np.zeros((1, 2)), np.float64(0.0)]

    assert len(set(map(fingerprint, kinds))) == len(kinds)


def test_fingerprint_of_weights_depends_on_their_values() -> None:
    import torch

    one = torch.nn.Linear(2, 3)
    other = torch.nn.Linear(2, 3)
    other.load_state_dict(one.state_dict())
    assert fingerprint(one) == fingerprint(other)

    with torch.no_grad():
        other.weight[0, 0] += 1.0
    assert fingerprint(one) != fingerprint(other)
    assert fingerprint(one) != fingerprint(one.to(torch.bfloat16))


def test_fingerprint_of_compiled_functions_depends_on_their_code() -> None:
    cells = "import numba\n@numba.njit\ndef f(x): return x + 1"

    assert fingerprint(run(cells)["f"]) == fingerprint(run(cells)["f"])
    assert fingerprint(run(cells)["f"]) != fingerprint(run(cells.replace("1", "2"))["f"])
