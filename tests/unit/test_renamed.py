"""Names of earlier versions are answered with the present ones."""

import json
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from typer.main import get_command

from plant_bench.agents.plant.config import load_config
from plant_bench.cli import app
from plant_bench.cli.commands.train import train_command
from plant_bench.errors import InputError
from plant_bench.renamed import OPTIONS

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
        [sys.executable, "-m", "plant_bench", "rescore", "reports/none", "--penalties", "lb2.1"],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 2
    assert done.stderr.strip() == (
        "plant-bench: The option '--penalties' of `plant-bench rescore` is now '--penalties'."
    )


def test_an_old_config_key_is_refused_with_the_new_name(tmp_path):
    folder = tmp_path / "model"
    shutil.copytree(MODEL, folder)
    config = json.loads((folder / "config.json").read_text())
    config["tokens"]["meetings"] = config["tokens"].pop("conflicts")
    (folder / "config.json").write_text(json.dumps(config))

    with pytest.raises(InputError, match="'meetings' is now 'conflicts'"):
        load_config(folder)


def _command(name):
    group = get_command(app)
    return group.commands[name]  # pyright: ignore[reportAttributeAccessIssue]
