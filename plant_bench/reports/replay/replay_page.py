"""Builds the HTML of the replay page from its templates; scripts beside it hold the data."""

import json
import re
from functools import cache
from pathlib import Path

from plant_bench.reports.page_scripts import page_script
from plant_bench.text_escaping import script_json

TEMPLATES = Path(__file__).parent / "templates"
SHARED = Path(__file__).parents[1] / "templates"


@cache
def palette() -> dict[str, dict[str, str]]:
    """Return the colour schemes "light" and "dark", which images and pages share."""
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
