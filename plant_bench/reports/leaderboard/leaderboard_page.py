"""Writes the leaderboard page: one self-contained HTML file that loads nothing else."""

import base64
import hashlib
import re
from importlib.resources import files
from importlib.resources.abc import Traversable
from pathlib import Path

from plant_bench.atomic_files import write_whole_text
from plant_bench.reports.leaderboard.board import Leaderboard
from plant_bench.reports.leaderboard.leaderboard_data import page_json
from plant_bench.reports.page_scripts import page_script

PAGE = "leaderboard.html"
_REPORTS = files("plant_bench.reports")
_FOLDER = _REPORTS / "leaderboard"


def write_page(leaderboard: Leaderboard, out: Path, *, replays: bool) -> Path:
    """Write the page.

    Args:
        leaderboard: The leaderboard.
        out: Folder of the leaderboard.
        replays: Whether episodes with a recording have a replay beside the page.

    Raises:
        OSError: It cannot be written.
    """
    path = out / PAGE
    write_whole_text(path, page_html(leaderboard, replays=replays))
    return path


def page_html(leaderboard: Leaderboard, *, replays: bool) -> str:
    """Return the page; its Content-Security-Policy allows only its own scripts, by hash."""
    scripts = {
        "THEME": page_script("theme"),
        "MAIN": page_script("leaderboard"),
    }
    parts = scripts | {
        "POLICY": _policy(list(scripts.values())),
        "STYLE": _text(_REPORTS / "templates" / "theme.css")
        + _text(_FOLDER / "templates" / "page.css"),
        "DATA": page_json(leaderboard, replays=replays),
    }
    template = _text(_FOLDER / "templates" / "page.html")
    return re.sub(r"@@([A-Z0-9]+)@@", lambda found: parts[found[1]], template)


def _policy(scripts: list[str]) -> str:
    """Return a Content-Security-Policy that allows these scripts only, and no connections."""
    digests = (hashlib.sha256(script.encode()).digest() for script in scripts)
    allowed = " ".join(f"'sha256-{base64.b64encode(digest).decode()}'" for digest in digests)
    return (
        f"default-src 'none'; script-src {allowed}; style-src 'unsafe-inline'; img-src data:; "
        "base-uri 'none'; form-action 'none'"
    )


def _text(file: Traversable) -> str:
    return file.read_text(encoding="utf-8")
