"""`plant-bench train NAME`: a command for each learner, with its own options among the common."""

import inspect
from typing import Any

import typer
from typer.core import TyperCommand, TyperGroup

from plant_bench.cli.dataclass_options import built, option_fields, with_options
from plant_bench.cli.options import EXIT_INTERRUPTED

_ABOUT = """

    The same command goes on where it was stopped, with Ctrl-C or by a crash, and comes to the same
    weights. A model is `weights.safetensors`, `config.json` and `card.md`.

    For instance:

        plant-bench train {name} --data data/expert --out models/mine --epochs 10

        plant-bench train {name} --data data/expert --data data/own-mistakes --targets expert-action
        --start models/mine --out models/better

        plant-bench score --agent {agent}@models/mine
"""
SETTINGS = {"help_option_names": ["-h", "--help"]}


class TrainGroup(TyperGroup):
    """Has a command for every learner: ours, installed ones, and what a module or file holds."""

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
    help="Learn to drive from recordings: NAME, package.module:Class or file.py:Class.",
)


@train_app.callback()
def _root() -> None:
    """Learn to drive from recordings: NAME, package.module:Class or file.py:Class."""


def train_command(name: str) -> TyperCommand:
    """Return the command that trains a learner.

    Raises:
        InputError: There is no such learner, or its options are none.
    """
    from plant_bench.training.learners import learner_class
    from plant_bench.training.training_run import TrainingRun

    kind = learner_class(name)
    found = option_fields(
        TrainingRun, inside={"options": kind.Options}, without=frozenset({"learner"})
    )

    def train(**given: Any) -> None:
        from plant_bench.cli.training_progress import learn_visibly

        values = {item.path: item.value(given[item.name]) for item in found}
        options = built(kind.Options, _inside("options", values))
        others = {path: value for path, value in values.items() if path[0] != "options"}
        course = built(TrainingRun, {**others, ("learner",): name, ("options",): options})
        if not learn_visibly(course):
            raise typer.Exit(EXIT_INTERRUPTED)

    about = inspect.cleandoc(kind.__doc__ or "").partition("\n")[0] or f"Train {name}."
    text = about + _ABOUT.format(name=name, agent=kind.agent)
    return command_of(name, with_options(train, [item.parameter() for item in found], text))


def command_of(name: str, function: Any) -> TyperCommand:
    """Return a function as a command that looks like all others."""
    app = typer.Typer(add_completion=False, rich_markup_mode="markdown", context_settings=SETTINGS)
    app.command(name, context_settings=SETTINGS)(function)
    found = typer.main.get_command(app)
    assert isinstance(found, TyperCommand)  # noqa: S101  a single command is no group
    return found


def _inside(name: str, values: dict[tuple[str, ...], Any]) -> dict[tuple[str, ...], Any]:
    return {path[1:]: value for path, value in values.items() if path[0] == name}
