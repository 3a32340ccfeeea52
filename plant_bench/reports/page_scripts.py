"""Scripts of the HTML pages: bundles that `web/` builds, committed in the folder `bundles`."""

from functools import cache
from importlib.resources import files


@cache
def page_script(name: str) -> str:
    """Return a bundle, a classic script that needs no other.

    Args:
        name: "theme", "leaderboard" or "replay".
    """
    return (files("plant_bench.reports") / "bundles" / f"{name}.min.js").read_text(encoding="utf-8")
