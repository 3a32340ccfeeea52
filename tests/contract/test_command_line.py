"""The command line as a user runs it: commands, exit codes and messages."""

import errno
import os
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

import pytest
from typer.testing import CliRunner

from plant_bench.cli import main

ROOT = Path(__file__).parents[2]


def plant_bench(*arguments: str, cwd: Path) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-m", "plant_bench", *arguments],
        cwd=cwd,
        env=os.environ | {"NO_COLOR": "1", "TERM": "dumb", "COLUMNS": "200"},
        capture_output=True,
        text=True,
        check=False,
    )


def exit_code(arguments: Sequence[str], monkeypatch: pytest.MonkeyPatch) -> object:
    """Run a command line in this process: far sooner done than in a new one."""
    monkeypatch.setattr(sys, "argv", ["plant-bench", *arguments])
    monkeypatch.setattr("plant_bench.cli.commands.score.tune_garbage_collector", lambda: None)
    with pytest.raises(SystemExit) as ended:
        main()
    return ended.value.code


def test_version_option_prints_the_version(tmp_path):
    from plant_bench import __version__

    assert plant_bench("--version", cwd=tmp_path).stdout == f"plant-bench {__version__}\n"


@pytest.mark.parametrize(
    "command",
    ["", "score", "rescore", "compare", "agents", "towns", "towns build", "towns list"]
    + ["routes", "routes build", "routes list", "rfds", "collect", "data", "data describe"]
    + [
        "data check",
        "train",
        "train plant",
        "ablate",
        "report",
        "replay",
        "why",
        "serve",
        "export",
        "import",
        "import-routes",
    ],
)
def test_help_of_each_command_shows_its_usage(command, tmp_path):
    done = plant_bench(*command.split(), "--help", cwd=tmp_path)

    assert done.returncode == 0
    assert f"plant-bench {command}".strip() in done.stdout
    assert "Usage" in done.stdout


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["score", "--agent", "exprt"], "Did you mean 'expert'?"),
        (["score", "--agent", "nowhere.py:Agent"], "There is no file"),
        (["score", "--agent", "nowhere.py"], "There is no file nowhere.py. Expected a planner as"),
        (["score", "--agent", "one.py"], "names no class. Add :Mine, as in one.py:Mine."),
        (["score", "--agent", "one.py@w"], "Add :Mine, as in one.py:Mine@w."),
        (["score", "--agent", "two.py:"], "Add one of :Mine, :Other, as in two.py:Mine."),
        (["score", "--agent", "broken.py"], "Expected a planner as file.py:Class, got 'broken.py'"),
        (["score", "--agent", "cruise", "--suite", "longest7"], "Available suites: longest6"),
        (["score", "--agent", "cruise", "--routes", "99"], "numbers from 0 to 35"),
        (["score", "--agent", "cruise", "--routes", "twon01-0"], "Did you mean town01-0?"),
        (["score", "--agent", "cruise", "--density", "thick"], "There is no density 'thick'"),
        (["score", "--agent", "cruise", "--routes", "0", "--out", "file/run"], "Cannot write to"),
        (["score", "--agent", "cruise", "--suite", "broken.json"], "Cannot use the routes file"),
        (["score", "--agent", "cruise", "--repetitions", "0"], "--repetitions"),
        (["score"], "--agent"),
        (["replay", "nowhere", "town01-0"], "Expected at least one of --html"),
        (["replay", "nowhere", "town01-0", "--png", "a.png"], "not a run of plant-bench"),
        (["serve", "nowhere"], "There is no folder nowhere"),
        (["score", "--agent", "cruise", "--penalties", "lb2.0"], "Unknown penalty scheme 'lb2.0'"),
        (["rescore", "nowhere", "--penalties", "lb3"], "expected lb1.0 or lb2.1"),
        (["compare", "nowhere", "file", "--penalties", "lb3"], "Unknown penalty scheme 'lb3'"),
        (["rescore", "nowhere"], "is not a run of plant-bench"),
        (["verify", "nowhere", "--all", "--sample", "5"], "--all and --sample exclude each other"),
        (["verify", "nowhere", "--sample", "0"], "a number of episodes from 1, got 0"),
        (["verify", "nowhere", "--controls", "--agent", "idm"], "exclude each other"),
        (["compare", "nowhere", "file"], "is not a run of plant-bench"),
        (["towns", "build", "--town", "town99", "--check"], "town99"),
        (["routes", "list", "--suite", "longest7"], "Available suites: longest6"),
        (["score-all"], "score"),
        (["rfds"], "Expected --agent"),
        (["rfds", "--ranker", "masking"], "Expected --agent"),
        (["rfds", "--ranker", "distence"], "There is no ranker 'distence'"),
        (["rfds", "--agent", "plant@nowhere"], "There are no weights in nowhere"),
        (["rfds", "--agent", "cruise"], "has no input 'objects'"),
        (["rfds", "--agent", "idm", "--ranker", "attention"], "use masking"),
        (["collect", "--out", "x", "--driver", "plnt"], "Did you mean 'plant'?"),
        (["collect", "--out", "x", "--driver", "plant@nowhere"], "nowhere"),
        (["collect", "--out", "x", "--driver", "idm", "--perturb", "1"], "exclude each other"),
        (["data", "describe", "nowhere"], "There is no data in nowhere"),
        (["train", "plant", "--data", "nowhere", "--out", "model"], "There is no data in"),
        (["train", "plant", "--data", "x", "--out", "y", "--patience", "2"], "--validate-every"),
        (
            ["train", "plant", "--data", "x", "--out", "y", "--validate-suite", "unseen"],
            "of the benchmark's suite 'unseen'",
        ),
        (["ablate", "raer", "--data", "nowhere"], "Did you mean rear?"),
        (["ablate", "--data", "nowhere"], "There is no data in"),
    ],
)
def test_bad_input_is_one_message_and_exit_code_2(arguments, words, tmp_path, monkeypatch, capsys):
    (tmp_path / "file").touch()
    (tmp_path / "broken.json").write_text('{"format": 1, "routes": [{"id": "x"}]}')
    planner = "class {}:\n    def act(self, observation): ...\n"
    (tmp_path / "one.py").write_text("class Helper: ...\n" + planner.format("Mine"))
    (tmp_path / "two.py").write_text(planner.format("Mine") + planner.format("Other"))
    (tmp_path / "broken.py").write_text("class Mine(:")
    monkeypatch.chdir(tmp_path)

    assert exit_code(arguments, monkeypatch) == 2

    said = capsys.readouterr().err
    assert words in said
    assert "Traceback" not in said
    assert not (tmp_path / "reports").exists()


def test_agents_are_listed_with_their_inputs(tmp_path):
    from plant_bench.agents.loading.planner_spec import AGENTS

    lines = plant_bench("agents", cwd=tmp_path).stdout.splitlines()

    assert [line.split()[0] for line in lines[::2]] == list(AGENTS)
    assert all("inputs:" in line for line in lines[1::2])


def test_routes_are_listed_with_their_numbers(tmp_path):
    done = plant_bench("routes", "list", cwd=tmp_path)

    assert done.returncode == 0
    assert "town06-5" in done.stdout
    assert any(line.split()[:2] == ["35", "town06-5"] for line in done.stdout.splitlines())


def test_unseen_suite_is_found_by_its_name(tmp_path):
    done = plant_bench("routes", "list", "--suite", "unseen", cwd=tmp_path)

    assert any(line.split()[:2] == ["35", "unseen06-5"] for line in done.stdout.splitlines())


def test_check_covers_all_suites_and_towns_by_default(monkeypatch):
    from plant_bench.cli import app

    monkeypatch.setattr("plant_bench.towns.routes.check_suite", lambda _: [])
    monkeypatch.setattr("plant_bench.towns.generate.check_town", lambda _: [])

    def checked(*arguments):
        lines = CliRunner().invoke(app, [*arguments, "--check"]).output.splitlines()
        return [line.removesuffix(": valid") for line in lines]

    assert checked("routes", "build") == ["longest6", "unseen"]
    assert checked("routes", "build", "--suite", "unseen") == ["unseen"]
    towns = [f"{kind}0{number}" for kind in ("town", "unseen") for number in range(1, 7)]
    assert checked("towns", "build") == towns


def test_rescore_and_compare_do_not_load_the_simulator():
    code = (
        "import sys, plant_bench.cli, plant_bench.runner.run.rescore_run;"
        "import plant_bench.reports.tables;"
        "sys.exit(bool({'libsumo', 'torch'} & sys.modules.keys()))"
    )

    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


@pytest.mark.parametrize(
    ("module", "late"),
    [
        ("api.score", {"libsumo", "pandas", "numba", "torch", "matplotlib"}),
        ("agents.cruise", {"numba", "torch", "shapely"}),
        ("runner.episode", {"pandas", "numba", "torch", "matplotlib"}),
    ],
)
def test_modules_do_not_import_heavy_libraries_at_start(module, late):
    """These imports would delay the start of a run by half a second."""
    code = f"import sys, plant_bench.{module}; sys.exit(', '.join({late!r} & sys.modules.keys()))"

    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)

    assert done.stderr.strip() == ""


def test_cli_starts_without_numpy_and_score_without_optional_libraries():
    code = (
        "import sys; import plant_bench.cli; print('numpy' in sys.modules); "
        "sys.modules.update(dict.fromkeys(['msgpack', 'resource', 'gymnasium', 'ray'])); "
        "import plant_bench.api.score"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)

    assert (done.stdout, done.stderr) == ("False\n", "")


def test_full_disk_is_one_line_that_names_the_file(tmp_path, monkeypatch, capsys):
    from plant_bench.atomic_files import write_whole

    def fill(part):
        raise OSError(errno.ENOSPC, "No space left on device")

    def command(*_, **__):
        write_whole(tmp_path / "verdict.json", fill)

    monkeypatch.setattr("plant_bench.cli.app", command)

    assert exit_code(["agents"], monkeypatch) == 2

    said = capsys.readouterr().err
    assert f"Cannot use {tmp_path / 'verdict.json'}: No space left on device." in said
