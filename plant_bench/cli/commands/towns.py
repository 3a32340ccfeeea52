"""`plant-bench towns`: builds, checks and lists towns."""

from dataclasses import asdict
from pathlib import Path
from typing import Annotated

import typer

from plant_bench.api.numbers import HIGHEST_SEED
from plant_bench.cli.number_options import number_option
from plant_bench.cli.options import check_build_options

towns_app = typer.Typer(
    no_args_is_help=True, help="Build, check (build --check) and list the towns."
)


@towns_app.command("build")
def build(
    town: Annotated[str | None, typer.Option(help="Name of the town. Default: all.")] = None,
    seed: Annotated[
        int | None,
        number_option("Seed for another layout of the same kind of town.", 0, HIGHEST_SEED),
    ] = None,
    out: Annotated[
        Path | None, typer.Option(help="Output folder. Default: the folder of the built-in towns.")
    ] = None,
    check: Annotated[
        bool, typer.Option("--check", help="Check the existing towns; write nothing.")
    ] = False,
) -> None:
    """Build towns again from specification and seed; the same seed gives identical files.

    Example commands:

        plant-bench towns build --check

        plant-bench towns build --town town03 --seed 7 --out my_towns
    """
    from plant_bench.towns.generate import build_town, check_town, stored_towns, town_names

    check_build_options(seed, out, check=check)
    faults: list[str] = []
    names = stored_towns() if seed is None else town_names()  # with a seed: one per character
    for name in [town] if town is not None else names:
        if check:
            town_faults = check_town(name)
            faults.extend(f"{name}: {fault}" for fault in town_faults)
            typer.echo(f"{name}: {f'{len(town_faults)} faults' if town_faults else 'valid'}")
        else:
            folder = None if out is None else out / name
            typer.echo(f"{name}: {build_town(name, seed=seed, out=folder)}")
    for fault in faults:
        typer.echo(fault, err=True)
    if faults:
        raise typer.Exit(1)


@towns_app.command("list")
def list_towns(
    pictures: Annotated[
        Path | None, typer.Option(help="Folder in which to save an image of each town.")
    ] = None,
    suite: Annotated[
        str | None,
        typer.Option(help="List only the towns of this suite (its name, folder or file)."),
    ] = None,
) -> None:
    """List the towns and their contents; for an imported town use --suite NAME/routes."""
    from plant_bench.reports.tables import print_rows
    from plant_bench.towns.generate import stored_towns
    from plant_bench.towns.town_image import save_picture
    from plant_bench.towns.town_summary import summarise
    from plant_bench.towns.unseen_towns import UNSEEN
    from plant_bench.world.route import load_suite
    from plant_bench.world.town import load_town

    if suite is None:
        found = [load_town(name) for name in stored_towns()]
    else:
        routes = {route.town: route for route in load_suite(suite)}
        found = [route.load_town() for _, route in sorted(routes.items())]
    towns = [asdict(summarise(town)) for town in found]
    for title, further in (("Towns", False), ("Unseen towns", True)):
        shown = [town for town in towns if (town["name"] in UNSEEN) == further]
        if not shown:
            continue
        heads = ["", *(str(town["name"]) for town in shown)]
        kinds = [kind for kind in shown[0] if kind != "name"]
        print_rows(title, heads, [[_words(k), *(town[k] for town in shown)] for k in kinds])
    if pictures is not None:
        pictures.mkdir(parents=True, exist_ok=True)
        for town in found:
            save_picture(town, pictures / f"{town.name}.png")
        typer.echo(f"Pictures are in {pictures}.")


def _words(name: str) -> str:
    return name.replace("_", " ").replace(" km", " (km)").replace("extent", "extent (m)")
