"""`plant-bench collect`: records training data."""

import time
from pathlib import Path
from typing import Annotated

import typer

from plant_bench.api.numbers import HIGHEST_SEED, MOST_FRAMES, MOST_PROCESSES, UNITS_RANGE
from plant_bench.cli.number_options import number_option
from plant_bench.cli.options import CORES, EXIT_INTERRUPTED, DensityOption


def collect(
    out: Annotated[Path, typer.Option(help="Folder for the data.")],
    units: Annotated[
        float | None,
        number_option(
            "Amount of data, in PlanT's units of 228,000 frames. Default: 1.", *UNITS_RANGE
        ),
    ] = None,
    frames: Annotated[
        int | None,
        number_option("Amount of data, in frames at 2 Hz; instead of --units.", 1, MOST_FRAMES),
    ] = None,
    seed: Annotated[
        int,
        number_option("Seed of routes, traffic and perturbations.", 0, HIGHEST_SEED),
    ] = 0,
    perturb: Annotated[
        float,
        number_option(
            "Fraction of episodes in which the executed control is perturbed, so that the "
            "data contains recoveries (PlanT: 0).",
            0.0,
            1.0,
        ),
    ] = 0.0,
    driver: Annotated[
        str,
        typer.Option(
            help="DAgger: this planner drives, and the expert's actions are recorded as labels."
        ),
    ] = "",
    density: DensityOption = "dense",
    workers: Annotated[
        int, number_option("Number of processes; does not change the data.", 1, MOST_PROCESSES)
    ] = CORES,
) -> None:
    """Record training data: the expert drives training routes.

    Routes and traffic seeds are never those of the benchmark. One unit is about 34 hours of
    driving. The same command again continues after Ctrl-C; with more units it adds to the data.
    Failed episodes are excluded and counted.

    Example commands:

        plant-bench collect --out data/first --frames 20000

        plant-bench collect --out data/plant-1x

        plant-bench collect --out data/perturbed --units 1 --perturb 0.3 --workers 2

        plant-bench collect --out data/dagger --units 0.3 --driver plant --seed 1
    """
    from plant_bench.api.collect import collect_data
    from plant_bench.cli.collect_progress import CollectProgress
    from plant_bench.errors import InputError
    from plant_bench.reports.data_tables import print_data
    from plant_bench.reports.tables import print_rows
    from plant_bench.runner.collect.request import UNIT, CollectRequest

    if units is not None and frames is not None:
        message = "--units and --frames exclude each other: give one of them."
        raise InputError(message)
    amount = frames if frames is not None else round(UNIT * (1.0 if units is None else units))
    request = CollectRequest(amount, seed, density, perturb, driver)
    start = time.monotonic()
    progress = CollectProgress(request.frames)
    try:
        with progress.bars:
            result = collect_data(request, out, workers=workers, on_event=progress)
    except KeyboardInterrupt:
        typer.echo(
            f"Stopped. {progress.frames:,} of {request.frames:,} frames are kept in {out}. Run the "
            "same command again to continue.",
            err=True,
        )
        raise typer.Exit(EXIT_INTERRUPTED) from None
    progress.print_speed(time.monotonic() - start, workers)
    print_data(result.data, answers=bool(request.driver))
    rows = [(reason, str(number)) for reason, number in result.left_out.items()]
    print_rows(f"Excluded of {len(result.notes)} episodes", ["reason", "episodes"], rows)
    typer.echo(f"Data: {result.path}")
