"""`plant-bench import` and `plant-bench import-routes`."""

from pathlib import Path
from typing import Annotated

import typer

from plant_bench.cli.interrupts import ending_at_ctrl_c
from plant_bench.cli.options import OverwriteOption


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
    from plant_bench.towns.importing.report import HEADS, finding_rows
    from plant_bench.towns.importing.suite_making import RoutesWanted
    from plant_bench.towns.importing.town_making import (
        check_name,
        make_imported_town,
        refuse_existing,
        save_imported_town,
    )

    check_name(name)
    folder = out if out is not None else Path(name)
    refuse_existing(folder, name, overwrite=overwrite)
    wanted = RoutesWanted(routes, min_length, max_length, seed, hazards)
    with ending_at_ctrl_c("Stopped. Nothing was written."):
        made = make_imported_town(file, name, wanted, guess_signals=guess_signals, say=_say)
        about = {"file": file.name, "seed": seed, "guess_signals": guess_signals}
        suite = save_imported_town(made, folder, about, overwrite=overwrite)
    print_rows(f"Town {name}", list(HEADS), finding_rows(made.findings))
    if len(made.routes) < routes:
        typer.echo(f"Only {len(made.routes)} different routes of {routes} were found.", err=True)
    typer.echo(f"{name}: {made.town.lane_km:.1f} km of lanes, {len(made.routes)} routes")
    typer.echo(f"Drive it: plant-bench score --suite {suite} --agent expert")


def import_routes(
    file: Annotated[Path, typer.Argument(help="A route file of CARLA's leaderboard, 1.0 or 2.0.")],
    town_map: Annotated[
        list[str],
        typer.Option(help="TOWN=OURS: CARLA's name and ours, or a town's folder. Once for each."),
    ],
    out: Annotated[Path, typer.Option(help="The suite's folder; towns beside it are found.")],
    limit_distance: Annotated[
        float, typer.Option(help="Metres that a point may be from the matched lanes.", min=0.01)
    ] = 1.5,
    seed: Annotated[int, typer.Option(help="Of the hazards.", min=0)] = 0,
    hazards: Annotated[bool, typer.Option(help="Place hazards on the routes.")] = True,
    overwrite: OverwriteOption = False,
) -> None:
    """Put CARLA's routes onto imported towns; exit code 1 if a route does not fit.

    For instance:

        plant-bench import Town01.xodr --name carla01 --out carla

        plant-bench import-routes longest6.xml --town-map Town01=carla01 --out carla/longest6

        plant-bench score --suite carla/longest6 --agent expert
    """
    from plant_bench.reports.tables import print_rows
    from plant_bench.towns.importing.carla_routes import read_carla_routes
    from plant_bench.towns.importing.matched_suite import refuse_existing, save_matches
    from plant_bench.towns.importing.route_import import (
        HEADS,
        find_towns,
        match_routes,
    )

    refuse_existing(out, overwrite=overwrite)
    routes = read_carla_routes(file)
    towns = find_towns(_pairs(town_map), out)
    with ending_at_ctrl_c("Stopped. Nothing was written."):
        matches = match_routes(routes, towns, limit_distance, _say)
        print_rows(f"Routes of {file.name}", list(HEADS), [match.row for match in matches])
        count = save_matches(
            matches, list(towns.values()), out, seed=seed if hazards else None, overwrite=overwrite
        )
    typer.echo(f"{count} of {len(matches)} routes are matched within {limit_distance:g} m.")
    if count:
        typer.echo(f"Drive them: plant-bench score --suite {out} --agent expert")
    if count < len(matches):
        raise typer.Exit(1)


def _pairs(town_map: list[str]) -> dict[str, str]:
    from plant_bench.errors import InputError

    pairs: dict[str, str] = {}
    for given in (part for item in town_map for part in item.split()):
        carla, sign, ours = given.partition("=")
        if not (carla and sign and ours) or carla in pairs:
            message = f"--town-map {given[:60]!r}: TOWN=OURS is wanted, once a town: Town01=mytown."
            raise InputError(message)
        pairs[carla] = ours
    return pairs


def _say(what: str) -> None:
    typer.echo(f"{what}...", err=True)
