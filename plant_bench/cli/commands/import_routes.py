"""`plant-bench import-routes`: maps routes of CARLA's leaderboard onto imported towns."""

from pathlib import Path
from typing import Annotated

import typer

from plant_bench.api.numbers import HIGHEST_SEED
from plant_bench.cli.number_options import number_option
from plant_bench.cli.options import OverwriteOption
from plant_bench.cli.progress import exit_on_ctrl_c


def import_routes(
    file: Annotated[Path, typer.Argument(help="Route file of CARLA's leaderboard, 1.0 or 2.0.")],
    town_map: Annotated[
        list[str],
        typer.Option(
            help="CARLA_TOWN=TOWN: name of CARLA's town, and name or folder of the imported one; "
            "=TOWN for routes that name no town. Repeat the option for each town."
        ),
    ],
    out: Annotated[
        Path,
        typer.Option(
            help="Folder of the new suite. Imported towns are found by name if they are in a "
            "folder named `towns` inside or beside it."
        ),
    ],
    limit_distance: Annotated[
        float,
        number_option("Maximum distance of a point from the driven line, metres.", 0.01, 1000.0),
    ] = 1.8,
    seed: Annotated[int, number_option("Seed of the hazards.", 0, HIGHEST_SEED)] = 0,
    hazards: Annotated[bool, typer.Option(help="Place hazards on the routes.")] = True,
    overwrite: OverwriteOption = False,
) -> None:
    """Match CARLA's routes to the lanes of imported towns.

    Exit code 1 if a route does not match.

    Example commands:

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
    with exit_on_ctrl_c("Stopped. Nothing was written."):
        matches = match_routes(routes, towns, limit_distance, _print_step)
        print_rows(f"Routes of {file.name}", list(HEADS), [match.row for match in matches])
        count = save_matches(
            matches, list(towns.values()), out, seed=seed if hazards else None, overwrite=overwrite
        )
    typer.echo(f"{count} of {len(matches)} routes match within {limit_distance:g} m.")
    if count:
        typer.echo(f"To drive them: plant-bench score --suite {out} --agent expert")
    if count < len(matches):
        raise typer.Exit(1)


def _pairs(town_map: list[str]) -> dict[str, str]:
    from plant_bench.errors import InputError

    pairs: dict[str, str] = {}
    for argument in (part for item in town_map for part in item.split()):
        carla, sign, town = argument.partition("=")
        if not (sign and town) or carla in pairs:
            message = (
                "--town-map: expected CARLA_TOWN=TOWN once per town, as in Town01=mytown, or =TOWN "
                f"for routes that name no town, got {argument[:60]!r}."
            )
            raise InputError(message)
        pairs[carla] = town
    return pairs


def _print_step(step: str) -> None:
    typer.echo(f"{step}...", err=True)
