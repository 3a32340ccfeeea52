"""A local HTTP file server, for browsers that do not open replay pages from disk."""

import errno
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

from plant_bench.errors import InputError

HOST = "127.0.0.1"


class _Handler(SimpleHTTPRequestHandler):
    """Serves files without logging requests, and makes browsers revalidate their cache."""

    def log_message(self, format: str, *args: object) -> None:
        """Do not log."""

    def end_headers(self) -> None:
        """Add a header that keeps browsers from showing an outdated replay."""
        self.send_header("Cache-Control", "no-cache")
        super().end_headers()


def file_server(folder: Path, port: int) -> ThreadingHTTPServer:
    """Return a server of a folder, ready to run.

    Args:
        folder: The folder to serve.
        port: Port on 127.0.0.1; 0 for any free port.

    Raises:
        InputError: There is no such folder, or the port cannot be used.
    """
    if not folder.is_dir():
        message = f"There is no folder {folder}. Give one written by `plant-bench report`."
        raise InputError(message)
    try:
        return ThreadingHTTPServer((HOST, port), partial(_Handler, directory=str(folder)))
    except (OSError, OverflowError) as error:
        busy = getattr(error, "errno", None) == errno.EADDRINUSE
        why = "is in use" if busy else f"cannot be used ({error})"
        message = f"Port {port} {why}. Choose another with --port, or 0 for any free port."
        raise InputError(message) from error


def address_of(server: ThreadingHTTPServer, folder: Path) -> str:
    """Return the address of a server's page: the leaderboard if there is one."""
    pages = [name for name in ("leaderboard.html", "replay.html") if (folder / name).is_file()]
    return f"http://{HOST}:{server.server_address[1]}/{pages[0] if pages else ''}"
