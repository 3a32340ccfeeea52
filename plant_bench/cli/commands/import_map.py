"""`plant-bench import`."""

from pathlib import Path
from typing import Annotated

import typer

from plant_bench.cli.options import OverwriteOption
from plant_bench.cli.progress import ending_at_ctrl_c


def import_town(
    file: Annotated[Path, typer.Argument(help="map.net.xml, map.xodr or map.osm; also as .gz.")],
    name: Annotated[str, typer.Option(help="The town's name.")],
    out: Annotated[
        Path | None, typer.Option(help="Folder to write to; ./NAME without it. May hold others.")
    ] = None,
    routes: Annotated[int, typer.Option(help="Routes to choose, where there are as many.")] = 6,
    min_length: Annotated[float, typer.Option(help="Of a route, metres.")] = 400.0,
    max_length: Annotated[float, typer.Option(help="Of a route, metres.")] = 1500.0,
    seed: Annotated[int, typer.Option(help="Of routes and hazards.", min=0)] = 0,
    hazards: Annotated[bool, typer.Option(help="Place hazards on the routes.")] = True,
    guess_signals: Annotated[
        bool, typer.Option("--guess-signals", help="Put signals at junctions that seem to need it.")
    ] = False,
    overwrite: OverwriteOption = False,
) -> None:
    """Make a town of a map, with routes through it, and say what could not be driven.

    For instance:

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
    wanted = RouteRequest(routes, min_length, max_length, seed, hazards)
    with ending_at_ctrl_c("Stopped. Nothing was written."):
        made = make_imported_town(file, name, wanted, guess_signals=guess_signals, say=_say)
        about = {"file": file.name, "seed": seed, "guess_signals": guess_signals}
        suite = save_imported_town(made, folder, about, overwrite=overwrite)
    print_rows(f"Town {name}", list(HEADS), finding_rows(made.findings))
    if len(made.routes) < routes:
        typer.echo(f"Only {len(made.routes)} different routes of {routes} were found.", err=True)
    typer.echo(f"{name}: {made.town.lane_km:.1f} km of lanes, {len(made.routes)} routes")
    typer.echo(f"Drive it: plant-bench score --suite {suite} --agent expert")


def _say(what: str) -> None:
    typer.echo(f"{what}...", err=True)
