"""API functions neither print nor exit; only commands do."""

import ast
from pathlib import Path

import plant_bench.api

FILES = sorted(Path(plant_bench.api.__file__).parent.glob("*.py"))
LOUD = {"print", "exit", "quit", "input", "echo", "secho"}
COMMAND_LINE = {"typer", "click", "rich", "sys.exit"}


def test_api_neither_prints_nor_exits() -> None:
    found = []
    for file in FILES:
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Call):
                called = node.func
                name = called.attr if isinstance(called, ast.Attribute) else ast.unparse(called)
                found += [f"{file.name}: {name}"] if name in LOUD or "print_" in name else []
            elif isinstance(node, ast.Import | ast.ImportFrom):
                names = [getattr(node, "module", None) or "", *(item.name for item in node.names)]
                found += [f"{file.name}: {name}" for name in names if name in COMMAND_LINE]

    assert len(FILES) > 10
    assert found == []
