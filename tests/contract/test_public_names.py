"""The public names of the package: removing one is a breaking change."""

import inspect
import re
import subprocess
import sys
from dataclasses import fields, is_dataclass
from pathlib import Path

import pytest

import plant_bench

DOCS = Path(__file__).parents[2] / "docs" / "reference" / "python.md"
CONTRACTS = {"agent", "learner"}  # the modules that authors write against
HEAVY = {"numpy", "pandas", "torch", "libsumo", "numba", "matplotlib", "pydantic", "cloudpickle"}
PARAMETERS = {  # of the public functions; those after the asterisk are given by name alone
    "check_agent": "agent route observations",
    "collect": "out * frames units seed perturb driver density workers on_event",
    "drive": "planner route * suite repetition seed density hazards",
    "frames": "data * inputs targets workers",
    "load_run": "path * penalties",
    "load_suite": "name",
    "rfds": (
        "planner * rankers suite routes repetitions seed density hazards workers out overwrite "
        "penalties on_event"
    ),
    "score": (
        "planner * suite routes repetitions seed density hazards workers out overwrite recordings "
        "penalties isolate executor address shard on_event"
    ),
    "train": ("learner data out * options settings share start machine work overwrite on_event"),
}
FIELDS = {  # of the public values
    "Control": "acceleration steering",
    "Observation": "time ego speed_limit actors route light privileged sensors",
    "Plan": "waypoints",
    "Scene": "tick ego actors lights",
    "Step": "scene observation action control reason infractions completion status",
}
MEMBERS = {  # what else of the public classes the docs name
    "Agent": "inputs reset act",
    "Input": "OBJECTS ROUTE LIGHT PRIVILEGED SIMULATOR",
    "Route": "id town points length hazards",
    "Run": "path penalties summary episodes results compare report why",
    "Scene": "time",
}
ERRORS = {"AgentError", "InputError", "PlantBenchError"}


def test_public_names_match_the_documentation() -> None:
    text = DOCS.read_text(encoding="utf-8")
    described = re.findall(r"^::: plant_bench\.(\w+)$", text, re.MULTILINE)

    assert sorted({*described} - CONTRACTS) == plant_bench.__all__
    assert set(described) >= CONTRACTS
    assert plant_bench.__all__ == sorted(plant_bench.__all__)
    assert len(plant_bench.__all__) == 22


@pytest.mark.parametrize("name", plant_bench.__all__)
def test_public_names_exist_and_have_a_docstring(name: str) -> None:
    found = getattr(plant_bench, name)

    assert name in dir(plant_bench)
    assert isinstance(found, str) or found.__doc__


def signature_of(function: object) -> str:
    """Return the names of a function's parameters, an asterisk before those given by name alone."""
    assert inspect.isfunction(function)
    names = []
    for parameter in inspect.signature(function).parameters.values():
        if parameter.kind is parameter.KEYWORD_ONLY and "*" not in names:
            names.append("*")
        names.append(parameter.name)
    return " ".join(names)


def test_every_public_name_is_in_a_table_of_this_test() -> None:
    tables = {*PARAMETERS, *FIELDS, *MEMBERS, *ERRORS, "__version__"}

    assert sorted(tables) == plant_bench.__all__


@pytest.mark.parametrize("name", PARAMETERS)
def test_a_public_function_has_these_parameters(name: str) -> None:
    assert signature_of(getattr(plant_bench, name)) == PARAMETERS[name]


@pytest.mark.parametrize("name", FIELDS)
def test_a_public_value_has_these_fields(name: str) -> None:
    found = getattr(plant_bench, name)

    assert is_dataclass(found)
    assert [item.name for item in fields(found)] == FIELDS[name].split()


@pytest.mark.parametrize("name", MEMBERS)
def test_a_public_class_has_these_members(name: str) -> None:
    found = getattr(plant_bench, name)
    known = {*dir(found), *getattr(found, "__annotations__", ())}

    assert inspect.isclass(found)
    assert set(MEMBERS[name].split()) - known == set()


def test_every_public_error_is_a_plant_bench_error() -> None:
    for name in ERRORS:
        assert issubclass(getattr(plant_bench, name), plant_bench.PlantBenchError)
    assert issubclass(plant_bench.PlantBenchError, Exception)


@pytest.mark.parametrize("name", PARAMETERS)
def test_public_functions_document_every_argument(name: str) -> None:
    function = getattr(plant_bench, name)
    told = re.findall(r"^ {8}(\w+): ", function.__doc__ or "", re.MULTILINE)
    parameters = list(inspect.signature(function).parameters)

    assert (function.__doc__ or "").strip()
    if len(parameters) > 1:  # of one argument the first line tells
        assert told[: len(parameters)] == parameters


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
