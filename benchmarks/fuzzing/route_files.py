"""Fuzzing of CARLA route files on an imported town: valid files and their readers."""

from pathlib import Path

import numpy as np

from fuzzing.form import Format
from fuzzing.maps import check_suite, imported_town, net_seeds
from plant_bench.reports.tables import print_rows
from plant_bench.towns.importing.carla_routes import read_carla_routes
from plant_bench.towns.importing.matched_suite import save_matches
from plant_bench.towns.importing.route_import import HEADS as MATCH_HEADS
from plant_bench.towns.importing.route_import import TownFound, find_towns, match_routes
from plant_bench.towns.importing.town_making import save_imported_town
from plant_bench.world.route import Route


def _put_town(box: Path) -> None:
    about = {"file": "map.net.xml", "seed": 0, "guess_signals": False}
    save_imported_town(imported_town(), box / "ours", about, overwrite=True)


def _route_file_seeds() -> list[bytes]:
    (route,) = imported_town().routes
    old = [
        f'<waypoint pitch="0.0" roll="0.0" yaw="{-np.degrees(route.headings[at]):.1f}" '
        f"{_place(route, at)}/>"
        for at in _places(route)
    ]
    new = [f"<position {_place(route, at)}/>" for at in _places(route)]
    inside = f"<weathers/><waypoints>{''.join(new)}</waypoints><scenarios/>"
    return [
        f'<routes><route id="{number}" town="Town01">{points}</route></routes>'.encode()
        for number, points in enumerate(("".join(old), inside))
    ]


def _places(route: Route) -> list[int]:
    return [int(np.searchsorted(route.along, at)) for at in np.arange(0.0, route.length, 30.0)]


def _place(route: Route, at: int) -> str:
    x, y = route.points[at] - np.array(imported_town().offset)
    return f'x="{x:.2f}" y="{-y:.2f}" z="{route.elevations[at]:.2f}"'


def _use_route_file(box: Path) -> None:
    """Import a route file, as the command does; what was saved must load."""
    routes = read_carla_routes(box / "routes.xml")
    folder = box / "ours" / "towns" / "fuzzed"
    towns: dict[str, TownFound] = find_towns({"Town01": str(folder)}, box / "suite")
    matches = match_routes(routes, towns, 1.5, lambda _: None)
    print_rows("Routes", list(MATCH_HEADS), [match.row for match in matches])
    if save_matches(matches, list(towns.values()), box / "suite", seed=0, overwrite=True):
        check_suite(box / "suite", folder.parent)


def _put_routes(box: Path) -> None:
    _put_town(box)
    (box / "routes.xml").write_bytes(_route_file_seeds()[0])


FORMATS = (
    Format("carlaroutes", "xml", "routes.xml", _route_file_seeds, _use_route_file, _put_town),
    Format(
        "townnet", "xml", "ours/towns/fuzzed/town.net.xml", net_seeds, _use_route_file, _put_routes
    ),
)
