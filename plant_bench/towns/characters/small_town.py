"""Lays out a small town with T-junctions only: rows of streets with staggered cross streets."""

import itertools

import numpy as np

from plant_bench.towns.characters.lattice import spread
from plant_bench.towns.street_map import EAST, NORTH, StreetMap
from plant_bench.towns.street_plan import StreetPlan
from plant_bench.towns.town_spec import SmallTownLayout, TownSpec
from plant_bench.towns.turns import connect_junction

ATTEMPTS = 200


def lay_out_small_town(spec: TownSpec, rng: np.random.Generator) -> StreetPlan:
    """Lay out a town in which every junction is a T-junction."""
    layout = spec.layout
    if not isinstance(layout, SmallTownLayout):
        raise TypeError(f"A small town needs a SmallTownLayout, found {type(layout).__name__}.")
    streets = _streets(spec, layout, rng)
    streets.dissolve_bends()
    names = sorted(streets.places)
    signalled = {names[i] for i in rng.permutation(len(names))[: layout.signalled]}
    for name in names:
        control = "traffic_light" if name in signalled else spec.junctions.unsignalled
        streets.control(name, control, spec.junctions.radius)
    plan = StreetPlan()
    streets.draw_on(plan, spec)
    for name in names:
        connect_junction(plan, name)
    return plan


def _streets(spec: TownSpec, layout: SmallTownLayout, rng: np.random.Generator) -> StreetMap:
    streets = StreetMap(layout.corner_radius)
    width, height = spec.extent
    heights = spread(height, layout.rows, layout.jitter, rng)
    links = _staggered(layout, width, rng)
    for row, y in enumerate(heights):
        below = links[row - 1] if row > 0 else []
        above = links[row] if row < len(links) else []
        stops = [("w", 0.0), *[(_name(x), x) for x in sorted(below + above)], ("e", width)]
        inner = 0 < row < layout.rows - 1
        for tag, x in stops:
            sway = rng.uniform(-0.4, 0.4) * layout.jitter if inner and tag not in "we" else 0.0
            streets.place(f"r{row}{tag}", x, y + sway)
        for (a, _), (b, _) in itertools.pairwise(stops):
            kind = "street" if inner else "main"
            streets.link(f"r{row}{a}", f"r{row}{b}", EAST, EAST, kind)
    for band, xs in enumerate(links):
        for x in xs:
            streets.link(f"r{band}{_name(x)}", f"r{band + 1}{_name(x)}", NORTH, NORTH, "street")
        for side in "we":
            streets.link(f"r{band}{side}", f"r{band + 1}{side}", NORTH, NORTH, "main")
    return streets


def _name(x: float) -> str:
    return f"x{round(x)}"


def _staggered(
    layout: SmallTownLayout, width: float, rng: np.random.Generator
) -> list[list[float]]:
    """Return x of the cross streets between rows; none is opposite one of the band below."""
    bands: list[list[float]] = []
    for _ in range(layout.rows - 1):
        count = int(rng.integers(layout.links_per_band[0], layout.links_per_band[1] + 1))
        bands.append(_places_apart(layout, count, width, bands[-1] if bands else [], rng))
    return bands


def _places_apart(
    layout: SmallTownLayout,
    count: int,
    width: float,
    taken: list[float],
    rng: np.random.Generator,
) -> list[float]:
    gap = layout.spacing_min
    best: list[float] = []
    for _ in range(ATTEMPTS):
        xs: list[float] = []
        for x in rng.uniform(gap, width - gap, 4 * count):
            clear = all(abs(x - other) >= gap for other in [*taken, *xs])
            if clear and len(xs) < count:
                xs.append(float(x))
        best = max(best, xs, key=len)
        if len(best) == count:
            break
    return sorted(best)
