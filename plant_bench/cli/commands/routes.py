"""`plant-bench routes`."""

from pathlib import Path
from typing import Annotated

import typer

from plant_bench.cli.options import refuse_overwriting

routes_app = typer.Typer(no_args_is_help=True, help="Build, check and list the routes.")

Suite = Annotated[str, typer.Option(help="A suite's name, or a folder or file of routes.")]


@routes_app.command("build")
def build(
    suite: Annotated[
        str | None,
        typer.Option(help="Name of the suite; without it longest6, and with --check all."),
    ] = None,
    town: Annotated[
        list[str] | None, typer.Option(help="Only this town; may be given more than once.")
    ] = None,
    seed: Annotated[int | None, typer.Option(help="Other routes of the same kind.", min=0)] = None,
    out: Annotated[
        Path | None, typer.Option(help="Folder to write to, instead of the suite's own.")
    ] = None,
    check: Annotated[
        bool, typer.Option("--check", help="Write nothing: check the routes that are there.")
    ] = False,
) -> None:
    """Choose a suite's routes again; the same seed gives the same routes.

    For instance:

        plant-bench routes build --check

        plant-bench routes build --seed 7 --out my_routes
    """
    from plant_bench.towns.routes import SUITES, build_suite, check_suite

    refuse_overwriting(seed, out, check=check)
    if not check:
        name = suite or "longest6"
        typer.echo(f"{name}: {build_suite(name, towns=town, seed=seed, out=out)}")
        return
    faults: list[str] = []
    for name in [suite] if suite is not None else SUITES:
        found = check_suite(name)
        faults.extend(found)
        typer.echo(f"{name}: {'sound' if not found else f'{len(found)} faults'}")
    for fault in faults:
        typer.echo(fault, err=True)
    if faults:
        raise typer.Exit(1)


@routes_app.command("list")
def list_routes(
    suite: Suite = "longest6",
    pictures: Annotated[
        Path | None, typer.Option(help="Folder to save a picture of each route to.")
    ] = None,
) -> None:
    """List a suite's routes; the number is what `plant-bench score --routes` takes."""
    from plant_bench.reports.tables import print_rows
    from plant_bench.towns.route_image import save_suite_pictures
    from plant_bench.towns.routes import describe_suite
    from plant_bench.world.route import load_suite

    routes = load_suite(suite)
    frame = describe_suite(routes)
    heads = [str(column).replace("_", " ") for column in frame.columns]
    rows = [[number, *row] for number, row in enumerate(frame.itertuples(index=False))]
    print_rows(f"Suite {suite}", ["number", *heads], rows)
    if pictures is not None:
        pictures.mkdir(parents=True, exist_ok=True)
        save_suite_pictures(routes, pictures)
        typer.echo(f"Pictures are in {pictures}.")
