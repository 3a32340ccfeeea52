"""`plant-bench train`."""

from pathlib import Path
from typing import Annotated, Literal

import typer

from plant_bench.cli.options import EXIT_INTERRUPTED
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
from plant_bench.errors import InputError

train_app = typer.Typer(no_args_is_help=True, help="Learn to drive from recordings.")


@train_app.callback()
def _root() -> None:
    """Keep the planner's name a command of its own, also while there is one only."""


@train_app.command("plant")
def train_plant(
    data: DataOption,
    out: Annotated[Path, typer.Option(help="Folder for the model, as models/mine.")],
    share: ShareOption = 1.0,
    size: Annotated[Literal["mini", "small", "medium"], typer.Option(help="Encoder.")] = "mini",
    epochs: EpochsOption = 47,
    drop_after: Annotated[
        int | None, typer.Option(help="Epochs before the rate falls to a tenth; 45 of 47.", min=0)
    ] = None,
    batch: BatchOption = 128,
    rate: RateOption = 1e-4,
    auxiliary: Annotated[
        float, typer.Option(help="Weight of predicting the others' future.", min=0.0)
    ] = 0.2,
    caution: Annotated[
        float, typer.Option(help="Weight of waypoints too far ahead; 1 as the paper.", min=0.1)
    ] = 1.0,
    seed: Annotated[int, typer.Option(help="Of weights, order and held-out routes.", min=0)] = 0,
    resting: RestingOption = 1.0,
    held_out: Annotated[
        float, typer.Option(help="Share of the routes kept for validation.", min=0.0, max=0.9)
    ] = 0.1,
    reach: Annotated[float, typer.Option(help="Metres within which others are seen.")] = 30.0,
    foresight: Annotated[
        float, typer.Option(help="Seconds in which who comes within reach is seen.", min=0.0)
    ] = 0.0,
    segments: Annotated[int, typer.Option(help="Route segments told.", min=1)] = 2,
    vulnerable: Annotated[
        bool, typer.Option(help="See walkers, and riders as a type of their own.")
    ] = False,
    stop_line: Annotated[
        bool, typer.Option(help="See where a red light's line is, not only that there is one.")
    ] = False,
    meetings: Annotated[
        bool, typer.Option(help="Tell where and when others get into the way if they go on.")
    ] = False,
    tracks: Annotated[
        bool, typer.Option(help="Tell how the speed and heading of others have just changed.")
    ] = False,
    view: Annotated[int, typer.Option(help="Metres of route looked at.", min=10, max=100)] = 50,
    rear: Annotated[bool, typer.Option(help="See who is behind.")] = True,
    speeds: Annotated[bool, typer.Option(help="See the speeds of others.")] = True,
    speed_input: Annotated[bool, typer.Option(help="Tell the ego's speed.")] = False,
    speed_dropout: Annotated[
        float, typer.Option(help="Share of samples without it.", min=0.0, max=1.0)
    ] = 0.5,
    limit_input: Annotated[bool, typer.Option(help="Tell the speed limit.")] = False,
    targets: TargetsOption = "future",
    start: Annotated[
        Path | None, typer.Option(help="Model to start from; --meetings and --tracks may be new.")
    ] = None,
    full_precision: Annotated[
        bool, typer.Option("--full-precision", help="float32 instead of bfloat16.")
    ] = False,
    validate_every: Annotated[
        int, typer.Option(help="Epochs between closed-loop validations; 0 for none.", min=0)
    ] = 0,
    patience: Annotated[
        int,
        typer.Option(help="Validations without a better score that end it; 0 for none.", min=0),
    ] = 0,
    validate_suite: Annotated[
        str | None,
        typer.Option(
            help="What to drive then, none of the benchmark's; without it the routes held out."
        ),
    ] = None,
    validate_routes: Annotated[
        str | None, typer.Option(help="Which of them, as in `score --routes`.")
    ] = None,
    hazards: Annotated[bool, typer.Option(help="Play hazards in validation.")] = True,
    onnx: Annotated[
        bool, typer.Option("--onnx", help="Write network.onnx, too: half the time a decision.")
    ] = False,
    weights_bits: Annotated[
        Literal["8", "32"],
        typer.Option(
            help="Of network.onnx: 8 is up to twice as fast, waypoints differ by about a "
            "centimetre."
        ),
    ] = "8",
    accelerator: AcceleratorOption = "auto",
    devices: Annotated[int, typer.Option(help="Processes, one a device.", min=1)] = 1,
    threads: ThreadsOption = 0,
    workers: Annotated[
        int, typer.Option(help="Processes that make samples and drive validations.", min=1)
    ] = 2,
    work: Annotated[
        Path | None,
        typer.Option(help="Checkpoint, logs, validation; reports/training-NAME without it."),
    ] = None,
    overwrite: Annotated[
        bool, typer.Option("--overwrite", help="Start anew instead of going on.")
    ] = False,
) -> None:
    """Train PlanT to imitate what was recorded; the defaults are the paper's.

    The same command goes on where it was stopped, with Ctrl-C or by a crash, and comes to the same
    weights. A model is `weights.safetensors`, `config.json` and `card.md`.

    For instance:

        plant-bench train plant --data data/expert --out models/mine --epochs 10

        plant-bench train plant --data data/expert --data data/own-mistakes --targets answer
        --start models/mine --out models/better

        plant-bench score --agent plant@models/mine
    """
    check_installed()
    if patience and not validate_every:
        message = "--patience counts closed-loop validations: give --validate-every, too."
        raise InputError(message)
    from plant_bench.agents.plant.config import GraphBits, PlanTConfig
    from plant_bench.cli.learning import Course, Machine, Validation, learn
    from plant_bench.features.tokens import TokenSpec
    from plant_bench.training.ablations import Recipe
    from plant_bench.training.settings import TrainingSettings
    from plant_bench.training.settings import drop_after as usual_drop

    spec = TokenSpec(
        reach=reach,
        foresight=foresight,
        segments=segments,
        view=view,
        speed=speeds,
        rear=rear,
        vulnerable=vulnerable,
        stop_line=stop_line,
        meetings=meetings,
        tracks=tracks,
    )
    config = PlanTConfig(
        size,
        spec,
        speed_input=speed_input,
        speed_dropout=speed_dropout,
        limit_input=limit_input,
    )
    settings = TrainingSettings(
        epochs=epochs,
        drop_after=usual_drop(epochs) if drop_after is None else drop_after,
        batch=batch,
        rate=rate,
        auxiliary=auxiliary,
        caution=caution,
        seed=seed,
        resting=resting,
        held_out=held_out,
        precision="32-true" if full_precision else "bf16-mixed",
        targets=targets,
        validate_every=validate_every,
        patience=patience,
    )
    bits: GraphBits = 8 if weights_bits == "8" else 32
    course = Course(
        Recipe(config, settings, share),
        tuple(data),
        out,
        work or Path("reports") / f"training-{out.name}",
        Machine(accelerator, devices, threads, workers),
        Validation(validate_suite, validate_routes, hazards),
        overwrite,
        bits if onnx else None,
        start,
    )
    if not learn(course):
        raise typer.Exit(EXIT_INTERRUPTED)


def check_installed() -> None:
    """Say what to install where Lightning Fabric is missing.

    Raises:
        InputError: It is.
    """
    import importlib.util

    if importlib.util.find_spec("lightning_fabric") is None:
        message = "Training needs Lightning Fabric: pip install 'plant-bench[train]'."
        raise InputError(message)
