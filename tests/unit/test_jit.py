"""Cached machine code depends on its own source file alone."""

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
    """Return names from other modules, or derived from them, used in compiled functions."""
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


def test_names_from_other_modules_are_found() -> None:
    source = (
        "from plant_bench.x import A, B\nimport plant_bench.y as y\nC = 1\nD = 2 * A\n"
        "@compiled(F64)\ndef f(x):\n    return x + A + C + D + y.E\ndef g(x):\n    return B\n"
    )
    assert foreign_names(source) == {"A", "D", "y"}


def test_compiled_functions_use_no_names_from_other_modules() -> None:
    """Numba would not detect a change there and would use stale code."""
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


def test_compiled_code_is_cached(source: Path) -> None:
    assert not load(source).stats.cache_hits
    assert load(source).stats.cache_hits


@pytest.mark.parametrize("suffix", [".nbi", ".nbc"])
@pytest.mark.parametrize("harm", [lambda path: path.write_bytes(b"\x80"), Path.unlink])
def test_broken_cache_is_recompiled(source: Path, suffix: str, harm) -> None:
    load(source)
    for path in kept_by(source):
        if path.suffix == suffix:
            harm(path)
    assert load(source)(np.arange(3.0)) == 2.0
    load(source)
    assert load(source).stats.cache_hits


def test_changed_source_of_equal_time_and_size_is_recompiled(source: Path) -> None:
    load(source)
    data = {path: path.read_bytes() for path in kept_by(source) if path.suffix == ".nbc"}
    then = source.stat().st_mtime_ns
    source.write_text(SOURCE.replace("2.0", "3.0"))
    os.utime(source, ns=(then, then))
    assert load(source)(np.arange(3.0)) == 3.0
    assert not [path for path in data if path.exists()]


def test_functions_compile_without_a_writable_cache(
    source: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(room.os, "access", lambda *_: False)
    assert load(source)(np.arange(3.0)) == 2.0
    assert kept_by(source) == []


def test_read_only_installation_caches_in_the_user_cache_folder(
    source: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (source.parent / "__pycache__").write_text("no folder")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "home"))
    load(source)
    assert load(source).stats.cache_hits
    assert list((tmp_path / "home").rglob("*.nbc"))


def test_index_out_of_bounds_raises_an_error(source: Path) -> None:
    with pytest.raises(IndexError):
        load(source)(np.arange(1.0))


@pytest.mark.parametrize(("person", "kept"), [(True, False), (True, True), (False, False)])
def test_compiling_is_announced_once_on_a_terminal(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture, person: bool, kept: bool
) -> None:
    monkeypatch.setattr(room.sys.stderr, "isatty", lambda: person, raising=False)
    found = partial(len)
    found.__dict__["stats"] = SimpleNamespace(cache_hits={"found": 1} if kept else {})
    monkeypatch.setattr(room, "njit", lambda *_, **__: lambda function: found)
    room._log_once.cache_clear()

    for _ in range(2):
        assert compiled(F64_1D)(load) is found

    assert len(caplog.records) == (person and not kept)
