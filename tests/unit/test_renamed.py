"""Options, config keys and modules of earlier versions are refused with their new names."""

import importlib
import json
import shutil
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import pytest
from typer.main import get_command

from plant_bench.agents.plant.config import load_config
from plant_bench.cli import app
from plant_bench.cli.commands.train import train_command
from plant_bench.errors import InputError
from plant_bench.renamed import OPTIONS
from plant_bench.renamed_modules import MODULES
from plant_bench.user_modules import load_module

MODEL = Path(__file__).parents[2] / "models" / "plant-mini"


@pytest.mark.parametrize("old", OPTIONS)
def test_each_new_option_exists_and_no_old_one_does(old):
    new, commands = OPTIONS[old]
    for name in commands:
        command = train_command("plant") if name in ("train", "ablate") else _command(name)
        options = {text for item in command.params for text in (*item.opts, *item.secondary_opts)}
        assert new in options
        assert old not in options


def test_an_old_option_is_refused_with_the_new_name():
    done = subprocess.run(
        [sys.executable, "-m", "plant_bench", "rescore", "reports/none", "--law", "lb2.1"],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 2
    assert done.stderr.strip() == (
        "plant-bench: The option '--law' of `plant-bench rescore` is now '--penalties'."
    )


def test_an_old_config_key_is_refused_with_the_new_name(tmp_path):
    folder = tmp_path / "model"
    shutil.copytree(MODEL, folder)
    config = json.loads((folder / "config.json").read_text())
    config["tokens"]["meetings"] = config["tokens"].pop("conflicts")
    (folder / "config.json").write_text(json.dumps(config))

    with pytest.raises(InputError, match="'meetings' is now 'conflicts'"):
        load_config(folder)


@pytest.mark.parametrize("old", MODULES)
def test_each_old_module_is_gone_and_its_new_one_exists(old):
    assert find_spec(f"plant_bench.{MODULES[old]}")
    with pytest.raises(ModuleNotFoundError):
        importlib.import_module(f"plant_bench.{old}")


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("import plant_bench.garbage", "'plant_bench.garbage' is now 'plant_bench.gc_policy'"),
        ("from plant_bench.agent import NOBODY", "'NOBODY' is now 'NO_ACTOR'"),
    ],
)
def test_a_planner_that_imports_an_old_name_is_refused_with_the_new_name(tmp_path, line, message):
    path = tmp_path / "mine.py"
    path.write_text(f"{line}\n")
    with pytest.raises(InputError, match=message):
        load_module(str(path), "agent 'mine'")


def _command(name):
    group = get_command(app)
    return group.commands[name]  # pyright: ignore[reportAttributeAccessIssue]
