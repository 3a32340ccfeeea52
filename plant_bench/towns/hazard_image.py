"""Draws a top-view sketch of each kind of hazard: the ego in yellow, other actors in red."""

from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.patches import Circle, Polygon, Rectangle

from plant_bench.atomic_files import whole_file
from plant_bench.world.hazard import HazardKind
from plant_bench.world.hazard_sketch import CROSS, LANE, Box
from plant_bench.world.hazard_table import HAZARDS

GROUND, ROAD, PAINT = "#e8ebe0", "#4a4d52", "#ffffff"
MIDDLE = "#f0c419"
COLOURS = {"ego": "#ffd400", "other": "#e74c3c", "parked": "#aeb6bf"}
LIGHTS = {"green": "#2ecc71", "red": "#ff2020"}
VIEW = (-30.0, 34.0, -17.0, 17.0)  # m: left, right, below, above


def save_hazard_pictures(folder: Path) -> list[Path]:
    """Draw one PNG per kind of hazard; return the files."""
    folder.mkdir(parents=True, exist_ok=True)
    files = []
    for kind in HAZARDS:
        figure = Figure(figsize=(6.4, 3.8), dpi=80, layout="constrained")
        FigureCanvasAgg(figure)
        draw_hazard(kind, figure.subplots())
        files.append(folder / f"{kind.value}.png")
        with whole_file(files[-1]) as part:
            figure.savefig(part, format="png", metadata={"Software": None})
    return files


def draw_hazard(kind: HazardKind, ax: Axes) -> None:
    """Draw the sketch of a kind of hazard, with its description."""
    row = HAZARDS[kind]
    sketch = row.sketch
    mirrors = "beyond CARLA's" if row.carla is None else f"CARLA type {row.carla}"
    ax.set_title(f"{kind.value.replace('_', ' ')} ({mirrors})\n{row.sentence}", fontsize=9)
    ax.set(xlim=VIEW[:2], ylim=VIEW[2:], aspect="equal", facecolor=GROUND, xticks=[], yticks=[])
    _draw_road(ax, sketch.road)
    x, y = sketch.ego[0]
    for box in (*sketch.others, Box(x - 3.0, y, 0.0, sketch.ego, colour="ego")):
        _draw_box(ax, box)
    for light_x, light_y, colour in sketch.lights:
        ax.add_patch(Circle((light_x, light_y), 0.9, fc=LIGHTS[colour], ec="black", zorder=6))


def _draw_road(ax: Axes, road: str) -> None:
    left, right, below, above = VIEW
    ax.add_patch(Rectangle((left, -LANE), right - left, 2 * LANE, color=ROAD, zorder=1))
    colour, dashes = (PAINT, "--") if road == "dual" else (MIDDLE, "-")
    if road != "junction":
        ax.plot((left, right), (0, 0), color=colour, ls=dashes, lw=1.2, zorder=2)
        return
    ax.add_patch(Rectangle((CROSS - LANE, below), 2 * LANE, above - below, color=ROAD, zorder=1))
    for line in (((left, CROSS - LANE), (0, 0)), ((CROSS + LANE, right), (0, 0))):
        ax.plot(*line, color=colour, ls=dashes, lw=1.2, zorder=2)
    for line in (((CROSS, CROSS), (below, -LANE)), ((CROSS, CROSS), (LANE, above))):
        ax.plot(*line, color=colour, ls=dashes, lw=1.2, zorder=2)


def _draw_box(ax: Axes, box: Box) -> None:
    length, width = box.size
    corners = 0.5 * np.array(
        [(-length, -width), (length, -width), (length, width), (-length, width)]
    )
    angle = np.radians(box.heading)
    turn = np.array([(np.cos(angle), np.sin(angle)), (-np.sin(angle), np.cos(angle))])
    outline = corners @ turn + (box.x, box.y)
    ax.add_patch(Polygon(outline, fc=COLOURS[box.colour], ec="black", lw=0.8, zorder=5))
    if not box.path:
        return
    path = np.array(box.path, dtype=float)
    ax.plot(*path.T, color=COLOURS[box.colour], lw=2.0, zorder=4)
    tail, tip = path[-2], path[-1]
    ahead = tip + 0.01 * (tip - tail) / np.hypot(*(tip - tail))
    arrow = {"arrowstyle": "-|>", "color": COLOURS[box.colour], "lw": 2.0, "mutation_scale": 16}
    ax.annotate("", xy=tuple(ahead), xytext=tuple(tip), arrowprops=arrow, zorder=4)
