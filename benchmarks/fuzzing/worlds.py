"""Fuzzing of routes and towns: valid files and their readers."""

import functools
import json
from dataclasses import replace
from pathlib import Path

import numpy as np

from fuzzing.form import Format, used
from plant_bench.data_files import networks_dir
from plant_bench.towns.routes import suite_text
from plant_bench.world.route import Route, load_suite
from plant_bench.world.town import Town, load_town


def _route_seeds() -> list[bytes]:
    suite = load_suite("longest6")
    short = [replace(suite[place], **first_metres(suite[place], 60)) for place in (0, 13, 20)]
    return [suite_text({"suite": "f"}, short[:1]).encode(), suite_text({}, short).encode()]


def first_metres(route: Route, metres: int) -> dict[str, np.ndarray]:
    """Return what makes a route a short one: its first points, a metre apart."""
    return {
        "points": route.points[:metres],
        "elevations": route.elevations[:metres],
        "speed_limits": route.speed_limits[:metres],
    }


@functools.cache
def _known_town(name: str) -> Town:
    return load_town(name)


def _use_routes(box: Path) -> None:
    for route in load_suite(str(box / "routes.json")):
        used(route.checksum)
        used(len(route.headings) == len(route.along))
        used(route.plan.length > 0)
        used(len(route.signal_entries) == len(route.signal_passages))
        route.check_town(_known_town(route.town))


def _town_seeds() -> list[bytes]:
    town = json.loads((networks_dir() / "town02" / "town.json").read_text(encoding="utf-8"))
    lanes = town["lanes"][:12]
    kept = {lane["id"] for lane in lanes}
    for lane in lanes:
        lane["successors"] = [name for name in lane["successors"] if name in kept]
        lane["left"], lane["right"] = (
            name if name in kept else None for name in (lane["left"], lane["right"])
        )
    links = [
        link for link in town["links"] if {link["source"], link["target"], *link["via"]} <= kept
    ]
    small = town | {"lanes": lanes, "links": links, "areas": town["areas"][:5]}
    return [json.dumps(small).encode()]


def _use_town(box: Path) -> None:
    town = load_town("fuzzed", [box / "towns"])
    used(town.edges is not None)
    used(town.links_from is not None)
    used(town.extent)
    used(town.lane_km >= 0.0)
    town.to_json()


def _spec_seeds() -> list[bytes]:
    return [path.read_bytes() for path in sorted(networks_dir().glob("town0[12]/spec.toml"))]


def _use_spec(box: Path) -> None:
    from plant_bench.towns.town_spec import read_spec

    read_spec(box / "spec.toml")


FORMATS = (
    Format("routes", "json", "routes.json", _route_seeds, _use_routes),
    Format("town", "json", "towns/fuzzed/town.json", _town_seeds, _use_town),
    Format("spec", "bytes", "spec.toml", _spec_seeds, _use_spec),
)
