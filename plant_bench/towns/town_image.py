"""Draws a map of a town as a PNG file."""

import itertools
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle
from PIL import Image

from plant_bench.atomic_files import whole_file
from plant_bench.towns.street_shapes import Shape, arc_lengths, offset, resample
from plant_bench.world.town import Lane, Town

GROUND, ASPHALT, PAVEMENT = "#e8ebdf", "#4e5257", "#c3c2ba"
KERB, MARKING, MIDDLE, ZEBRA = "#9a9a94", "#f2f2ee", "#e9b949", "#dcdcd8"
SIGNAL, RULED = "#d8433b", "#3b7dd8"
LONG_SIDE_IN = 9.0
MARGIN_M = 14.0
KERB_M = 0.9
ZEBRA_STEP_M = 1.2
UPPER_LEVEL_M = 3.0


def draw_town(town: Town, ax: Axes) -> None:
    """Draw a town, north up, in metres: road surface, markings, crossings and signals."""
    points = np.concatenate([lane.points[:, :2] for lane in town.lanes.values()])
    (left, low), (right, high) = points.min(axis=0) - MARGIN_M, points.max(axis=0) + MARGIN_M
    ax.set_xlim(left, right)
    ax.set_ylim(low, high)
    ax.set_aspect("equal")
    ax.set_axis_off()
    ax.add_patch(_background(left, low, right - left, high - low))
    _draw_areas(town, ax)
    _draw_surface(town, ax)
    _draw_signals(town, ax)
    _draw_scale(ax, left, low, right - left)


def save_picture(town: Town, path: Path) -> None:
    """Draw a town into a PNG file."""
    width, height = (side + 2 * MARGIN_M for side in town.extent)
    scale = LONG_SIDE_IN / max(width, height)
    figure = Figure(figsize=(width * scale, height * scale), dpi=150)
    FigureCanvasAgg(figure)
    ax = figure.add_axes((0, 0, 1, 1))
    draw_town(town, ax)
    with whole_file(path) as part:
        figure.savefig(part, format="png", metadata={"Software": None})
        _shrink(part)


def _background(x: float, y: float, width: float, height: float) -> Rectangle:
    return Rectangle((x, y), width, height, color=GROUND, zorder=0)


def _draw_areas(town: Town, ax: Axes) -> None:
    flat = [area.outline for area in town.areas if area.kind != "crossing" and area.outline]
    ax.add_collection(PolyCollection(flat, facecolors=PAVEMENT, linewidths=0, zorder=3.5))
    stripes = [
        stripe
        for area in town.areas
        if area.kind == "crossing"
        for stripe in zebra(np.array(area.outline))
    ]
    ax.add_collection(PolyCollection(stripes, facecolors=ZEBRA, linewidths=0, zorder=8))


def zebra(outline: Shape) -> list[Shape]:
    """Return the stripes of a crossing, given its outline: one side forward, the other back."""
    half = len(outline) // 2
    sides = outline[:half], outline[half:][::-1]
    count = max(1, int(arc_lengths(sides[0])[-1] // ZEBRA_STEP_M))
    edges = np.linspace(0.0, 1.0, 2 * count + 1)
    rails = [_at_fractions(side, edges) for side in sides]
    return [
        np.array([rails[0][i], rails[0][i + 1], rails[1][i + 1], rails[1][i]])
        for i in range(0, 2 * count, 2)
    ]


def _at_fractions(line: Shape, fractions: Shape) -> Shape:
    along = arc_lengths(line)
    return np.stack([np.interp(fractions * along[-1], along, c) for c in line.T], axis=1)


def _draw_surface(town: Town, ax: Axes) -> None:
    """Draw asphalt and markings: first the lower level, then bridges."""
    outlines = [j.outline for j in town.junctions.values() if is_flat(town, j.id) and j.outline]
    ax.add_collection(PolyCollection(outlines, facecolors=ASPHALT, linewidths=0, zorder=2))
    for upper, zorder in ((False, 2), (True, 10)):
        pieces = [(lane, line) for lane in town.lanes.values() for line in stretches(lane, upper)]
        kerbs = [_ribbon(line, lane.width + 2 * KERB_M) for lane, line in pieces]
        roads = [_ribbon(line, lane.width + 0.3) for lane, line in pieces]
        if upper:
            ax.add_collection(PolyCollection(kerbs, facecolors=KERB, linewidths=0, zorder=zorder))
        ax.add_collection(
            PolyCollection(roads, facecolors=ASPHALT, linewidths=0, zorder=zorder + 1)
        )
        _draw_markings(pieces, ax, zorder + 2)
    bars = LineCollection(stop_bars(town), colors=MARKING, linewidths=1.1, zorder=9)
    ax.add_collection(bars)


def is_flat(town: Town, junction: str) -> bool:
    """Return whether a junction is entirely on the lower level."""
    heights = [lane.points[:, 2].max() for lane in town.lanes.values() if lane.junction == junction]
    return bool(heights) and bool(max(heights) < UPPER_LEVEL_M)


def stretches(lane: Lane, upper: bool) -> list[Shape]:
    """Return the stretches of a lane on the upper or on the lower level, in the plane."""
    line = lane.points
    if np.ptp(line[:, 2]) > 0.1:
        line = resample(line, 4.0)
    high = line[:, 2] >= UPPER_LEVEL_M
    here = high[:-1] | high[1:] if upper else ~(high[:-1] & high[1:])
    cuts = np.flatnonzero(np.diff(here.astype(int))) + 1
    bounds = [0, *cuts.tolist(), len(here)]
    return [line[a : b + 1, :2] for a, b in itertools.pairwise(bounds) if here[a] and b > a]


def _ribbon(line: Shape, width: float) -> Shape:
    return np.concatenate([offset(line, width / 2), offset(line, -width / 2)[::-1]])


def lane_borders(lane: Lane, line: Shape) -> list[tuple[str, Shape]]:
    """Return the markings beside a stretch of lane: kind ("middle", "edge", "between") and line."""
    if lane.junction is not None:
        return []
    found = [("between" if lane.left else "middle", offset(line, lane.width / 2))]
    if lane.right is None:
        found.append(("edge", offset(line, -lane.width / 2 + 0.25)))
    return found


def _draw_markings(pieces: list[tuple[Lane, Shape]], ax: Axes, zorder: int) -> None:
    borders: dict[str, list[Shape]] = {"middle": [], "edge": [], "between": []}
    for lane, line in pieces:
        for kind, border in lane_borders(lane, line):
            borders[kind].append(border)
    styles = (("middle", MIDDLE, "-", 0.6), ("edge", MARKING, "-", 0.35))
    for kind, colour, style, width in (*styles, ("between", MARKING, (0, (5, 4)), 0.5)):
        lines = LineCollection(
            borders[kind], colors=colour, linestyles=[style], linewidths=width, zorder=zorder
        )
        ax.add_collection(lines)


def stop_bars(town: Town) -> list[Shape]:
    """Return a stop line for every lane that ends at a signal or stop sign."""
    bars = []
    for source, links in town.links_from.items():
        lane = town.lanes[source]
        if any(link.control in ("signal", "stop", "allway") for link in links):
            end = resample(lane.points[:, :2], 1.0)[-2:]
            ends = [offset(end, side * (lane.width / 2 - 0.2))[-1] for side in (1, -1)]
            bars.append(np.array(ends))
    return bars


def _draw_signals(town: Town, ax: Axes) -> None:
    for control, colour, size in (
        ("signal", SIGNAL, 16.0),
        ("stop", RULED, 9.0),
        ("allway", RULED, 9.0),
    ):
        places = [
            offset(lane.points[-2:, :2], -lane.width / 2 - 1.2)[-1]
            for source, links in town.links_from.items()
            if links[0].control == control and (lane := town.lanes[source]).right is None
        ]
        if places:
            xs, ys = np.array(places).T
            ax.scatter(xs, ys, s=size, c=colour, linewidths=0.3, edgecolors="white", zorder=15)


def _draw_scale(ax: Axes, left: float, low: float, width: float) -> None:
    length = 50.0 if width < 300 else 100.0
    x, y = left + 6, low + 5
    ax.plot([x, x + length], [y, y], color="#333333", linewidth=2, solid_capstyle="butt", zorder=20)
    ax.text(
        x + length + 4, y, f"{length:.0f} m", va="center", fontsize=7, color="#333333", zorder=20
    )


def _shrink(path: Path) -> None:
    """Reduce the picture to a palette of 200 colours, which halves the file size."""
    with Image.open(path) as image:
        small = image.convert("RGB").quantize(200, method=Image.Quantize.MAXCOVERAGE)
    small.save(path, format="PNG", optimize=True)
