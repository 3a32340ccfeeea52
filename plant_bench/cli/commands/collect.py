"""`plant-bench collect`."""

import time
from pathlib import Path
from typing import Annotated

import typer

from plant_bench.cli.options import CORES, EXIT_INTERRUPTED, DensityOption


def collect(
    out: Annotated[Path, typer.Option(help="The data's folder.")],
    units: Annotated[
        float | None, typer.Option(help="How much, in PlanT's units of 228,000 frames.")
    ] = None,
    frames: Annotated[
        int | None, typer.Option(help="How much, in frames at 2 Hz; instead of --units.", min=1)
    ] = None,
    seed: Annotated[
        int,
        typer.Option(help="Of routes, traffic and perturbations; others give other data.", min=0),
    ] = 0,
    perturb: Annotated[
        float,
        typer.Option(
            help="Share of episodes with perturbations that the expert recovers from; PlanT: none.",
            min=0.0,
            max=1.0,
        ),
    ] = 0.0,
    driver: Annotated[
        str,
        typer.Option(help="Let this planner drive, and keep what the expert would do (DAgger)."),
    ] = "",
    density: DensityOption = "dense",
    workers: Annotated[
        int, typer.Option(help="Processes; the data does not depend on it.", min=1)
    ] = CORES,
) -> None:
    """Let the expert drive training routes and keep what it saw and did, to learn from.

    Routes and traffic are never the benchmark's. Without --units and --frames it is one unit, about
    32 hours of driving. The same command again goes on where it was stopped with Ctrl-C; with more
    units it adds to what is there. Episodes that failed are left out and counted.

    For instance:

        plant-bench collect --out data/first --frames 20000

        plant-bench collect --out data/plant-1x

        plant-bench collect --out data/recovering --units 1 --perturb 0.3 --workers 2

        plant-bench collect --out data/own-mistakes --units 0.3 --driver plant --seed 1
    """
    from plant_bench.api.collect import collect_data
    from plant_bench.cli.collect_progress import CollectProgress
    from plant_bench.errors import InputError
    from plant_bench.reports.data_tables import print_data
    from plant_bench.reports.tables import print_rows
    from plant_bench.runner.collect.request import UNIT, CollectRequest

    if units is not None and frames is not None:
        message = "--units and --frames both say how much: give one of them."
        raise InputError(message)
    wanted = frames if frames is not None else round(UNIT * (1.0 if units is None else units))
    request = CollectRequest(wanted, seed, density, perturb, driver)
    start = time.monotonic()
    progress = CollectProgress(request.frames)
    try:
        with progress.bars:
            found = collect_data(request, out, workers=workers, on_event=progress)
    except KeyboardInterrupt:
        typer.echo(
            f"Stopped. {progress.frames:,} of {request.frames:,} frames are kept in {out}. The "
            "same command again goes on.",
            err=True,
        )
        raise typer.Exit(EXIT_INTERRUPTED) from None
    progress.say_speed(time.monotonic() - start, workers)
    print_data(found.data, answers=bool(request.driver))
    rows = [(reason, str(number)) for reason, number in found.left_out.items()]
    print_rows(f"Left out of {len(found.notes)} episodes", ["why", "episodes"], rows)
    typer.echo(f"Data: {found.path}")
