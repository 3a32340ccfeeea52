"""`plant-bench ablate`."""

from pathlib import Path
from typing import Annotated, Literal

import typer

from plant_bench.cli.options import CORES, DensityOption, RepetitionsOption, SuiteOption
from plant_bench.cli.train import check_installed
from plant_bench.cli.training_options import (
    AcceleratorOption,
    BatchOption,
    DataOption,
    EpochsOption,
    RateOption,
    RestingOption,
    ShareOption,
    TargetsOption,
    ThreadsOption,
)


def ablate_plant(
    data: DataOption,
    names: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="NAME",
            help="rear, speeds, auxiliary, data, size (the paper's); stop-line, vulnerable, "
            "limit-input, reach, foresight, meetings, tracks, speed-input; or single choices, "
            "as small. All without a name.",
        ),
    ] = None,
    out: Annotated[Path, typer.Option(help="Folder of all that is made.")] = Path(
        "reports/ablations"
    ),
    base: Annotated[
        Path | None,
        typer.Option(help="A trained model whose network is the base; the paper's without it."),
    ] = None,
    size: Annotated[
        Literal["mini", "small", "medium"] | None, typer.Option(help="Encoder of the base.")
    ] = None,
    epochs: EpochsOption = 47,
    batch: BatchOption = 128,
    rate: RateOption = 1e-4,
    targets: TargetsOption = "future",
    resting: RestingOption = 1.0,
    share: ShareOption = 1.0,
    seeds: Annotated[int, typer.Option(help="Trainings of each variant.", min=1)] = 1,
    suite: SuiteOption = "longest6",
    routes: Annotated[
        str | None, typer.Option(help="Which of them, as in `score --routes`; all without it.")
    ] = None,
    repetitions: RepetitionsOption = 3,
    density: DensityOption = "dense",
    hazards: Annotated[bool, typer.Option(help="Play the routes' hazards.")] = True,
    onnx: Annotated[bool, typer.Option("--onnx", help="Drive with ONNX graphs.")] = False,
    accelerator: AcceleratorOption = "auto",
    threads: ThreadsOption = 0,
    workers: Annotated[
        int, typer.Option(help="Processes that make samples and drive.", min=1)
    ] = CORES,
    overwrite: Annotated[
        bool, typer.Option("--overwrite", help="Make again what is finished.")
    ] = False,
) -> None:
    """Train and score PlanT with one thing changed at a time, and put it in a table.

    Each variant is an ordinary training and an ordinary run, of which the same command again makes
    only what is missing. `ablations.md` and `ablations.csv` are written when all have driven.

    For instance:

        plant-bench ablate --data data/expert

        plant-bench ablate rear speeds --data data/expert --epochs 10 --routes 0-5 --seeds 2
    """
    check_installed()
    from dataclasses import replace

    from plant_bench.agents.plant.config import PlanTConfig, load_config
    from plant_bench.cli.ablating import AblationRequest, ablate
    from plant_bench.cli.learning import Machine
    from plant_bench.runner.run.score_run import ScoreRequest
    from plant_bench.training.ablations import Recipe
    from plant_bench.training.settings import TrainingSettings, drop_after

    config = PlanTConfig() if base is None else load_config(base)
    if size is not None:
        config = replace(config, size=size)
    settings = TrainingSettings(
        epochs=epochs,
        drop_after=drop_after(epochs),
        batch=batch,
        rate=rate,
        targets=targets,
        resting=resting,
    )
    request = AblationRequest(
        names or (),
        Recipe(config, settings, share),
        tuple(data),
        out,
        ScoreRequest(
            "plant-unguarded", suite, routes, repetitions, density=density, hazards=hazards
        ),
        seeds,
        Machine(accelerator, 1, threads, workers),
        overwrite,
        onnx,
    )
    raise typer.Exit(ablate(request))
