"""The notebook in `examples/`: it runs from the first cell to the last in a new kernel."""

import json
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

EXAMPLES = Path(__file__).parents[2] / "examples"
NOTEBOOK = "quickstart.ipynb"
EXECUTE = """
import sys
import nbformat
from nbclient import NotebookClient

notebook = nbformat.read(sys.argv[1], as_version=4)
NotebookClient(notebook, timeout=280, kernel_name="python3").execute()
nbformat.write(notebook, sys.argv[1])
"""

pytestmark = pytest.mark.sumo


def cells(path: Path) -> list[dict[str, Any]]:
    notebook = json.loads(path.read_text(encoding="utf-8"))
    return [cell for cell in notebook["cells"] if cell["cell_type"] == "code"]


def said(cell: dict[str, Any]) -> str:
    """Return the text output of a cell."""
    parts = [output.get("text") or output["data"]["text/plain"] for output in cell["outputs"]]
    return "".join(line for part in parts for line in part)


def test_notebook_is_stored_without_outputs() -> None:
    found = cells(EXAMPLES / NOTEBOOK)

    assert 5 <= len(found) <= 8
    assert all(not cell["outputs"] and cell["execution_count"] is None for cell in found)


def test_notebook_runs_in_a_new_kernel(tmp_path: Path) -> None:
    for name in (NOTEBOOK, "short_route.json"):
        shutil.copy(EXAMPLES / name, tmp_path / name)

    done = subprocess.run(
        [sys.executable, "-c", EXECUTE, NOTEBOOK],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
    )

    assert done.returncode == 0, done.stderr
    _, score, table, compare, why, drive = map(said, cells(tmp_path / NOTEBOOK))
    assert "driving_score=" in score
    assert "short-0" in table
    assert "PairedDifference" in compare
    assert "scenes equal the recorded ones" in why
    assert "the ego ran into" in why
    assert "Completed" in drive
    assert len(list((tmp_path / "reports" / "planners").iterdir())) == 1
