"""The start of a command: modules loaded before its workers start, and by the workers."""

import subprocess
import sys
import tomllib
from pathlib import Path

PYPROJECT = Path(__file__).parents[3] / "pyproject.toml"

COMMAND = """
import gc, sys
from plant_bench.runner.workers import executors
from plant_bench.__main__ import main

def begin(*_):
    print(*sorted({"numpy", "pandas", "numba", "rich"} & sys.modules.keys()), gc.get_threshold()[0])
    raise SystemExit

executors.start_process = begin
sys.argv = ["plant-bench", "score", "--agent", "expert", "--routes", "0"]
main()
"""
WORKER = """
import sys, multiprocessing.spawn
multiprocessing.spawn._fixup_main_from_path(sys.argv[1])
print("typer" in sys.modules, sys.modules["__mp_main__"].{function}.__module__)
"""


def said(code: str, *words: str) -> str:
    done = subprocess.run(
        [sys.executable, "-c", code, *words], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    return done.stdout.strip()


def test_workers_start_before_the_command_loads_its_modules():
    assert said(COMMAND) == "100000"


def test_workers_do_not_import_the_command_line(tmp_path):
    """A spawned process runs the main script of its parent again."""
    scripts = tomllib.loads(PYPROJECT.read_text("utf-8"))["project"]["scripts"]
    module, _, function = scripts["plant-bench"].partition(":")
    script = tmp_path / "plant-bench"  # as pip writes it
    script.write_text(
        f"import sys\nfrom {module} import {function}\n"
        f"if __name__ == '__main__':\n    sys.exit({function}())\n"
    )

    assert said(WORKER.format(function=function), str(script)) == f"False {module}"
