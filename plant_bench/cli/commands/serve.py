"""`plant-bench serve`: a local web server for leaderboard and replay pages."""

from pathlib import Path
from typing import Annotated

import typer

from plant_bench.cli.number_options import number_option
from plant_bench.cli.progress import exit_on_ctrl_c


def serve(
    folder: Annotated[Path, typer.Argument(help="Folder of pages.")],
    port: Annotated[int, number_option("Port; 0 chooses a free one.", 0, 65535)] = 8000,
) -> None:
    """Serve a folder of pages to browsers on this machine, until Ctrl-C.

    The pages also open from disk; use this if your browser blocks local files.

    Example commands:

        plant-bench serve reports/leaderboard
    """
    from plant_bench.reports.replay.file_server import address_of, file_server

    with file_server(folder, port) as server:
        typer.echo(f"Serving {folder} at {address_of(server, folder)} (stop with Ctrl-C).")
        with exit_on_ctrl_c():
            server.serve_forever()
