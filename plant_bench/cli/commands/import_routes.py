"""`plant-bench import-routes`."""

from pathlib import Path
from typing import Annotated

import typer

from plant_bench.cli.options import OverwriteOption
from plant_bench.cli.progress import ending_at_ctrl_c


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
