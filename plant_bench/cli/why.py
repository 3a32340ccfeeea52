"""`plant-bench why`."""

from pathlib import Path
from typing import Annotated

import typer

from plant_bench.cli.interrupts import ending_at_ctrl_c


def explain_run(
    run: Annotated[Path, typer.Argument(help="A folder that `plant-bench score` wrote.")],
    route: Annotated[
        str | None, typer.Argument(help="Its id or number; without it, all infractions are listed.")
    ] = None,
    repetition: Annotated[
        int | None, typer.Option(help="All with infractions without it.", min=0)
    ] = None,
    out: Annotated[
        Path | None, typer.Option(help="A PNG file or a folder for pictures; RUN/why without it.")
    ] = None,
    before: Annotated[
        float, typer.Option(help="Seconds to look at before each.", min=0.5, max=60.0)
    ] = 4.0,
) -> None:
    """Say why it went wrong: the seconds before each infraction, and what the expert would do.

    The episode is simulated again with the recorded controls; whether the scenes are the recorded
    ones is checked at every tick. The expert, and the planner for its ranking, answer to them.

    For instance:

        plant-bench why reports/plant-longest6

        plant-bench why reports/plant-longest6 town03-1

        plant-bench why reports/plant-longest6 town03-1 --repetition 0 --out why.png
    """
    from plant_bench.cli.explaining import explain_route
    from plant_bench.reports.why.listing import print_infractions
    from plant_bench.runner.run.folder import RunFolder

    with ending_at_ctrl_c():
        folder = RunFolder.open(run)
        if route is None:
            print_infractions(folder.results(), str(run))
        else:
            explain_route(folder, route, repetition, out, before)
