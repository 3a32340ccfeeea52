"""`plant-bench data`: describes and checks collected data."""

from pathlib import Path
from typing import Annotated

import typer

data_app = typer.Typer(no_args_is_help=True, help="Describe and check collected data.")

Folder = Annotated[Path, typer.Argument(help="Folder written by `plant-bench collect`.")]


@data_app.command("describe")
def describe(
    folder: Folder,
    out: Annotated[
        Path | None, typer.Option(help="Folder for the plots. Default: FOLDER/plots.")
    ] = None,
    plots: Annotated[bool, typer.Option(help="Save plots.")] = True,
) -> None:
    """Print statistics of collected data, and save plots as PNG files.

    Example commands:

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
    """Read all files of collected data and check that they can be used.

    Exit code 2 if a file is broken, truncated or does not belong to any route, if the ego in it
    jumps or drives impossibly fast, or if an episode is there twice or missing.

    Example commands:

        plant-bench data check data/plant-1x
    """
    from plant_bench.data.completeness import incompleteness
    from plant_bench.data.statistics import episode_files, find_data_faults
    from plant_bench.errors import InputError

    faults = find_data_faults(folder)
    files = episode_files(folder)
    count = len(files)
    problems = incompleteness(folder, files)
    if faults:
        message = (
            f"{len(faults)} of {count} files cannot be used. The first: {faults[0]} Remove these "
            "files and run the same `plant-bench collect` command again to replace them."
        )
        raise InputError(" ".join([message, *problems]))
    if problems:
        raise InputError(" ".join(problems))
    typer.echo(f"{folder}: valid, {count} episodes.")
