"""One cheap import registers the environment; without Gymnasium it says what to install."""

import importlib
import subprocess
import sys

import pytest

from plant_bench.errors import InputError


def test_registering_does_not_start_the_simulator() -> None:
    code = (
        "import sys, plant_bench.gym, gymnasium; "
        "print('PlantBench-v0' in gymnasium.registry, "
        "[name for name in ('libsumo', 'torch', 'pyarrow') if name in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.split(maxsplit=1) == ["True", "[]\n"]


def test_missing_gymnasium_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    importlib.import_module("plant_bench.gym")
    monkeypatch.setitem(sys.modules, "gymnasium", None)
    monkeypatch.delitem(sys.modules, "plant_bench.gym")
    with pytest.raises(InputError, match=r"pip install '\.\[gym\]'"):
        importlib.import_module("plant_bench.gym")
