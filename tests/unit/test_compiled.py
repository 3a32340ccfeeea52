"""What is kept on the disk as machine code depends on its own file alone."""

import ast
from functools import partial
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import plant_bench
from plant_bench import compiled as room
from plant_bench.compiled import REALS, compiled

PACKAGE = Path(plant_bench.__file__).parent


def is_compiled(function: ast.FunctionDef) -> bool:
    return any(
        isinstance(mark, ast.Call) and getattr(mark.func, "id", "") == "compiled"
        for mark in function.decorator_list
    )


def foreign_names(source: str) -> set[str]:
    """Names from other files of ours in the bodies of compiled functions."""
    tree = ast.parse(source)
    ours = {
        alias.asname or alias.name
        for line in ast.walk(tree)
        if isinstance(line, ast.ImportFrom) and (line.module or "").startswith("plant_bench")
        for alias in line.names
    }
    return {
        name.id
        for function in ast.walk(tree)
        if isinstance(function, ast.FunctionDef) and is_compiled(function)
        for line in function.body
        for name in ast.walk(line)
        if isinstance(name, ast.Name) and name.id in ours
    }


def test_foreign_names_are_found() -> None:
    source = (
        "from plant_bench.x import A, B\nC = 1\n"
        "@compiled(REAL)\ndef f(x):\n    return x + A + C\ndef g(x):\n    return B\n"
    )
    assert foreign_names(source) == {"A"}


def test_compiled_functions_use_nothing_of_other_files() -> None:
    """Numba would not notice when it changes, and go on with what it has compiled."""
    files = [path for path in PACKAGE.rglob("*.py") if "@compiled" in path.read_text("utf-8")]
    assert len(files) > 5
    found = {
        path.name: names for path in files if (names := foreign_names(path.read_text("utf-8")))
    }
    assert found == {}


def test_without_a_folder_to_keep_it_in_it_compiles_all_the_same(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    given = []
    njit = room.njit

    def without_folder(signature: tuple, *, cache: bool = False, **options: Any):
        given.append(cache)
        if cache:
            message = "cannot cache function 'total': no locator available"
            raise RuntimeError(message)
        return njit(signature, **options)

    monkeypatch.setattr(room, "njit", without_folder)

    @compiled(REALS)
    def total(values):
        found = 0.0
        for value in values:
            found += value
        return found

    assert given == [True, False]
    assert total(np.arange(4.0)) == 6.0


@pytest.mark.parametrize(("person", "kept"), [(True, False), (True, True), (False, False)])
def test_a_person_is_told_once_why_the_start_takes_longer(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture, person: bool, kept: bool
) -> None:
    monkeypatch.setattr(room.sys.stderr, "isatty", lambda: person, raising=False)
    found = partial(len)
    found.__dict__["stats"] = SimpleNamespace(cache_hits={"found": 1} if kept else {})
    monkeypatch.setattr(room, "njit", lambda *_, **__: lambda function: found)
    room._tell.cache_clear()

    for _ in range(2):
        assert compiled(REALS)(len) is found

    assert len(caplog.records) == (person and not kept)
