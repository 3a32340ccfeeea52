"""The names that users write in their own files: to take one away is a breaking change."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

import plant_bench

DOCS = Path(__file__).parents[2] / "docs" / "reference" / "python.md"
CONTRACTS = {"agent", "learner"}  # the modules that authors write against
HEAVY = {"numpy", "pandas", "torch", "libsumo", "numba", "matplotlib", "pydantic", "cloudpickle"}
CALLED = ("check_agent", "collect", "drive", "load_run", "load_suite", "rfds", "score", "train")


def test_the_public_names_are_those_that_the_docs_describe() -> None:
    text = DOCS.read_text(encoding="utf-8")
    described = re.findall(r"^::: plant_bench\.(\w+)$", text, re.MULTILINE)

    assert sorted({*described} - CONTRACTS) == plant_bench.__all__
    assert set(described) >= CONTRACTS
    assert plant_bench.__all__ == sorted(plant_bench.__all__)
    assert len(plant_bench.__all__) == 21


@pytest.mark.parametrize("name", plant_bench.__all__)
def test_a_public_name_is_there_and_says_what_it_is(name: str) -> None:
    found = getattr(plant_bench, name)

    assert name in dir(plant_bench)
    assert isinstance(found, str) or found.__doc__


@pytest.mark.parametrize("name", CALLED)
def test_what_is_called_describes_each_of_its_arguments(name: str) -> None:
    function = getattr(plant_bench, name)
    told = re.findall(r"^ {8}(\w+): ", function.__doc__ or "", re.MULTILINE)

    if len(function.__annotations__) > 2:  # of one argument the first line tells
        assert set(function.__annotations__) - {"return"} <= set(told)


def test_nothing_is_loaded_before_it_is_used() -> None:
    code = (
        "import sys, plant_bench\n"
        "dir(plant_bench), plant_bench.__version__, plant_bench.InputError\n"
        f"sys.exit(', '.join({HEAVY!r} & sys.modules.keys()))"
    )

    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)

    assert done.stderr.strip() == ""


def test_another_name_is_an_attribute_error() -> None:
    with pytest.raises(AttributeError, match="no attribute 'skore'"):
        _ = plant_bench.skore  # pyright: ignore[reportAttributeAccessIssue]
