"""Lays out a larger town with avenues, side streets, a roundabout and a five-way junction."""

import numpy as np

from plant_bench.towns.characters.lattice import spread
from plant_bench.towns.roundabout import Roundabout, add_roundabout
from plant_bench.towns.street_map import EAST, NORTH, SOUTH, WEST, StreetMap
from plant_bench.towns.street_plan import StreetPlan
from plant_bench.towns.town_spec import LargeTownLayout, TownSpec
from plant_bench.towns.turns import connect_junction

SIDE = 4
RING, FIVE_WAY, DIAGONAL_END = "c1r2", "c2r1", "diagonal"
RING_ARMS = {"ring_e": EAST, "ring_n": NORTH, "ring_w": WEST, "ring_s": SOUTH}
FIVE_ARMS = {EAST: 18, NORTH: 90, WEST: 162, SOUTH: 234}
DIAGONAL_ARM = 306
AVENUE_COLUMN, AVENUE_ROWS = 1, (1, 2)
LIGHTS = (FIVE_WAY, "c1r1", "c2r2", "c1r0", "c0r2", "c1r3", "c3r1", "c3r2")
LEFT_OUT = (("c1r0", "c1r1"), ("c2r2", "c2r3"), ("c1r3", "c2r3"))


def lay_out_large_town(spec: TownSpec, rng: np.random.Generator) -> StreetPlan:
    """Lay out a larger town, rotated by a random number of quarter turns."""
    layout = spec.layout
    if not isinstance(layout, LargeTownLayout):
        raise TypeError(f"A large town needs a LargeTownLayout, found {type(layout).__name__}.")
    streets = StreetMap(layout.corner_radius)
    _place_all(streets, spec, layout, rng)
    _link_all(streets, float(np.radians(rng.uniform(-5, 5))), rng)
    quarters = int(rng.integers(0, 4))
    streets.turn_quarters(quarters, (spec.extent[0] / 2, spec.extent[1] / 2))
    arms = {name: angle + quarters * np.pi / 2 for name, angle in RING_ARMS.items()}
    hub = streets.places[RING]
    ring = Roundabout("ring", (hub.x, hub.y), layout.ring_radius, arms)
    streets.dissolve_bends()
    for name in streets.places:
        _set_control(streets, name, spec, layout)
    plan = StreetPlan()
    streets.draw_on(plan, spec)
    add_roundabout(plan, spec, ring)
    for name in streets.places:
        if name not in arms:
            connect_junction(plan, name)
    return plan


def _place_all(
    streets: StreetMap, spec: TownSpec, layout: LargeTownLayout, rng: np.random.Generator
) -> None:
    across = spread(spec.extent[0], SIDE, layout.jitter, rng)
    up = spread(spec.extent[1], SIDE, layout.jitter, rng)
    for column, x in enumerate(across):
        for row, y in enumerate(up):
            streets.place(f"c{column}r{row}", x, y)
    streets.place(DIAGONAL_END, across[-1], up[1] * float(rng.uniform(0.46, 0.52)))
    ring = Roundabout("ring", (across[1], up[2]), layout.ring_radius, RING_ARMS)
    for arm in RING_ARMS:
        mouth = ring.mouth(arm)
        streets.place(arm, mouth.x, mouth.y)


def _link_all(streets: StreetMap, lean: float, rng: np.random.Generator) -> None:
    left_out = LEFT_OUT[int(rng.integers(0, len(LEFT_OUT)))]
    for column in range(SIDE):
        for row in range(SIDE):
            here = f"c{column}r{row}"
            east, north = f"c{column + 1}r{row}", f"c{column}r{row + 1}"
            row_class = "avenue" if row in AVENUE_ROWS else "main"
            column_class = "avenue" if column == AVENUE_COLUMN else "street"
            if column in (0, SIDE - 1):
                column_class = "main"
            if column + 1 < SIDE and left_out not in ((here, east), (east, here)):
                _link(streets, here, east, EAST, row_class, lean)
            if row + 1 < SIDE and left_out not in ((here, north), (north, here)):
                if east_side := (here == f"c{SIDE - 1}r0"):
                    _link(streets, here, DIAGONAL_END, NORTH, column_class, lean)
                start = DIAGONAL_END if east_side else here
                _link(streets, start, north, NORTH, column_class, lean)
    leave = float(np.radians(DIAGONAL_ARM)) + lean
    streets.link(FIVE_WAY, DIAGONAL_END, leave, EAST, "street")


def _link(
    streets: StreetMap, start: str, end: str, heading: float, road_class: str, lean: float
) -> None:
    """Add a street of the grid, bent at the five-way junction and cut off at the roundabout."""
    leave = arrive = heading
    if start == FIVE_WAY:
        leave = float(np.radians(FIVE_ARMS[heading])) + lean
    if end == FIVE_WAY:
        back = WEST if heading == EAST else SOUTH
        arrive = float(np.radians(FIVE_ARMS[back])) + np.pi + lean
    if start == RING:
        start = "ring_e" if heading == EAST else "ring_n"
    if end == RING:
        end = "ring_w" if heading == EAST else "ring_s"
    streets.link(start, end, leave, arrive, road_class)


def _set_control(streets: StreetMap, name: str, spec: TownSpec, layout: LargeTownLayout) -> None:
    """Set signals at junctions with much traffic, elsewhere signs or right before left."""
    if name == FIVE_WAY:
        # SUMO cannot place detectors for all phases of five arms, so these signals are fixed-time.
        radius = layout.five_way_radius
        streets.control(name, "traffic_light", radius, crossings=False, fixed_time=True)
    elif name in RING_ARMS:
        streets.control(name, "priority", 9.0, crossings=False)
    elif name in LIGHTS:
        streets.control(name, "traffic_light", spec.junctions.radius)
    elif name == "c0r1":
        streets.control(name, "allway_stop", spec.junctions.radius)
    elif name == DIAGONAL_END:
        streets.control(name, "priority_stop", spec.junctions.radius)
    else:
        streets.control(name, spec.junctions.unsignalled, spec.junctions.radius)
