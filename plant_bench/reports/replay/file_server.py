"""A small server of files on this machine alone, for browsers that do not open pages from disk."""

import errno
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

from plant_bench.errors import InputError

HOST = "127.0.0.1"


class _Handler(SimpleHTTPRequestHandler):
    """Serves files; says nothing of each, and lets browsers ask again for what may change."""

    def log_message(self, format: str, *args: object) -> None:
        """Stay silent."""

    def end_headers(self) -> None:
        """Add what keeps a browser from showing yesterday's replay."""
        self.send_header("Cache-Control", "no-cache")
        super().end_headers()


def file_server(folder: Path, port: int) -> ThreadingHTTPServer:
    """Return a server of a folder that is ready to be run.

    Args:
        folder: What to serve.
        port: Of 127.0.0.1; 0 for any that is free.

    Raises:
        InputError: There is no such folder, or the port cannot be used.
    """
    if not folder.is_dir():
        message = f"There is no folder {folder}. Give one that `plant-bench report` wrote."
        raise InputError(message)
    try:
        return ThreadingHTTPServer((HOST, port), partial(_Handler, directory=str(folder)))
    except (OSError, OverflowError) as error:
        busy = getattr(error, "errno", None) == errno.EADDRINUSE
        why = "is in use" if busy else f"cannot be used ({error})"
        message = f"Port {port} {why}. Choose another with --port, or 0 for any that is free."
        raise InputError(message) from error


def address_of(server: ThreadingHTTPServer, folder: Path) -> str:
    """Return the address of a server's page: the leaderboard where there is one."""
    pages = [name for name in ("leaderboard.html", "replay.html") if (folder / name).is_file()]
    return f"http://{HOST}:{server.server_address[1]}/{pages[0] if pages else ''}"
