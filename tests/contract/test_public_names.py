"""The public names of the package: removing one is a breaking change."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

import plant_bench

DOCS = Path(__file__).parents[2] / "docs" / "python.md"
HEAVY = {"numpy", "pandas", "torch", "libsumo", "numba", "matplotlib", "pydantic", "cloudpickle"}
CALLED = ("check_agent", "collect", "drive", "load_run", "load_suite", "rfds", "score", "train")


def test_public_names_match_the_documentation() -> None:
    described = re.findall(r"^### `(\w+)", DOCS.read_text(encoding="utf-8"), re.MULTILINE)

    assert sorted(described) == plant_bench.__all__
    assert plant_bench.__all__ == sorted(plant_bench.__all__)
    assert len(plant_bench.__all__) == 21


@pytest.mark.parametrize("name", plant_bench.__all__)
def test_public_names_exist_and_have_a_docstring(name: str) -> None:
    found = getattr(plant_bench, name)

    assert name in dir(plant_bench)
    assert isinstance(found, str) or found.__doc__


@pytest.mark.parametrize("name", CALLED)
def test_public_functions_document_every_argument(name: str) -> None:
    function = getattr(plant_bench, name)
    told = re.findall(r"^ {8}(\w+): ", function.__doc__ or "", re.MULTILINE)

    if len(function.__annotations__) > 2:  # of one argument the first line tells
        assert set(function.__annotations__) - {"return"} <= set(told)


def test_public_names_are_imported_lazily() -> None:
    code = (
        "import sys, plant_bench\n"
        "dir(plant_bench), plant_bench.__version__, plant_bench.InputError\n"
        f"sys.exit(', '.join({HEAVY!r} & sys.modules.keys()))"
    )

    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)

    assert done.stderr.strip() == ""


def test_unknown_public_name_raises_attribute_error() -> None:
    with pytest.raises(AttributeError, match="no attribute 'skore'"):
        _ = plant_bench.skore  # pyright: ignore[reportAttributeAccessIssue]
