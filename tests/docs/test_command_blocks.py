"""Every block of commands in the README and in docs/ is parsed, and run where it can be run."""

import os
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
import typer
from typer.testing import CliRunner

from plant_bench.cli import app
from tests.docs.pages import DOCS, FENCE, PAGES, ROOT, Block, blocks_of, commands_in, page_name

STAND_FOR = {  # what a page leaves to its reader
    "my_package.learn:Mine": f"{ROOT}/tests/outside/pixels.py:PixelLearner",
}
NOT_RUN = {  # lines that match, and why they cannot run in a test
    r"^git clone\b": "downloads the repository",
    r"\bpip install\b": "installs packages; the test command of the README does that in CI",
    r"^pytest\b": "tests within tests; tests/contract has those of a new planner's project",
    r"^plant-bench score --agent my_(planner|package\S*|network)( |@|$)": "is not installed",
    r"^sbatch\b": "needs a Slurm cluster",
    r"^ray\b|--executor ray": "needs a Ray cluster; tests/end_to_end starts one",
    r"^python examples/train_ppo\.py": "trains for minutes; tests/end_to_end runs it",
    r"PPOAgent@ppo\.zip": "needs the trained policy; tests/end_to_end has a small one",
    r"^export NUMBA_CACHE_DIR": "is a folder of the reader's",
    r"\S+\.xodr|longest6\.xml|^for n in|^done": "needs CARLA's files, which are not ours to give",
    r"--suite carla/": "needs CARLA's files, which are not ours to give",
    r"\btheir_results\b": "needs result files of the reader's",
    r"\bmycity\b": "needs a map of the reader's; tutorials/your-map.md makes one",
    r"plant-1x|plant-dagger|models/(mine|paper)\b": "is the full training, of hours",
    r"^plant-bench ablate\b": "trains several networks; tests/unit/training has a small one",
    r"my_package\.": "is a package of the reader's",
    r"^python benchmarks/|^PYTHONPATH=benchmarks": "measures for minutes",
    r"machine-[12]|data/(expert|dagger-1x)": "is the full training, of hours",
}
MAY_FAIL = {  # lines that match may exit with 1
    r"^plant-bench compare\b": "the second run may be worse",
}
SMALLER = {  # in the lines that are run: sizes that take seconds
    r"--routes 0-5 (?=.*--shard)": "--routes town01-4,town01-5 ",
    r"--routes (0-5|5|0)\b": "--routes town01-5",
    r"--frames \d+": "--frames 300",
    r"--epochs \d+": "--epochs 1",
    r"--workers 8": "--workers 1",
    r"--sample 2": "--sample 1",
    r"((?<!re)(?:score|verify) (?!.*--repetitions).*)$": r"\1 --repetitions 1",
    r"(score --(?!.*--routes)(?!.*mytown).*)$": r"\1 --routes town01-5",
    r"--suite unseen --routes \S+": "--suite unseen --routes unseen01-5",
}
USAGE_ERROR: Any = typer.BadParameter.__base__
SECONDS = 1500  # of a page's blocks


def _line_of(block: Block, line: str) -> str:
    return f"{block.page}:{block.line}: {line}"


LINES = [
    pytest.param(arguments, id=f"{block.page}:{block.line}-{number}-{place}")
    for page in PAGES
    for block in blocks_of(page)
    for number, line in enumerate(block.lines)
    for place, arguments in enumerate(commands_in(line))
]
SPANS = sorted(
    {
        found[1]
        for page in PAGES
        for found in re.finditer(
            r"`plant-bench ([a-z][a-z-]*)", FENCE.sub("", page.read_text(encoding="utf-8"))
        )
    }
)


@pytest.mark.parametrize("arguments", LINES)
def test_each_command_parses(arguments: list[str]) -> None:
    words = [STAND_FOR.get(word, word) for word in arguments]
    parse(words)


@pytest.mark.parametrize(
    "words",
    [["score", "--agent", "plant", "--no-such"], ["no-such"], ["score"], ["data", "no-such", "x"]],
)
def test_what_does_not_parse_is_found(words: list[str]) -> None:
    with pytest.raises(USAGE_ERROR):
        parse(words)


@pytest.mark.parametrize("name", SPANS)
def test_each_command_that_text_names_exists(name: str) -> None:
    assert CliRunner().invoke(app, [name, "--help"]).exit_code == 0


def parse(words: list[str]) -> None:
    """Parse a command's arguments as the command line does, and run nothing."""
    command: Any = typer.main.get_command(app)
    context = None
    name = "plant-bench"
    rest = words
    try:
        while True:
            context = command.make_context(name, list(rest), parent=context)
            if not hasattr(command, "resolve_command"):
                return
            name, command, rest = command.resolve_command(context, _left(context))
    except typer.Exit:
        return  # --help, --version


def _left(context: Any) -> list[str]:
    return [*getattr(context, "_protected_args", []), *context.args]


def runnable(block: Block) -> list[str]:
    """Return the lines of a block that can run here, made smaller."""
    lines = [line for line in block.lines if not any(re.search(part, line) for part in NOT_RUN)]
    return [_smaller(line) for line in lines]


def _smaller(line: str) -> str:
    parts = re.split(r"(\s+(?:&&|\|\|)\s+)", re.sub(r"\s+#.*", "", line))
    for number, part in enumerate(parts):
        for pattern, size in SMALLER.items():
            part = re.sub(pattern, size, part)
        words = part.split(" ")
        parts[number] = " ".join(words)
    return "".join(parts)


RUN = [page for page in PAGES if any(runnable(block) for block in blocks_of(page))]


@pytest.mark.slow
@pytest.mark.sumo
@pytest.mark.timeout(SECONDS)
@pytest.mark.parametrize("page", RUN, ids=page_name)
def test_the_blocks_of_a_page_run_in_order(page: Path, tmp_path: Path) -> None:
    programs = tmp_path / "bin"
    programs.mkdir()
    for name, command in (("plant-bench", "-m plant_bench"), ("python", ""), ("python3", "")):
        script = programs / name
        script.write_text(f'#!/bin/sh\nexec {sys.executable} {command} "$@"\n', encoding="utf-8")
        script.chmod(0o755)
    folder = tmp_path / "work"
    folder.mkdir()
    for name in ("examples", "benchmarks"):
        (folder / name).symlink_to(ROOT / name)
    for name, code in _files(page).items():
        (folder / name).write_text(code, encoding="utf-8")
    installed = Path(sys.executable).parent  # netgenerate is there
    paths = os.pathsep.join((str(programs), str(installed), os.environ["PATH"]))
    for block in blocks_of(page):
        for line in runnable(block):
            done = subprocess.run(
                ["bash", "-euo", "pipefail", "-c", line],
                cwd=folder, capture_output=True, text=True, check=False, timeout=SECONDS,
                env={**os.environ, "PATH": paths, "PYTHONPATH": str(ROOT)},
            )  # fmt: skip
            allowed = {0, int(any(re.search(part, line) for part in MAY_FAIL))}
            assert done.returncode in allowed, (
                f"{_line_of(block, line)}\n{done.stdout}\n{done.stderr}"
            )
            assert "Traceback" not in done.stderr, _line_of(block, line)


def _files(page: Path) -> dict[str, str]:
    """Return the files that a page asks its reader to save: marked `<!-- file: NAME -->`."""
    text = page.read_text(encoding="utf-8")
    return dict(
        re.findall(r"<!-- file: (\S+) -->\n```\w+\n(.*?)^```", text, re.DOTALL | re.MULTILINE)
    )


@pytest.mark.parametrize(
    "table", [NOT_RUN, SMALLER, MAY_FAIL], ids=["not run", "smaller", "may fail"]
)
def test_every_row_of_the_tables_is_used(table: dict[str, str]) -> None:
    text = "\n".join(line for page in PAGES for block in blocks_of(page) for line in block.lines)
    if table is SMALLER:  # some rows change what earlier rows have made
        text += "\n" + "\n".join(
            line for page in PAGES for block in blocks_of(page) for line in runnable(block)
        )

    assert [part for part in table if not re.search(part, text, re.MULTILINE)] == []


def test_every_page_of_the_tutorials_and_the_quickstart_is_run() -> None:
    taught = {DOCS / "quickstart.md", *(DOCS / "tutorials").glob("*.md")}

    assert taught <= set(RUN)


def test_the_quickstart_has_five_commands() -> None:
    assert len([line for block in blocks_of(DOCS / "quickstart.md") for line in block.lines]) == 5
