"""What a window of sumo-gui shows besides the traffic: the ego, its route and its hazards."""

from collections.abc import Sequence

import numpy as np
from jaxtyping import Float

from plant_bench.sim.sumo_library import libsumo

VIEW = "View #0"
SCHEME = "real world"
ZOOM = 900.0  # of the view; about 100 m around the ego
ROUTE_COLOUR, HAZARD_COLOUR = (40, 120, 255, 160), (230, 60, 30, 255)  # red, green, blue, alpha
EGO_COLOUR = (255, 40, 40, 255)
ROUTE_WIDTH = 0.6  # m
LAYER = 5.0  # above the roads, below vehicles


def mark_route(
    points: Float[np.ndarray, "points 2"], hazards: Sequence[tuple[str, float, float]]
) -> None:
    """Draw the route as a line, and each hazard (name, x, y) as a point with its name."""
    shape = [(float(x), float(y)) for x, y in points]
    libsumo.polygon.add("route", shape, ROUTE_COLOUR, False, "route", LAYER, ROUTE_WIDTH)
    for number, (name, x, y) in enumerate(hazards):
        libsumo.poi.add(f"{number} {name}", x, y, HAZARD_COLOUR, name, LAYER)


def follow(vehicle: str) -> None:
    """Let the view follow a vehicle, and colour it."""
    libsumo.vehicle.setColor(vehicle, EGO_COLOUR)
    libsumo.gui.setSchema(VIEW, SCHEME)
    libsumo.gui.trackVehicle(VIEW, vehicle)
    libsumo.gui.setZoom(VIEW, ZOOM)
