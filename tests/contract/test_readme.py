"""The README's commands exist, work, and are the ones that CI runs."""

import re
import shlex
import subprocess
import tomllib
from pathlib import Path

import pytest
from typer.testing import CliRunner

from plant_bench.cli import app

ROOT = Path(__file__).parents[2]
README = (ROOT / "README.md").read_text(encoding="utf-8")


def commands(marker: str) -> list[str]:
    found = re.search(rf"<!-- {marker} -->\n```bash\n(.*?)```\n<!-- end -->", README, re.DOTALL)
    return found[1].splitlines() if found else []


@pytest.mark.parametrize("marker", ["main command", "test command"])
def test_readme_commands_are_one_line_that_installs_and_runs(marker):
    (command,) = commands(marker)

    assert command.startswith("python3 -m venv .venv && .venv/bin/pip install -c constraints.txt ")


def test_ci_takes_the_test_command_from_the_readme():
    script = (ROOT / ".ci" / "run").read_text(encoding="utf-8")
    extract = next(line for line in script.splitlines() if line.startswith("command="))

    done = subprocess.run(
        ["bash", "-c", f'{extract}; echo "$command"'],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=True,
    )

    assert done.stdout.splitlines() == commands("test command")


def test_score_commands_in_the_readme_parse():
    lines = [shlex.split(line) for line in commands("main command") + commands("run: commands")]
    words = [line[line.index("score") if "score" in line else 0 :] for line in lines]

    for arguments in words:
        done = CliRunner().invoke(app, [*arguments, "--help"])
        assert done.exit_code == 0, done.output


def test_every_dependency_has_a_pinned_version():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    extras = [name for part in project["optional-dependencies"].values() for name in part]
    wanted = [
        name for name in project["dependencies"] + extras if not name.startswith("plant-bench[")
    ]
    lines = (ROOT / "constraints.txt").read_text(encoding="utf-8").splitlines()
    pinned = {_plain(line.partition("==")[0]) for line in lines if "==" in line}

    assert [name for name in wanted if _plain(re.split(r"[\[<>=]", name)[0]) not in pinned] == []


def _plain(name: str) -> str:
    return name.strip().lower().replace("_", "-")
