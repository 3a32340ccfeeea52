"""`plant-bench towns`."""

from dataclasses import fields
from pathlib import Path
from typing import Annotated

import typer

towns_app = typer.Typer(no_args_is_help=True, help="Build, check and list the towns.")


@towns_app.command("build")
def build(
    town: Annotated[str | None, typer.Option(help="One town; all without it.")] = None,
    seed: Annotated[
        int | None, typer.Option(help="Another layout of the same character.", min=0)
    ] = None,
    out: Annotated[
        Path | None, typer.Option(help="Folder to write to, instead of the towns' own.")
    ] = None,
    check: Annotated[
        bool, typer.Option("--check", help="Write nothing: check the towns that are there.")
    ] = False,
) -> None:
    """Build towns again from spec and seed; the same seed gives the same bytes.

    Examples:

        plant-bench towns build --check

        plant-bench towns build --town town03 --seed 7 --out my_towns
    """
    from plant_bench.towns.generate import build_town, check_town, town_names

    faults: list[str] = []
    for name in [town] if town is not None else town_names():
        if check:
            found = check_town(name)
            faults.extend(f"{name}: {fault}" for fault in found)
            typer.echo(f"{name}: {'sound' if not found else f'{len(found)} faults'}")
        else:
            typer.echo(f"{name}: {build_town(name, seed=seed, out=out)}")
    for fault in faults:
        typer.echo(fault, err=True)
    if faults:
        raise typer.Exit(1)


@towns_app.command("list")
def list_towns(
    pictures: Annotated[
        Path | None, typer.Option(help="Folder to save a picture of each town to.")
    ] = None,
) -> None:
    """List the towns and what each contains."""
    from plant_bench.reports.tables import print_rows
    from plant_bench.towns.generate import describe_town, town_names
    from plant_bench.towns.picture import save_town_picture

    summaries = [describe_town(name) for name in town_names()]
    if summaries:
        heads = [field.name.replace("_", " ") for field in fields(summaries[0])]
        columns = [
            [getattr(summary, field.name) for field in fields(summary)] for summary in summaries
        ]
        print_rows("Towns", heads, columns, transposed=True)
    if pictures is not None:
        pictures.mkdir(parents=True, exist_ok=True)
        for summary in summaries:
            save_town_picture(summary.name, pictures / f"{summary.name}.png")
        typer.echo(f"Pictures are in {pictures}.")
