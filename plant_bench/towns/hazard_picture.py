"""A sketch of each kind of hazard, from above: the ego yellow, who endangers it red."""

from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.patches import Circle, Polygon, Rectangle

from plant_bench.whole_files import whole_file
from plant_bench.world.hazard import HAZARDS, HazardKind

GROUND, ROAD, PAINT = "#e8ebe0", "#4a4d52", "#ffffff"
EGO, OTHER, PARKED, MIDDLE = "#ffd400", "#e74c3c", "#aeb6bf", "#f0c419"
GREEN, RED = "#2ecc71", "#ff2020"
LANE = 3.5  # m
VIEW = (-30.0, 34.0, -17.0, 17.0)  # m: left, right, below, above
CROSS = 8.0  # x of the side street's middle
NEAR, BESIDE = -0.5 * LANE, 0.5 * LANE  # y of the ego's lane and of the one to its left

Line = Sequence[tuple[float, float]]


class Box(NamedTuple):
    """A road user: the middle of its box, heading in degrees, size, and where it is going."""

    x: float
    y: float
    heading: float = 0.0
    path: Line = ()
    size: tuple[float, float] = (4.6, 1.9)
    colour: str = OTHER


class Sketch(NamedTuple):
    """What a picture shows: "street", "dual" (two lanes one way) or "junction"; lights: x, y."""

    road: str
    ego: Line
    others: tuple[Box, ...] = ()
    lights: tuple[tuple[float, float, str], ...] = ()


def _bend(corner: tuple[float, float], radius: float, start: float, end: float) -> Line:
    angles = np.radians(np.linspace(start, end, 16))
    return [(corner[0] + radius * np.cos(a), corner[1] + radius * np.sin(a)) for a in angles]


def _person(x: float, y: float, heading: float, path: Line) -> Box:
    return Box(x, y, heading, path, (1.0, 1.0))


_RIGHT = [(-14.0, NEAR), *_bend((2.0, -6.0), 4.25, 90.0, 0.0), (6.25, -15.0)]
_LEFT = [(-14.0, NEAR), *_bend((1.5, 6.5), 8.25, -90.0, 0.0), (9.75, 15.0)]
_AHEAD = [(-14.0, NEAR), (32.0, NEAR)]
_WAVES = [(x, NEAR + 1.1 * np.sin(x / 3.5) * (0.0 < x < 22.0)) for x in np.linspace(-14, 32, 90)]
_NORTHWARD = Box(9.75, -12.0, 90.0, [(9.75, -9.0), (9.75, 15.0)])
_LIGHTS = ((2.6, -5.6, GREEN), (12.6, -5.6, RED))

SKETCHES = {
    HazardKind.CONTROL_LOSS: Sketch("street", _WAVES),
    HazardKind.CROSSING: Sketch(
        "street",
        _AHEAD,
        (
            Box(9.0, -4.9, size=(5.3, 2.0), colour=PARKED),
            _person(14.0, -6.0, 90.0, [(14.0, -5.0), (14.0, 6.5)]),
        ),
    ),
    HazardKind.CROSSING_AFTER_TURN: Sketch(
        "junction", _RIGHT, (_person(2.6, -10.0, 0.0, [(3.6, -10.0), (14.0, -10.0)]),)
    ),
    HazardKind.RED_LIGHT_RUNNER: Sketch("junction", _AHEAD, (_NORTHWARD,), _LIGHTS),
    HazardKind.UNPROTECTED_LEFT: Sketch(
        "junction",
        _LEFT,
        (Box(20.0, BESIDE, 180.0, [(17.0, BESIDE), (-28.0, BESIDE)]), Box(31.0, BESIDE, 180.0)),
        ((2.6, -5.6, GREEN), (13.4, 5.6, GREEN)),
    ),
    HazardKind.RIGHT_TURN: Sketch(
        "junction", _RIGHT, (Box(6.25, 13.0, -90.0, [(6.25, 10.0), (6.25, -8.0)]),)
    ),
    HazardKind.UNSIGNALLED_CROSSING: Sketch("junction", _AHEAD, (_NORTHWARD,)),
    HazardKind.HARD_BRAKE: Sketch(
        "street", [(-14.0, NEAR), (2.0, NEAR)], (Box(8.0, NEAR, path=[(11.0, NEAR), (15.0, NEAR)]),)
    ),
    HazardKind.CUT_IN: Sketch(
        "dual",
        _AHEAD,
        (Box(-8.0, BESIDE, path=[(-5.0, BESIDE), (0.0, BESIDE), (10.0, NEAR), (16.0, NEAR)]),),
    ),
    HazardKind.BLOCKED_LANE: Sketch(
        "street",
        [(-14.0, NEAR), (4.0, NEAR)],
        (Box(10.0, NEAR), Box(29.0, BESIDE, 180.0, [(26.0, BESIDE), (-20.0, BESIDE)])),
    ),
    HazardKind.MERGE_PRESSURE: Sketch(
        "dual",
        [(-14.0, NEAR), (-2.0, NEAR), (14.0, BESIDE), (32.0, BESIDE)],
        tuple(Box(x, BESIDE, path=[(x + 3.0, BESIDE), (x + 8.0, BESIDE)]) for x in (-24, -11, 2)),
    ),
    HazardKind.QUEUE_TAIL: Sketch(
        "dual",
        [(-14.0, NEAR), (4.0, NEAR)],
        tuple(Box(x, NEAR, path=[(x + 2.6, NEAR), (x + 4.6, NEAR)]) for x in (9.0, 17.0, 25.0)),
    ),
}


def save_hazard_pictures(folder: Path) -> list[Path]:
    """Draw each kind of hazard, a PNG a kind; return the files."""
    folder.mkdir(parents=True, exist_ok=True)
    files = []
    for kind, sketch in SKETCHES.items():
        figure = Figure(figsize=(6.4, 3.8), dpi=80, layout="constrained")
        FigureCanvasAgg(figure)
        draw_hazard(kind, sketch, figure.subplots())
        files.append(folder / f"{kind.value}.png")
        with whole_file(files[-1]) as part:
            figure.savefig(part, format="png", metadata={"Software": None})
    return files


def draw_hazard(kind: HazardKind, sketch: Sketch, ax: Axes) -> None:
    """Draw a sketch with its sentence."""
    facts = HAZARDS[kind]
    mirrors = "beyond CARLA's" if facts.carla is None else f"CARLA type {facts.carla}"
    ax.set_title(f"{kind.value.replace('_', ' ')} ({mirrors})\n{facts.sentence}", fontsize=9)
    ax.set(xlim=VIEW[:2], ylim=VIEW[2:], aspect="equal", facecolor=GROUND, xticks=[], yticks=[])
    _draw_road(ax, sketch.road)
    x, y = sketch.ego[0]
    for box in (*sketch.others, Box(x - 3.0, y, 0.0, sketch.ego, colour=EGO)):
        _draw_box(ax, box)
    for light_x, light_y, colour in sketch.lights:
        ax.add_patch(Circle((light_x, light_y), 0.9, fc=colour, ec="black", zorder=6))


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
    ax.add_patch(Polygon(outline, fc=box.colour, ec="black", lw=0.8, zorder=5))
    if not box.path:
        return
    path = np.array(box.path, dtype=float)
    ax.plot(*path.T, color=box.colour, lw=2.0, zorder=4)
    tail, tip = path[-2], path[-1]
    ahead = tip + 0.01 * (tip - tail) / np.hypot(*(tip - tail))
    arrow = {"arrowstyle": "-|>", "color": box.colour, "lw": 2.0, "mutation_scale": 16}
    ax.annotate("", xy=tuple(ahead), xytext=tuple(tip), arrowprops=arrow, zorder=4)
