"""`plant-bench data`."""

from pathlib import Path
from typing import Annotated

import typer

data_app = typer.Typer(no_args_is_help=True, help="Describe and check collected data.")

Folder = Annotated[Path, typer.Argument(help="A folder that `plant-bench collect` filled.")]


@data_app.command("describe")
def describe(
    folder: Folder,
    out: Annotated[
        Path | None, typer.Option(help="Folder for the plots; FOLDER/plots without it.")
    ] = None,
    plots: Annotated[bool, typer.Option(help="Save plots, too.")] = True,
) -> None:
    """Say what is in collected data: tables, and plots as PNG files.

    For instance:

        plant-bench data describe data/plant-1x
    """
    from plant_bench.data.statistics import describe_data
    from plant_bench.reports.data_card import who_drove
    from plant_bench.reports.data_plots import save_data_plots
    from plant_bench.reports.data_tables import print_data
    from plant_bench.runner.collect.data_folder import DataFolder

    data, origin = describe_data(folder), DataFolder(folder).origin()
    driver = "" if origin is None else origin.driver
    print_data(data, answers=bool(driver))
    if driver:
        typer.echo(who_drove(driver))
    if plots:
        target = folder / "plots" if out is None else out
        save_data_plots(data, target)
        typer.echo(f"Plots are in {target}.")


@data_app.command("check")
def check(folder: Folder) -> None:
    """Read collected data whole and say whether all of it can be used.

    Exit code 2 where a file is broken or cut off, or belongs to no route.

    For instance:

        plant-bench data check data/plant-1x
    """
    from plant_bench.data.statistics import episode_files, find_data_faults
    from plant_bench.errors import InputError

    faults = find_data_faults(folder)
    count = len(episode_files(folder))
    if faults:
        message = (
            f"{len(faults)} of {count} files cannot be used. The first: {faults[0]} Remove what is "
            "broken, and run the same `plant-bench collect` again: it drives what is missing."
        )
        raise InputError(message)
    typer.echo(f"{folder}: sound, {count} episodes.")
