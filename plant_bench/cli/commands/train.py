"""`plant-bench train LEARNER`: one command per learner, with common and its own options."""

import inspect
from typing import Any

import typer
from typer.core import TyperCommand, TyperGroup

from plant_bench.cli.dataclass_options import build_dataclass, option_fields, with_options
from plant_bench.cli.options import EXIT_INTERRUPTED

_DESCRIPTION = """

    The same command again continues a training that was stopped by Ctrl-C or a crash, with the same
    final weights. A model consists of `weights.safetensors`, `config.json` and `card.md`.

    Example commands:

        plant-bench train {name} --data data/expert --out models/mine --epochs 10

        plant-bench train {name} --data data/expert --data data/dagger --targets expert-action
        --start models/mine --out models/better

        plant-bench score --agent {agent}@models/mine
"""
SETTINGS = {"help_option_names": ["-h", "--help"]}


class TrainGroup(TyperGroup):
    """A command for every learner: built in, installed, or named by module or file."""

    def list_commands(self, ctx: Any) -> list[str]:
        """Return the names of the learners."""
        del ctx
        from plant_bench.training.learners import known_learners

        return known_learners()

    def get_command(self, ctx: Any, cmd_name: str) -> Any:
        """Return a learner's command.

        Raises:
            InputError: There is no such learner.
        """
        del ctx
        return train_command(cmd_name)


train_app = typer.Typer(
    cls=TrainGroup,
    no_args_is_help=True,
    help="Train a planner from recordings. COMMAND is plant, package.module:Class or "
    "file.py:Class.",
)


@train_app.callback()
def _root() -> None:
    """Train a planner from recordings. COMMAND is plant, package.module:Class or file.py:Class."""


def train_command(name: str) -> TyperCommand:
    """Return the command that trains a learner.

    Raises:
        InputError: There is no such learner, or its options cannot be used.
    """
    from plant_bench.training.learners import learner_class
    from plant_bench.training.training_run import TrainingRun

    kind = learner_class(name)
    fields = option_fields(
        TrainingRun, inside={"options": kind.Options}, without=frozenset({"learner"})
    )

    def train(**arguments: Any) -> None:
        from plant_bench.cli.training_progress import train_with_progress

        values = {item.path: item.value(arguments[item.name]) for item in fields}
        options = build_dataclass(kind.Options, _inside("options", values))
        others = {path: value for path, value in values.items() if path[0] != "options"}
        run = build_dataclass(TrainingRun, {**others, ("learner",): name, ("options",): options})
        if not train_with_progress(run):
            raise typer.Exit(EXIT_INTERRUPTED)

    first_line = inspect.cleandoc(kind.__doc__ or "").partition("\n")[0] or f"Train {name}."
    text = first_line + _DESCRIPTION.format(name=name, agent=kind.agent)
    return command_of(name, with_options(train, [item.parameter() for item in fields], text))


def command_of(name: str, function: Any) -> TyperCommand:
    """Turn a function into a command in the style of the other commands."""
    app = typer.Typer(add_completion=False, rich_markup_mode="markdown", context_settings=SETTINGS)
    app.command(name, context_settings=SETTINGS)(function)
    command = typer.main.get_command(app)
    assert isinstance(command, TyperCommand)  # noqa: S101  not a group, for a single command
    return command


def _inside(name: str, values: dict[tuple[str, ...], Any]) -> dict[tuple[str, ...], Any]:
    return {path[1:]: value for path, value in values.items() if path[0] == name}
