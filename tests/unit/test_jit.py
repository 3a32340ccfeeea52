"""What is kept on the disk as machine code depends on its own file alone."""

import ast
import importlib.util
import linecache
import os
from functools import partial
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import plant_bench
from plant_bench import jit as room
from plant_bench.jit import F64_1D, compiled

PACKAGE = Path(plant_bench.__file__).parent


def is_compiled(function: ast.FunctionDef) -> bool:
    return any(
        isinstance(mark, ast.Call) and getattr(mark.func, "id", "") == "compiled"
        for mark in function.decorator_list
    )


def names_in(node: ast.AST) -> set[str]:
    return {name.id for name in ast.walk(node) if isinstance(name, ast.Name)}


def foreign_names(source: str) -> set[str]:
    """Names from other files of ours, and what is made of them, in compiled functions' bodies."""
    tree = ast.parse(source)
    ours: set[str] = set()
    for line in tree.body:
        if isinstance(line, ast.ImportFrom) and (line.module or "").startswith("plant_bench"):
            ours |= {alias.asname or alias.name for alias in line.names}
        elif isinstance(line, ast.Import):
            names = [alias for alias in line.names if alias.name.startswith("plant_bench")]
            ours |= {alias.asname or "plant_bench" for alias in names}
        elif isinstance(line, ast.Assign) and names_in(line.value) & ours:
            ours |= set().union(*map(names_in, line.targets))
    functions = [item for item in ast.walk(tree) if isinstance(item, ast.FunctionDef)]
    bodies = [line for item in functions if is_compiled(item) for line in item.body]
    return set().union(*map(names_in, bodies)) & ours


def test_foreign_names_are_found() -> None:
    source = (
        "from plant_bench.x import A, B\nimport plant_bench.y as y\nC = 1\nD = 2 * A\n"
        "@compiled(F64)\ndef f(x):\n    return x + A + C + D + y.E\ndef g(x):\n    return B\n"
    )
    assert foreign_names(source) == {"A", "D", "y"}


def test_compiled_functions_use_nothing_of_other_files() -> None:
    """Numba would not notice when it changes, and go on with what it has compiled."""
    files = [path for path in PACKAGE.rglob("*.py") if "@compiled" in path.read_text("utf-8")]
    assert len(files) > 5
    found = {
        path.name: names for path in files if (names := foreign_names(path.read_text("utf-8")))
    }
    assert found == {}


SOURCE = """
from plant_bench.jit import F64_1D, compiled

FACTOR = 2.0

@compiled(F64_1D)
def scaled(values):
    return FACTOR * values[1]
"""


@pytest.fixture
def source(tmp_path: Path) -> Path:
    path = tmp_path / "their_loops.py"
    path.write_text(SOURCE)
    return path


def load(source: Path) -> Any:
    """Execute a file as a new process would."""
    room._folder.cache_clear()
    linecache.clearcache()
    spec = importlib.util.spec_from_file_location("their_loops", source)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module.scaled


def kept_by(source: Path) -> list[Path]:
    return [path for path in source.parent.rglob("*.nb?") if path.is_file()]


def test_what_was_compiled_is_found_again(source: Path) -> None:
    assert not load(source).stats.cache_hits
    assert load(source).stats.cache_hits


@pytest.mark.parametrize("suffix", [".nbi", ".nbc"])
@pytest.mark.parametrize("harm", [lambda path: path.write_bytes(b"\x80"), Path.unlink])
def test_what_was_kept_and_broken_is_compiled_anew(source: Path, suffix: str, harm) -> None:
    load(source)
    for path in kept_by(source):
        if path.suffix == suffix:
            harm(path)
    assert load(source)(np.arange(3.0)) == 2.0
    load(source)
    assert load(source).stats.cache_hits


def test_another_content_is_compiled_anew_even_if_time_and_size_are_the_same(source: Path) -> None:
    load(source)
    data = {path: path.read_bytes() for path in kept_by(source) if path.suffix == ".nbc"}
    then = source.stat().st_mtime_ns
    source.write_text(SOURCE.replace("2.0", "3.0"))
    os.utime(source, ns=(then, then))
    assert load(source)(np.arange(3.0)) == 3.0
    assert not [path for path in data if path.exists()]


def test_where_nothing_can_be_kept_it_compiles_all_the_same(
    source: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(room.os, "access", lambda *_: False)
    assert load(source)(np.arange(3.0)) == 2.0
    assert kept_by(source) == []


def test_an_installation_that_must_not_be_written_to_keeps_elsewhere(
    source: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (source.parent / "__pycache__").write_text("no folder")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "home"))
    load(source)
    assert load(source).stats.cache_hits
    assert list((tmp_path / "home").rglob("*.nbc"))


def test_beyond_the_end_of_an_array_is_an_error(source: Path) -> None:
    with pytest.raises(IndexError):
        load(source)(np.arange(1.0))


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
        assert compiled(F64_1D)(load) is found

    assert len(caplog.records) == (person and not kept)
