"""`plant-bench hazards`: lists the hazards of a suite."""

from pathlib import Path
from typing import Annotated

import typer

from plant_bench.cli.options import SuiteOption

hazards_app = typer.Typer(no_args_is_help=True, help="List the hazards on the routes.")


@hazards_app.callback()
def _hazards() -> None:
    """List the hazards on the routes."""


@hazards_app.command("list")
def list_hazards(
    suite: SuiteOption = "longest6",
    pictures: Annotated[
        Path | None, typer.Option(help="Folder in which to save a sketch of each kind.")
    ] = None,
) -> None:
    """List the kinds of hazards: what happens, CARLA's scenario type, count in the suite."""
    from collections import Counter

    from plant_bench.reports.tables import print_rows
    from plant_bench.world.hazard_table import HAZARDS
    from plant_bench.world.route import load_suite

    counts = Counter(hazard.kind for route in load_suite(suite) for hazard in route.hazards)
    rows = [
        [kind.value, facts.letter, facts.carla or "", counts[kind], facts.sentence]
        for kind, facts in HAZARDS.items()
    ]
    heads = ["hazard", "letter in images", "CARLA type", "count", "what happens"]
    print_rows(f"Hazards of {suite}: {counts.total()}", heads, rows)
    if pictures is not None:
        from plant_bench.towns.hazard_image import save_hazard_pictures

        save_hazard_pictures(pictures)
        typer.echo(f"Pictures are in {pictures}.")
