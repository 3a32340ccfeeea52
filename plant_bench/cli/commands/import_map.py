"""`plant-bench import`: makes a town with routes from a map file."""

from pathlib import Path
from typing import Annotated

import typer

from plant_bench.api.numbers import HIGHEST_SEED
from plant_bench.cli.number_options import number_option
from plant_bench.cli.options import OverwriteOption
from plant_bench.cli.progress import exit_on_ctrl_c


def import_town(
    file: Annotated[Path, typer.Argument(help="Map file: .net.xml, .xodr or .osm, also .gz.")],
    name: Annotated[str, typer.Option(help="Name of the town.")],
    out: Annotated[
        Path | None,
        typer.Option(help="Output folder; it may hold other towns. Default: ./NAME."),
    ] = None,
    routes: Annotated[
        int, number_option("Number of routes; fewer if the map is small.", 1, 200)
    ] = 6,
    min_length: Annotated[
        float, number_option("Minimum length of a route, metres.", 100.0, 50_000.0)
    ] = 400.0,
    max_length: Annotated[
        float, number_option("Maximum length of a route, metres.", 100.0, 50_000.0)
    ] = 1500.0,
    seed: Annotated[int, number_option("Seed of routes and hazards.", 0, HIGHEST_SEED)] = 0,
    hazards: Annotated[bool, typer.Option(help="Place hazards on the routes.")] = True,
    guess_signals: Annotated[
        bool,
        typer.Option(
            "--guess-signals", help="Add traffic lights at junctions that seem to need them."
        ),
    ] = False,
    overwrite: OverwriteOption = False,
) -> None:
    """Make a town with routes from a map, and list the parts that were changed or removed.

    Example commands:

        plant-bench import map.osm --name mytown

        plant-bench score --suite mytown/routes --agent expert
    """
    from plant_bench.reports.tables import print_rows
    from plant_bench.towns.importing.import_report import HEADS, finding_rows
    from plant_bench.towns.importing.suite_making import RouteRequest
    from plant_bench.towns.importing.town_making import (
        check_name,
        make_imported_town,
        refuse_existing,
        save_imported_town,
    )

    check_name(name)
    folder = out if out is not None else Path(name)
    refuse_existing(folder, name, overwrite=overwrite)
    request = RouteRequest(routes, min_length, max_length, seed, hazards)
    with exit_on_ctrl_c("Stopped. Nothing was written."):
        made = make_imported_town(file, name, request, guess_signals=guess_signals, say=_print_step)
        origin = {"file": file.name, "seed": seed, "guess_signals": guess_signals}
        suite = save_imported_town(made, folder, origin, overwrite=overwrite)
    print_rows(f"Town {name}", list(HEADS), finding_rows(made.findings))
    if len(made.routes) < routes:
        typer.echo(
            f"Expected {routes} routes, found {len(made.routes)}: the map has no more distinct "
            "routes of this length.",
            err=True,
        )
    typer.echo(f"{name}: {made.town.lane_km:.1f} km of lanes, {len(made.routes)} routes")
    typer.echo(f"To drive it: plant-bench score --suite {suite} --agent expert")


def _print_step(step: str) -> None:
    typer.echo(f"{step}...", err=True)
