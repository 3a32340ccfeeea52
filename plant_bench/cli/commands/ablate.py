"""`plant-bench ablate`: its options are those of the learner that `--learner` names."""

import inspect
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any

import typer
from typer.core import TyperCommand

from plant_bench.cli.commands.train import command_of
from plant_bench.cli.dataclass_options import OptionField, built, option_fields, with_options
from plant_bench.cli.options import DensityOption, RepetitionsOption, SuiteOption

LEARNER = "plant"
_ALIKE = frozenset({"seed", "validate_every", "patience"})  # settings that are the same for all


def ablate_learner(
    names: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="NAME",
            help="Ablations, as rear, speeds, auxiliary, size (PlanT's), or data (any learner's); "
            "or single choices, as small. All without a name; another name lists them.",
        ),
    ] = None,
    out: Annotated[Path, typer.Option(help="Folder of all that is made.")] = Path(
        "reports/ablations"
    ),
    learner: Annotated[
        str, typer.Option(help="Who learns: a name, package.module:Class or file.py:Class.")
    ] = LEARNER,
    base: Annotated[
        Path | None,
        typer.Option(help="A trained model whose network is the base; the defaults without it."),
    ] = None,
    seeds: Annotated[int, typer.Option(help="Trainings of each variant.", min=1)] = 1,
    suite: SuiteOption = "longest6",
    routes: Annotated[
        str | None, typer.Option(help="Which of them, as in `score --routes`; all without it.")
    ] = None,
    repetitions: RepetitionsOption = 3,
    density: DensityOption = "dense",
    hazards: Annotated[bool, typer.Option(help="Play the routes' hazards.")] = True,
    onnx: Annotated[bool, typer.Option("--onnx", help="Drive with ONNX graphs.")] = False,
    overwrite: Annotated[
        bool, typer.Option("--overwrite", help="Make again what is finished.")
    ] = False,
    **of_training: Any,
) -> None:
    """Train and score a learner with one thing changed at a time, and put it in a table.

    Each variant is an ordinary training and an ordinary run, of which the same command again makes
    only what is missing. `ablations.md` and `ablations.csv` are written when all have driven.

    For instance:

        plant-bench ablate --data data/expert

        plant-bench ablate rear speeds --data data/expert --epochs 10 --routes 0-5 --seeds 2
    """
    from plant_bench.cli.ablation_table import ablate
    from plant_bench.runner.run.score_run import ScoreRequest
    from plant_bench.training.ablation_run import AblationRequest
    from plant_bench.training.ablation_variants import Recipe
    from plant_bench.training.initial_weights import options_in
    from plant_bench.training.learners import Student, learner_class
    from plant_bench.training.settings import TrainingSettings
    from plant_bench.training.training_run import Machine

    kind = learner_class(learner)
    common, own = _fields(learner)
    given = {item.path: item.value(of_training[item.name]) for item in common}
    chosen = {
        item.path[1:]: item.value(of_training[item.name])
        for item in own
        if of_training[item.name] is not None
    }
    start = kind.Options() if base is None else options_in(kind, base)
    settings = built(TrainingSettings, _inside("settings", given))
    options = built(kind.Options, chosen, start)
    request = AblationRequest(
        names or (),
        Recipe(Student(learner, options), settings, given["share",]),
        given["data",],
        out,
        ScoreRequest("", suite, routes, repetitions, density=density, hazards=hazards),
        seeds,
        built(Machine, _inside("machine", given)),
        overwrite,
        onnx,
    )
    raise typer.Exit(ablate(request))


class AblateCommand(TyperCommand):
    """Becomes the command with the options of the learner that is asked for."""

    def make_context(
        self, info_name: str | None, args: list[str], parent: Any = None, **extra: Any
    ) -> Any:
        """Parse the arguments.

        Raises:
            InputError: There is no such learner.
        """
        common, own = _fields(_learner_in(args))
        fixed = inspect.signature(ablate_learner, eval_str=True).parameters.values()
        parameters = [
            *(item for item in fixed if item.kind is not inspect.Parameter.VAR_KEYWORD),
            *(item.parameter() for item in common),
            *(item.parameter(optional=True) for item in own),
        ]
        about = inspect.cleandoc(ablate_learner.__doc__ or "")
        command = command_of("ablate", with_options(ablate_learner, parameters, about))
        return command.make_context(info_name, args, parent, **extra)


def ablate_learner_stub() -> None:
    """Train and score a learner with one thing changed at a time, and put it in a table."""


def _fields(learner: str) -> tuple[list[OptionField], list[OptionField]]:
    """Return the options of all trainings, and the learner's own."""
    from plant_bench.training.learners import learner_class
    from plant_bench.training.training_run import TrainingRun

    kind = learner_class(learner)
    known = kind(kind.Options()).recipe
    found = option_fields(TrainingRun, inside={"options": kind.Options}, without=_FIXED)
    own = [item for item in found if item.path[0] == "options" and item.path[1] in known]
    return [
        item for item in found if item.path[0] != "options" and item.path[-1] not in _ALIKE
    ], own


_FIXED = frozenset({"learner", "out", "start", "validation", "work", "overwrite"})


def _inside(name: str, values: Mapping[tuple[str, ...], Any]) -> dict[tuple[str, ...], Any]:
    return {path[1:]: value for path, value in values.items() if path[0] == name}


def _learner_in(arguments: list[str]) -> str:
    """Return the learner that a command line names."""
    for place, word in enumerate(arguments):
        if word == "--learner" and place + 1 < len(arguments):
            return arguments[place + 1]
        if word.startswith("--learner="):
            return word.partition("=")[2]
    return LEARNER
