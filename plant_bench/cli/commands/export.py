"""`plant-bench export`: writes a run in the format of other tools."""

from pathlib import Path
from typing import Annotated

import typer


def export_run(
    run: Annotated[Path, typer.Argument(help="Folder of a run.")],
    out: Annotated[Path, typer.Option(help="The file to write.")],
    format_: Annotated[
        str,
        typer.Option(
            "--format", help="File format; carla: checkpoint JSON of CARLA's leaderboard."
        ),
    ] = "carla",
    repetition: Annotated[
        str,
        typer.Option(
            help="Repetition to export: a number from 0, or all. PlanT's own parser reads one only."
        ),
    ] = "all",
) -> None:
    """Write a run as a file that other tools read.

    The checkpoint JSON of CARLA's leaderboard (1.0) holds scores, infractions and length of each
    episode. Values that it has no field for are stored under keys named "plant_bench".

    Example commands:

        plant-bench export reports/plant-longest6 --out plant_longest6.json

        plant-bench export reports/plant-longest6 --repetition 0 --out plant_0.json
    """
    from plant_bench.errors import InputError
    from plant_bench.reports.carla_checkpoint_run import run_checkpoint
    from plant_bench.reports.carla_checkpoint_writing import write_checkpoint
    from plant_bench.reports.tables import counted
    from plant_bench.runner.run.folder import RunFolder

    if format_ != "carla":
        message = f"--format: expected carla, got '{format_}'."
        raise InputError(message)
    if repetition != "all" and not repetition.isdecimal():
        message = f"--repetition: expected a number from 0, or all, got '{repetition}'."
        raise InputError(message)
    folder = RunFolder.open(run)
    only = None if repetition == "all" else int(repetition)
    checkpoint = run_checkpoint(folder, only)
    write_checkpoint(checkpoint.content, out)
    complete = checkpoint.episodes == checkpoint.expected
    missing = "" if complete else f" of {checkpoint.expected}; the run is not finished"
    typer.echo(f"{out}: {counted(checkpoint.episodes, 'episode')}{missing}.")
