"""Lays out a figure-eight highway around a small town, with ramps and an interchange.

The two loops of the eight are circles; the larger one surrounds the town. Its counter-clockwise
carriageway is the outer one, with an interchange beyond a bridge; the inner one has ramps directly
from the town's streets.
"""

import itertools
from dataclasses import dataclass

import numpy as np

from plant_bench.towns.highway import (
    Branch,
    Carriageway,
    Leads,
    entry_shape,
    exit_shape,
    two_carriageways,
)
from plant_bench.towns.street_map import EAST, NORTH, SOUTH, WEST, StreetMap, add_street
from plant_bench.towns.street_plan import Edge, Node, StreetPlan
from plant_bench.towns.street_shapes import Pose, Shape, arc_lengths, resample, thin_out
from plant_bench.towns.town_spec import FigureEightLayout, TownSpec
from plant_bench.towns.turns import connect_junction

SLOPE_M = 190.0
FLAT_M = 28.0
LINK_SLOPE_M = 100.0
TERMINAL_OUT_M = 62.0
ARM_M = 4.0


@dataclass(frozen=True)
class _Eight:
    """The highway's reference line (n 3), the town's centre, and two angles, radians.

    The line meets the town's circle at the angle `enters` and leaves it at `leaves`.
    """

    line: Shape
    town: tuple[float, float]
    enters: float
    leaves: float


def lay_out_figure_eight(spec: TownSpec, rng: np.random.Generator) -> StreetPlan:
    """Lay out a figure-eight highway and the town within it."""
    layout = spec.layout
    if not isinstance(layout, FigureEightLayout):
        raise TypeError(f"A figure-eight needs a FigureEightLayout, found {type(layout).__name__}.")
    eight = _draw_eight(layout, spec, rng)
    highway = spec.road("highway")
    outer, inner = two_carriageways(eight.line, layout.median, highway, spec.lane_width)
    plan = StreetPlan()
    streets = _town_streets(layout, eight.town, rng)
    ramps = _inner_ramps(spec, layout, eight, inner, streets, rng)
    terminal, more = _interchange(spec, layout, eight, outer, rng)
    for way in (outer, inner):
        way.add_to(plan)
    for name in streets.places:
        radius = 10.0 if name in "nesw" else spec.junctions.radius
        streets.control(name, "traffic_light", radius)
    streets.draw_on(plan, spec)
    plan.add_node(terminal)
    line = _link_line(layout, streets.places["e"], terminal)
    add_street(plan, spec, "e", terminal.id, line, "link")
    for ramp in ramps + more:
        plan.add_edge(ramp)
    for way in (outer, inner):
        way.connect(plan)
    for name in (*streets.places, terminal.id):
        connect_junction(plan, name)
    return plan


def _draw_eight(layout: FigureEightLayout, spec: TownSpec, rng: np.random.Generator) -> _Eight:
    """Compute two circles and their inner tangents; the second tangent passes over the first."""
    large, small = layout.town_radius, layout.far_radius
    edge = layout.median / 2 + spec.road("highway").lanes * spec.lane_width
    tilt = float(np.radians(layout.tilt_deg + rng.uniform(-1.5, 1.5)))
    apart = spec.extent[0] - large - small - 2 * edge - TERMINAL_OUT_M
    distance = apart / float(np.cos(tilt))
    far = np.array([small + edge, small + edge])
    town = far + distance * np.array([np.cos(tilt), np.sin(tilt)])
    lean = float(np.arcsin((large + small) / distance))
    back, out = tilt + np.pi + lean, tilt - lean
    quarter = np.pi / 2
    around_town = _arc(town, large, out - quarter, back - quarter)
    around_far = _arc(far, small, back + quarter - 2 * np.pi, out + quarter - 2 * np.pi)
    flat = np.concatenate([around_town, around_far, around_town[:1]])
    flat = resample(flat, 1.0)
    along = arc_lengths(flat)
    tangent = distance * float(np.cos(lean))
    crossing = along[-1] - tangent * large / (large + small)
    bridge = large * (quarter - out)
    rise = layout.clearance * _hump(along - crossing, FLAT_M, SLOPE_M)
    dip = layout.clearance / 2 * _hump(along - bridge, FLAT_M, LINK_SLOPE_M)
    return _Eight(
        line=np.column_stack([flat, rise - dip]),
        town=(float(town[0]), float(town[1])),
        enters=back - quarter,
        leaves=out - quarter,
    )


def _arc(centre: Shape, radius: float, begin: float, finish: float) -> Shape:
    angles = np.linspace(begin, finish, int(abs(finish - begin) * radius) + 2)
    return centre + radius * np.stack([np.cos(angles), np.sin(angles)], axis=1)


def _hump(away: Shape, flat: float, slope: float) -> Shape:
    """Return 1 within `flat` of zero, 0 beyond `flat + slope`, and a smooth transition between."""
    share = np.clip((flat + slope - np.abs(away)) / slope, 0.0, 1.0)
    return share**2 * (3 - 2 * share)


def _town_streets(
    layout: FigureEightLayout, town: tuple[float, float], rng: np.random.Generator
) -> StreetMap:
    """Return the streets of the town: four blocks, in a square with a cross inside."""
    streets = StreetMap(corner_radius=30.0)
    names = (("sw", "s", "se"), ("w", "c", "e"), ("nw", "n", "ne"))
    block = layout.block
    shift = rng.uniform(-layout.jitter, layout.jitter, 2)
    for row, line in enumerate(names):
        for column, name in enumerate(line):
            x, y = town[0] + (column - 1) * block, town[1] + (row - 1) * block
            dx, dy = shift if name == "c" else (0.0, 0.0)
            streets.place(name, x + dx, y + dy)
    for line in names:
        for start, end in itertools.pairwise(line):
            streets.link(start, end, EAST, EAST, "street")
    for low, high in itertools.pairwise(names):
        for start, end in zip(low, high, strict=True):
            streets.link(start, end, NORTH, NORTH, "street")
    streets.dissolve_bends()
    return streets


def _inner_ramps(
    spec: TownSpec,
    layout: FigureEightLayout,
    eight: _Eight,
    inner: Carriageway,
    streets: StreetMap,
    rng: np.random.Generator,
) -> list[Edge]:
    """Return the ramps between the inner carriageway and the town's streets."""

    def on_circle(angle: float) -> float:
        x, y = Pose(*eight.town, angle).ahead(layout.town_radius).point
        return inner.nearest(float(x), float(y))

    spots: tuple[tuple[str, float, str, float, Leads], ...] = (
        ("off_w", on_circle(eight.enters) - 162.0, "w", WEST, "out"),
        ("off_n", on_circle(float(np.radians(132))), "n", NORTH, "out"),
        ("on_n", on_circle(float(np.radians(48))), "n", NORTH, "in"),
        ("on_s", on_circle(eight.leaves) + 135.0, "s", SOUTH, "in"),
    )
    ramps = []
    for name, spot, place, side, leads in spots:
        at = spot + float(rng.uniform(-1, 1)) * layout.jitter / 2
        inner.branches.append(Branch(name, at, "right", leads, layout.ramp_lane))
        node = streets.places[place]
        arm = Pose(node.x, node.y, side).ahead(ARM_M).beside(-spec.lane_width / 2)
        into = Pose(node.x, node.y, side).ahead(ARM_M).reversed().beside(-spec.lane_width / 2)
        shape = exit_shape(inner, at, into) if leads == "out" else entry_shape(inner, at, arm)
        gate = inner.node_at(name)
        ends = (gate, place) if leads == "out" else (place, gate)
        ramps.append(_ramp(spec, name, ends, shape))
    return ramps


def _interchange(
    spec: TownSpec,
    layout: FigureEightLayout,
    eight: _Eight,
    outer: Carriageway,
    rng: np.random.Generator,
) -> tuple[Node, list[Edge]]:
    """Return the junction beyond the bridge, and its ramps from and to the outer carriageway."""
    height = layout.clearance / 2
    x, y = eight.town[0] + layout.town_radius + TERMINAL_OUT_M, eight.town[1]
    terminal = Node("terminal", x, y, "traffic_light", 10.0, height, crossings=False)
    foot = outer.nearest(eight.town[0] + layout.town_radius, y)
    reach = 180.0 + float(rng.uniform(-1, 1)) * layout.jitter / 2
    half = spec.lane_width / 2
    into = Pose(x, y - ARM_M, NORTH).beside(-half)
    away = Pose(x, y + ARM_M, NORTH).beside(-half)
    ramps = []
    spots: tuple[tuple[str, float, Leads], ...] = (
        ("off_e", foot - reach, "out"),
        ("on_e", foot + reach, "in"),
    )
    for name, at, leads in spots:
        outer.branches.append(Branch(name, at, "right", leads, layout.ramp_lane))
        if leads == "out":
            shape = exit_shape(outer, at, into, height)
            ramps.append(_ramp(spec, name, (outer.node_at(name), terminal.id), shape))
        else:
            shape = entry_shape(outer, at, away, height)
            ramps.append(_ramp(spec, name, (terminal.id, outer.node_at(name)), shape))
    return terminal, ramps


def _ramp(spec: TownSpec, name: str, ends: tuple[str, str], shape: Shape) -> Edge:
    speed = spec.road("ramp").speed
    return Edge(name, *ends, 1, speed, thin_out(shape), "ramp", 3, centred=True)


def _link_line(layout: FigureEightLayout, start: Node, terminal: Node) -> Shape:
    """Return the middle line (n 3) of the street from the town over the highway."""
    ends = np.array([[start.x, start.y], [terminal.x, terminal.y]])
    line = resample(ends, 4.0)
    top = layout.town_radius - layout.block - 16.0
    share = np.clip((arc_lengths(line) - top + LINK_SLOPE_M) / LINK_SLOPE_M, 0.0, 1.0)
    return np.column_stack([line, terminal.z * share**2 * (3 - 2 * share)])
