"""`plant-bench ablate`: trains and scores variants of a learner that each differ in one thing."""

import inspect
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any

import typer
from typer.core import TyperCommand

from plant_bench.cli.commands.train import command_of
from plant_bench.cli.dataclass_options import (
    OptionField,
    build_dataclass,
    option_fields,
    with_options,
)
from plant_bench.cli.number_options import number_option
from plant_bench.cli.options import (
    DensityOption,
    HazardsOption,
    OverwriteOption,
    RepetitionsOption,
    RoutesOption,
    SuiteOption,
)

LEARNER = "plant"
_NO_OPTION = frozenset({"seed", "validate_every", "patience"})  # set by the ablation itself


def ablate_learner(
    names: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="NAME",
            help="Ablations, e.g. rear, speeds, auxiliary, size (of PlanT) or data (of any "
            "learner), or single variants, e.g. small. Default: all. An unknown name lists them.",
        ),
    ] = None,
    out: Annotated[Path, typer.Option(help="Folder of models, runs and tables.")] = Path(
        "reports/ablations"
    ),
    learner: Annotated[
        str,
        typer.Option(help="Learner to train: a name, package.module:Class or file.py:Class."),
    ] = LEARNER,
    base: Annotated[
        Path | None,
        typer.Option(
            help="Trained model whose network options are the baseline of all variants. Default: "
            "the learner's defaults."
        ),
    ] = None,
    seeds: Annotated[int, number_option("Number of trainings per variant.", 1, 1000)] = 1,
    suite: SuiteOption = "longest6",
    routes: RoutesOption = None,
    repetitions: RepetitionsOption = 3,
    density: DensityOption = "dense",
    hazards: HazardsOption = True,
    onnx: Annotated[
        bool, typer.Option("--onnx", help="Export each model to ONNX, and drive with that.")
    ] = False,
    overwrite: OverwriteOption = False,
    **training_arguments: Any,
) -> None:
    """Train and score a learner with one change at a time, and write a table of the results.

    Each variant is an ordinary training and an ordinary run. The same command again continues with
    what is missing. `ablations.md` and `ablations.csv` are written once all variants are scored.

    Example commands:

        plant-bench ablate --data data/expert

        plant-bench ablate rear speeds --data data/expert --epochs 10 --routes 0-5 --seeds 2
    """
    from plant_bench.cli.ablation_table import ablate
    from plant_bench.runner.run.score_run import ScoreRequest
    from plant_bench.training.ablation_run import AblationRequest
    from plant_bench.training.ablation_variants import Recipe
    from plant_bench.training.initial_weights import options_in
    from plant_bench.training.learners import LearnerSpec, learner_class
    from plant_bench.training.settings import TrainingSettings
    from plant_bench.training.training_run import Machine

    kind = learner_class(learner)
    common, own = _training_options(learner)
    values = {item.path: item.value(training_arguments[item.name]) for item in common}
    own_values = {
        item.path[1:]: item.value(training_arguments[item.name])
        for item in own
        if training_arguments[item.name] is not None
    }
    start = kind.Options() if base is None else options_in(kind, base)
    settings = build_dataclass(TrainingSettings, _inside("settings", values))
    options = build_dataclass(kind.Options, own_values, start)
    request = AblationRequest(
        names or (),
        Recipe(LearnerSpec(learner, options), settings, values["share",]),
        values["data",],
        out,
        ScoreRequest("", suite, routes, repetitions, density=density, hazards=hazards),
        seeds,
        build_dataclass(Machine, _inside("machine", values)),
        overwrite,
        onnx,
    )
    raise typer.Exit(ablate(request))


class AblateCommand(TyperCommand):
    """The `ablate` command, with the options of the learner named on the command line."""

    def make_context(
        self, info_name: str | None, args: list[str], parent: Any = None, **extra: Any
    ) -> Any:
        """Parse the arguments.

        Raises:
            InputError: There is no such learner.
        """
        common, own = _training_options(_learner_in(args))
        fixed = inspect.signature(ablate_learner, eval_str=True).parameters.values()
        parameters = [
            *(item for item in fixed if item.kind is not inspect.Parameter.VAR_KEYWORD),
            *(item.parameter() for item in common),
            *(item.parameter(optional=True) for item in own),
        ]
        description = inspect.cleandoc(ablate_learner.__doc__ or "")
        command = command_of("ablate", with_options(ablate_learner, parameters, description))
        return command.make_context(info_name, args, parent, **extra)


def ablate_learner_stub() -> None:
    """Train and score a learner with one change at a time, and write a table of the results."""


def _training_options(learner: str) -> tuple[list[OptionField], list[OptionField]]:
    """Return the training options common to all learners, and the learner's own."""
    from plant_bench.training.learners import learner_class
    from plant_bench.training.training_run import TrainingRun

    kind = learner_class(learner)
    known = kind(kind.Options()).recipe
    options = option_fields(TrainingRun, inside={"options": kind.Options}, without=_FIXED)
    own = [item for item in options if item.path[0] == "options" and item.path[1] in known]
    return [
        item for item in options if item.path[0] != "options" and item.path[-1] not in _NO_OPTION
    ], own


_FIXED = frozenset({"learner", "out", "start", "validation", "work", "overwrite"})


def _inside(name: str, values: Mapping[tuple[str, ...], Any]) -> dict[tuple[str, ...], Any]:
    return {path[1:]: value for path, value in values.items() if path[0] == name}


def _learner_in(arguments: list[str]) -> str:
    """Return the value of --learner, or its default."""
    for index, word in enumerate(arguments):
        if word == "--learner" and index + 1 < len(arguments):
            return arguments[index + 1]
        if word.startswith("--learner="):
            return word.partition("=")[2]
    return LEARNER
