"""`plant-bench routes`: builds, checks and lists route suites."""

from pathlib import Path
from typing import Annotated

import typer

from plant_bench.api.numbers import HIGHEST_SEED
from plant_bench.cli.number_options import number_option
from plant_bench.cli.options import SuiteOption, check_build_options

routes_app = typer.Typer(
    no_args_is_help=True, help="Build, check (build --check) and list the routes."
)


@routes_app.command("build")
def build(
    suite: Annotated[
        str | None,
        typer.Option(help="Name of the suite. Default: longest6; with --check: all suites."),
    ] = None,
    town: Annotated[
        list[str] | None,
        typer.Option(help="Build only this town's routes. Repeat the option for several."),
    ] = None,
    seed: Annotated[
        int | None, number_option("Seed for other routes of the same kind.", 0, HIGHEST_SEED)
    ] = None,
    out: Annotated[
        Path | None, typer.Option(help="Output folder, instead of the suite's own.")
    ] = None,
    check: Annotated[
        bool, typer.Option("--check", help="Check the existing routes; write nothing.")
    ] = False,
) -> None:
    """Choose the routes of a suite again; the same seed gives the same routes.

    Example commands:

        plant-bench routes build --check

        plant-bench routes build --seed 7 --out my_routes
    """
    from plant_bench.towns.routes import SUITES, build_suite, check_suite

    check_build_options(seed, out, check=check)
    if not check:
        name = suite or "longest6"
        typer.echo(f"{name}: {build_suite(name, towns=town, seed=seed, out=out)}")
        return
    faults: list[str] = []
    for name in [suite] if suite is not None else SUITES:
        suite_faults = check_suite(name)
        faults.extend(suite_faults)
        typer.echo(f"{name}: {f'{len(suite_faults)} faults' if suite_faults else 'valid'}")
    for fault in faults:
        typer.echo(fault, err=True)
    if faults:
        raise typer.Exit(1)


@routes_app.command("list")
def list_routes(
    suite: SuiteOption = "longest6",
    pictures: Annotated[
        Path | None, typer.Option(help="Folder in which to save an image of each route.")
    ] = None,
) -> None:
    """List the routes of a suite, with the numbers for `plant-bench score --routes`."""
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
