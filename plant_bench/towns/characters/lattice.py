"""Lays out a grid town with signalled crossroads and blocks of uneven size."""

import numpy as np

from plant_bench.towns.street_map import EAST, NORTH, StreetMap
from plant_bench.towns.street_plan import StreetPlan
from plant_bench.towns.town_spec import LatticeLayout, TownSpec
from plant_bench.towns.turns import connect_junction


def lay_out_lattice(spec: TownSpec, rng: np.random.Generator) -> StreetPlan:
    """Lay out a town of columns and rows of streets."""
    layout = spec.layout
    if not isinstance(layout, LatticeLayout):
        raise TypeError(f"A lattice town needs a LatticeLayout, found {type(layout).__name__}.")
    streets = lattice_streets(spec, layout, rng)
    streets.dissolve_bends()
    quiet = quiet_places(streets, layout.unsignalled, rng)
    for name in streets.places:
        control = spec.junctions.unsignalled if name in quiet else "traffic_light"
        streets.control(name, control, spec.junctions.radius)
    plan = StreetPlan()
    streets.draw_on(plan, spec)
    for name in streets.places:
        connect_junction(plan, name)
    return plan


def lattice_streets(spec: TownSpec, layout: LatticeLayout, rng: np.random.Generator) -> StreetMap:
    """Return the streets of the grid, with some omitted and the junctions moved a little."""
    streets = StreetMap(layout.corner_radius)
    across = spread(spec.extent[0], layout.columns, layout.jitter, rng)
    up = spread(spec.extent[1], layout.rows, layout.jitter, rng)
    for column, x in enumerate(across):
        for row, y in enumerate(up):
            wobble = rng.uniform(-layout.jitter / 2, layout.jitter / 2, 2)
            inner = (0 < column < layout.columns - 1, 0 < row < layout.rows - 1)
            dx, dy = wobble * inner
            streets.place(f"c{column}r{row}", x + dx, y + dy)
    avenue_rows = set(rng.permutation(np.arange(1, layout.rows - 1))[: layout.avenues].tolist())
    missing = _missing(layout, avenue_rows, rng)
    for column in range(layout.columns):
        for row in range(layout.rows):
            here = f"c{column}r{row}"
            east, north = f"c{column + 1}r{row}", f"c{column}r{row + 1}"
            if column + 1 < layout.columns and (here, east) not in missing:
                kind = "avenue" if row in avenue_rows else "street"
                streets.link(here, east, EAST, EAST, kind)
            if row + 1 < layout.rows and (here, north) not in missing:
                streets.link(here, north, NORTH, NORTH, "street")
    return streets


def spread(length: float, count: int, jitter: float, rng: np.random.Generator) -> list[float]:
    """Return positions from 0 to `length`, equidistant apart from a jitter of the inner ones."""
    even = np.linspace(0.0, length, count)
    moved = even + rng.uniform(-jitter, jitter, count)
    return [0.0, *moved[1:-1].tolist(), length]


def quiet_places(streets: StreetMap, count: int, rng: np.random.Generator) -> set[str]:
    """Choose the T-junctions that get no signals."""
    small = sorted(name for name in streets.places if streets.degree(name) == 3)
    return {small[i] for i in rng.permutation(len(small))[:count]}


def _missing(
    layout: LatticeLayout, avenue_rows: set[int], rng: np.random.Generator
) -> set[tuple[str, str]]:
    """Choose inner streets to omit, at most one at each junction."""
    inner = [
        (f"c{c}r{r}", f"c{c + 1}r{r}")
        for c in range(layout.columns - 1)
        for r in range(1, layout.rows - 1)
        if r not in avenue_rows
    ]
    inner += [
        (f"c{c}r{r}", f"c{c}r{r + 1}")
        for c in range(1, layout.columns - 1)
        for r in range(layout.rows - 1)
    ]
    chosen: set[tuple[str, str]] = set()
    touched: set[str] = set()
    for index in rng.permutation(len(inner)):
        if len(chosen) < layout.missing and not touched & set(inner[index]):
            chosen.add(inner[index])
            touched |= set(inner[index])
    return chosen
