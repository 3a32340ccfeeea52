"""The page that plays replays: its parts put together into one file that needs nothing else."""

import json
import re
from functools import cache
from pathlib import Path

from plant_bench.foreign_text import script_json
from plant_bench.reports.page_scripts import page_script

TEMPLATES = Path(__file__).parent / "templates"
SHARED = Path(__file__).parents[1] / "templates"


@cache
def palette() -> dict[str, dict[str, str]]:
    """Return the colours of what is drawn, "light" and "dark"; pictures and pages share them."""
    return json.loads((TEMPLATES / "palette.json").read_text(encoding="utf-8"))


def replay_page() -> str:
    """Return the page as HTML."""
    parts = {
        "theme_css": (SHARED / "theme.css").read_text(encoding="utf-8"),
        "theme_js": page_script("theme"),
        "css": (TEMPLATES / "replay.css").read_text(encoding="utf-8"),
        "palette": script_json(palette()),
        "js": page_script("replay"),
    }
    page = (TEMPLATES / "replay.html").read_text(encoding="utf-8")
    return re.sub(r"\{\{(\w+)\}\}", lambda match: parts[match[1]], page)
