"""Draws routes on maps of their towns."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from PIL import Image

from plant_bench.atomic_files import whole_file
from plant_bench.geometry.polyline import arc_lengths
from plant_bench.towns.town_image import draw_town
from plant_bench.world.hazard_table import HAZARDS
from plant_bench.world.route import Route
from plant_bench.world.town import Town

LINE, CHANGE, START, END, SIGNAL = "#19b5fe", "#f39c12", "#2ecc71", "#8e44ad", "#e74c3c"
HAZARD = "#ffd400"
LEGEND_WORDS = 4  # entries per line of the legend
COLUMNS = 3
PANEL_IN = 5.0  # longer side of a route's panel
TITLE_IN = 0.4
DOTS = 90  # dots per inch
COLOURS = 256  # size of the palette, which keeps files small
ARROWS = 14  # direction arrows per route
ABOVE = 30  # drawing order: above the town


def draw_route(town: Town, route: Route, ax: Axes) -> None:
    """Draw a route on its town: direction, ends, lane changes, signals and hazards."""
    draw_town(town, ax)
    x, y = route.points.T
    ax.plot(x, y, color=LINE, linewidth=1.8, alpha=0.9, zorder=ABOVE)
    for change in route.lane_changes:
        here = (route.along >= change.start) & (route.along <= change.end)
        ax.plot(x[here], y[here], color=CHANGE, linewidth=3.0, zorder=ABOVE + 1)
    stops = _places(route, [passage.entry for passage in route.signal_passages])
    ax.scatter(*stops.T, s=16, marker="s", c=SIGNAL, edgecolors="white", lw=0.4, zorder=ABOVE + 2)
    _draw_arrows(route, ax)
    _draw_hazards(route, ax)
    for index, colour, label in ((0, START, "start"), (-1, END, "end")):
        ax.scatter(x[index], y[index], s=60, c=colour, edgecolors="white", zorder=ABOVE + 4)
        ax.annotate(
            label, route.points[index], xytext=(5, 5), textcoords="offset points", fontsize=8,
            color=colour, weight="bold", zorder=ABOVE + 5,
        )  # fmt: skip
    done = ", ".join(f"{n} {kind}" for kind, n in route.manoeuvres.items() if n)
    ax.set_title(f"{route.id}: {route.length:.0f} m\n{done}\n{_legend(route)}", fontsize=7)


def save_suite_pictures(routes: Sequence[Route], folder: Path) -> list[Path]:
    """Draw one PNG per town with one panel per route; return the files."""
    folder.mkdir(parents=True, exist_ok=True)
    files = []
    for name in sorted({route.town for route in routes}):
        path = folder / f"{name}.png"
        own = [route for route in routes if route.town == name]
        _save_panels(own[0].load_town(), own, path)
        files.append(path)
    return files


def _save_panels(town: Town, routes: list[Route], path: Path) -> None:
    width, height = (PANEL_IN * side / max(town.extent) for side in town.extent)
    rows = -(-len(routes) // COLUMNS)
    size = COLUMNS * max(width, 0.5 * PANEL_IN), rows * (height + 2 * TITLE_IN)
    figure = Figure(figsize=size, dpi=DOTS, layout="constrained")
    FigureCanvasAgg(figure)
    panels = figure.subplots(rows, COLUMNS, squeeze=False).ravel()
    for ax in panels[len(routes) :]:
        ax.set_axis_off()
    for ax, route in zip(panels, routes, strict=False):
        draw_route(town, route, ax)
    with whole_file(path) as part:
        figure.savefig(part, format="png", metadata={"Software": None})
        with Image.open(part) as image:
            small = image.convert("RGB").quantize(COLOURS)
        small.save(part, format="PNG", optimize=True)


def _draw_hazards(route: Route, ax: Axes) -> None:
    """Mark each hazard with the letter of its kind."""
    places = _places(route, [hazard.at for hazard in route.hazards])
    for (x, y), hazard in zip(places, route.hazards, strict=True):
        ax.text(
            x, y, HAZARDS[hazard.kind].letter, fontsize=6, weight="bold", color="black",
            ha="center", va="center", zorder=ABOVE + 6,
            bbox={"boxstyle": "circle,pad=0.15", "fc": HAZARD, "ec": "black", "lw": 0.5},
        )  # fmt: skip


def _legend(route: Route) -> str:
    """Return the legend: letter and name of each kind of hazard on the route."""
    kinds = dict.fromkeys(hazard.kind for hazard in route.hazards)
    words = [f"{HAZARDS[kind].letter} {kind.replace('_', ' ')}" for kind in kinds]
    rows = [", ".join(words[i : i + LEGEND_WORDS]) for i in range(0, len(words), LEGEND_WORDS)]
    return "\n".join(rows)


def _draw_arrows(route: Route, ax: Axes) -> None:
    at = np.linspace(0.0, route.length, ARROWS + 2)[1:-1]
    tails, heads = _places(route, at), _places(route, at + 1.0)
    step = heads - tails
    ax.quiver(
        *tails.T, *step.T, color=LINE, edgecolor="white", linewidth=0.4, angles="xy", pivot="mid",
        scale_units="inches", scale=8.0, width=0.006, headwidth=7, headlength=7, headaxislength=6,
        zorder=ABOVE + 3,
    )  # fmt: skip


def _places(route: Route, at: Sequence[float] | np.ndarray) -> np.ndarray:
    along = arc_lengths(route.points)
    return np.stack([np.interp(at, along, column) for column in route.points.T], axis=1)
