"""`plant-bench export`."""

from pathlib import Path
from typing import Annotated

import typer


def export_run(
    run: Annotated[Path, typer.Argument(help="A folder that `plant-bench score` wrote.")],
    out: Annotated[Path, typer.Option(help="The file to write.")],
    format_: Annotated[
        str, typer.Option("--format", help="carla: the CARLA leaderboard's checkpoint JSON.")
    ] = "carla",
    repetition: Annotated[
        str, typer.Option(help="A number from 0, or all; PlanT's own parser wants one.")
    ] = "all",
) -> None:
    """Write a run as a file that the tools of others read.

    The CARLA leaderboard's checkpoint JSON (1.0) holds scores, infractions and lengths of each
    episode; what it has no place for is in keys named "plant_bench", so that nothing is lost.

    For instance:

        plant-bench export reports/plant-longest6 --out plant_longest6.json

        plant-bench export reports/plant-longest6 --repetition 0 --out plant_0.json
    """
    from plant_bench.errors import InputError
    from plant_bench.reports.carla_checkpoint_run import run_checkpoint
    from plant_bench.reports.carla_checkpoint_writing import write_checkpoint
    from plant_bench.runner.run.folder import RunFolder

    if format_ != "carla":
        message = f"There is no format '{format_}' of export: carla is known."
        raise InputError(message)
    if repetition != "all" and not repetition.isdecimal():
        message = f"--repetition {repetition}: a number from 0, or all, is wanted."
        raise InputError(message)
    folder = RunFolder.open(run)
    only = None if repetition == "all" else int(repetition)
    made = run_checkpoint(folder, only)
    write_checkpoint(made.content, out)
    whole = made.episodes == made.expected
    missing = "" if whole else f" of {made.expected}; the run is not finished"
    typer.echo(f"{out}: {made.episodes} episodes{missing}.")
