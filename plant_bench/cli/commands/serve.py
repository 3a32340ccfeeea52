"""`plant-bench serve`."""

from pathlib import Path
from typing import Annotated

import typer

from plant_bench.cli.progress import ending_at_ctrl_c


def serve(
    folder: Annotated[Path, typer.Argument(help="A folder of pages.")],
    port: Annotated[int, typer.Option(help="0 takes any that is free.", min=0, max=65535)] = 8000,
) -> None:
    """Serve a folder of pages to browsers on this machine, until Ctrl-C.

    The pages work from disk as well; this is for browsers that do not let them.

    For instance:

        plant-bench serve reports/leaderboard
    """
    from plant_bench.reports.replay.file_server import address_of, file_server

    with file_server(folder, port) as server:
        typer.echo(f"Serving {folder} at {address_of(server, folder)} (Ctrl-C ends it).")
        with ending_at_ctrl_c():
            server.serve_forever()
