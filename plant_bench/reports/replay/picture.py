"""Scenes of a replay as pictures, in the look of the page."""

from collections.abc import Sequence

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure

from plant_bench.agent import NOBODY
from plant_bench.geometry.box import corners
from plant_bench.reports.replay.episode import EpisodeReplay
from plant_bench.reports.replay.moments import Moment, moment_of
from plant_bench.reports.replay.overlay import place_at, stop_line
from plant_bench.reports.replay.page import palette
from plant_bench.reports.replay.shapes import BODIES, GLASS, Polygon, placed, shown_extent
from plant_bench.reports.replay.towns import Piece, town_pieces
from plant_bench.world.hazard import HAZARDS, Phase
from plant_bench.world.scene import EGO_EXTENT, ActorKind, Light

ACROSS, STRIP_ACROSS = 90.0, 56.0  # m that a scene shows from left to right
DPI = 100
GAP = 4  # px between scenes
RECENT = 2.5  # s for which an infraction stands out
NEAR = 200.0  # m around the ego within which the town is drawn
DASH = (3.0, 4.0)  # m of paint and m without
AREAS = ("pavement", "junction", "zebra")
PAINT_WIDTH = {"edge": 0.14, "between": 0.13, "middle": 0.17, "stop": 0.4}  # m
COLOUR_OF = {"junction": "road", "edge": "paint", "between": "paint", "stop": "paint"}


class ScenePainter:
    """Draws scenes of one episode into one axes; mutable.

    Args:
        ax: Where; its size and the figure's must not change any more.
        episode: What.
        across: Metres from left to right.
        dark: In the colours of the page's dark mode.
    """

    def __init__(self, ax: Axes, episode: EpisodeReplay, *, across: float, dark: bool) -> None:
        self._ax = ax
        self._episode = episode
        self._colours = palette()["dark" if dark else "light"]
        box = ax.get_window_extent()
        self._across, self._up = across, across * box.height / box.width
        self._metre = box.width / across * 72.0 / ax.figure.dpi  # in points
        self._pieces = town_pieces(episode.town)
        middles = [piece.points for piece in self._pieces]
        self._lows = np.array([points.min(axis=0) for points in middles])
        self._highs = np.array([points.max(axis=0) for points in middles])
        self._drawn_at = np.full(2, np.inf)
        self._fleeting: list[Artist] = []

    def draw(self, seconds: float) -> None:
        """Show the scene of a moment."""
        moment = moment_of(self._episode, seconds)
        x, y = float(moment.ego[0]), float(moment.ego[1])
        if np.hypot(*(self._drawn_at - (x, y))) > NEAR - 0.6 * max(self._across, self._up):
            self._draw_town(np.array([x, y]))
        for artist in self._fleeting:
            artist.remove()
        self._fleeting.clear()
        self._ax.set_xlim(x - self._across / 2, x + self._across / 2)
        self._ax.set_ylim(y - self._up / 2, y + self._up / 2)
        self._draw_attention(moment)
        self._draw_actors(moment)
        self._draw_ego(moment)
        self._draw_lights(moment)
        self._draw_marks(seconds)
        self._draw_caption(moment)

    def _draw_town(self, middle: np.ndarray) -> None:
        self._ax.clear()
        self._ax.set_facecolor(self._colours["ground"])
        self._ax.set(xticks=[], yticks=[])
        self._ax.spines[:].set_visible(False)
        self._fleeting.clear()
        self._drawn_at = middle
        near = ((self._lows < middle + NEAR) & (self._highs > middle - NEAR)).all(axis=1)
        groups: dict[tuple[bool, str], list[Piece]] = {}
        for place in np.flatnonzero(near).tolist():
            piece = self._pieces[place]
            groups.setdefault((piece.upper, piece.kind), []).append(piece)
        for (upper, kind), pieces in groups.items():
            self._draw_pieces(kind, pieces, _level(upper, kind))
        self._draw_route()

    def _draw_pieces(self, kind: str, pieces: list[Piece], zorder: float) -> None:
        colour = self._colours[COLOUR_OF.get(kind, kind)]
        lines = [piece.points for piece in pieces]
        if kind in AREAS:
            self._ax.add_collection(PolyCollection(lines, facecolors=colour, zorder=zorder))
            return
        widths = [PAINT_WIDTH.get(kind, piece.width) * self._metre for piece in pieces]
        dash = tuple(length / PAINT_WIDTH["between"] for length in DASH)
        self._ax.add_collection(
            LineCollection(
                lines,
                colors=colour,
                linewidths=widths,
                linestyles=[(0, dash)] if kind == "between" else "solid",
                zorder=zorder,
                capstyle="butt",
            )
        )

    def _draw_route(self) -> None:
        self._ax.plot(
            *self._episode.route.points.T,
            color=self._colours["route"],
            linewidth=0.9 * self._metre,
            alpha=0.55,
            solid_capstyle="round",
            zorder=8,
        )

    def _keep(self, artist: Artist) -> None:
        self._fleeting.append(artist)

    def _draw_attention(self, moment: Moment) -> None:
        rows = np.flatnonzero(moment.shares)
        lines = [[moment.ego[:2], moment.poses[row, :2]] for row in rows]
        shares = moment.shares[rows]
        lines = LineCollection(
            lines,
            colors=[(*to_rgb(self._colours["relevance"]), 0.25 + 0.65 * share) for share in shares],
            linewidths=0.6 + 2.2 * shares,
            zorder=12,
        )
        self._keep(self._ax.add_collection(lines))

    def _draw_actors(self, moment: Moment) -> None:
        bodies: list[Polygon] = []
        fills: list[np.ndarray] = []
        glass: list[Polygon] = []
        plain, hot = (np.array(to_rgb(self._colours[name])) for name in ("actor", "relevance"))
        for row, number in enumerate(moment.kinds.tolist()):
            kind = ActorKind(number)
            extent = shown_extent(kind, moment.extents[row])
            parts = placed(BODIES[kind], moment.poses[row], extent)
            bodies += parts
            fills += [plain + (hot - plain) * moment.shares[row]] * len(parts)
            glass += placed(GLASS[kind], moment.poses[row], extent)
        outline = self._colours["outline"]
        shapes = PolyCollection(
            bodies, facecolors=fills or "none", edgecolors=outline, linewidths=0.7, zorder=13
        )
        panes = PolyCollection(glass, facecolors=self._colours["glass"], linewidths=0, zorder=13.1)
        self._keep(self._ax.add_collection(shapes))
        self._keep(self._ax.add_collection(panes))
        if moment.shares.any():
            self._draw_box(moment, int(np.argmax(moment.shares)), "relevance", "solid")
        for row in np.flatnonzero((moment.ids == moment.brakes_for) & (moment.ids != NOBODY)):
            self._draw_box(moment, int(row), "expert", "dashed")

    def _draw_box(self, moment: Moment, row: int, colour: str, style: str) -> None:
        room = moment.extents[row] + 1.2
        outline = corners(moment.poses[[row]], room[None])[0]
        line = np.concatenate([outline, outline[:1]])
        (drawn,) = self._ax.plot(
            *line.T, color=self._colours[colour], linewidth=2.2, linestyle=style, zorder=15
        )
        self._keep(drawn)

    def _draw_ego(self, moment: Moment) -> None:
        colours, pose = self._colours, moment.ego[:3]
        frame = corners(pose[None], np.array([EGO_EXTENT]))
        triangle = placed(
            [np.array([(0.5, 0.0), (-0.5, 0.5), (-0.5, -0.5)])], pose, np.array(EGO_EXTENT)
        )
        for shapes, fill, edge in (
            (frame, "none", colours["ego"]),
            (triangle, colours["ego"], colours["outline"]),
        ):
            drawn = PolyCollection(
                list(shapes), facecolors=fill, edgecolors=edge, linewidths=0.9, zorder=16
            )
            self._keep(self._ax.add_collection(drawn))
        if len(moment.plan):
            line = np.concatenate([moment.ego[None, :2], moment.plan])
            style = {"color": colours["plan"], "linewidth": 1.5, "zorder": 17}
            dots = {"marker": "o", "markersize": 5, "markeredgecolor": colours["outline"]}
            (drawn,) = self._ax.plot(*line.T, markevery=slice(1, None), **style, **dots)
            self._keep(drawn)

    def _draw_lights(self, moment: Moment) -> None:
        route = self._episode.route
        for passage, state in zip(route.signal_passages, moment.lights.tolist(), strict=True):
            if state == Light.UNKNOWN:
                continue
            x, y, heading, half = stop_line(route, passage)
            across = np.array([-np.sin(heading), np.cos(heading)])
            ends = np.array([(x, y) + across * half, (x, y) - across * half])
            lit = Light(state).name.lower()
            (bar,) = self._ax.plot(*ends.T, color=self._colours[lit], linewidth=3, zorder=18)
            self._keep(bar)
            self._draw_head(np.array([x, y]) - across * (half + 2.0), lit)

    def _draw_head(self, place: np.ndarray, lit: str) -> None:
        """Draw three lamps: which one is lit tells the colour, too."""
        step = 8.0 / self._metre  # m between lamps
        (case,) = self._ax.plot(
            [place[0]] * 2,
            [place[1] - step, place[1] + step],
            color=self._colours["outline"],
            linewidth=11,
            solid_capstyle="projecting",
            zorder=19,
        )
        self._keep(case)
        for row, lamp in enumerate(("red", "yellow", "green")):
            colour = self._colours[lamp if lamp == lit else "lampOff"]
            (dot,) = self._ax.plot(
                place[0], place[1] + step * (1 - row), "o", color=colour, markersize=6, zorder=20
            )
            self._keep(dot)

    def _draw_marks(self, seconds: float) -> None:
        episode, colours = self._episode, self._colours
        for hazard in episode.source.result.hazards:
            if hazard.phase is Phase.VOID:
                continue
            x, y, _ = place_at(episode.route, hazard.at)
            face = {"boxstyle": "round,pad=0.25", "fc": colours["hazard"], "ec": colours["outline"]}
            self._text(x, y, HAZARDS[hazard.kind].letter, colours["outline"], face)
        for item in episode.source.result.infractions:
            if item.time > seconds + 1e-6:
                continue
            recent = seconds - item.time < RECENT
            if recent:
                ring = {
                    "marker": "o",
                    "markersize": 44,
                    "fillstyle": "none",
                    "markeredgewidth": 2.5,
                }
                (drawn,) = self._ax.plot(
                    item.x, item.y, color=colours["infraction"], zorder=22, **ring
                )
                self._keep(drawn)
            aside = 20.0 / self._metre if recent else 0.0
            face = {"boxstyle": "circle,pad=0.2", "fc": colours["infraction"], "ec": "white"}
            self._text(item.x + aside, item.y + aside, "×", "white", face)

    def _text(self, x: float, y: float, text: str, colour: str, face: dict) -> None:
        style = {"color": colour, "fontsize": 8, "fontweight": "bold", "ha": "center"}
        text_drawn = self._ax.text(
            x, y, text, va="center", bbox=face, zorder=23, clip_on=True, **style
        )
        self._keep(text_drawn)

    def _draw_caption(self, moment: Moment) -> None:
        """Write who drives, when and how fast; a name is never read as mathematics."""
        minutes, rest = divmod(round(moment.time, 1), 60.0)
        title = _shortened(self._episode.source.title)
        speed, limit = (f"{3.6 * value:.0f}" for value in (moment.ego[3], moment.limit))
        text = f"{title}   {int(minutes)}:{rest:04.1f}   {speed} of {limit} km/h"
        if moment.reason:
            text += f"   {moment.reason}"
        face = {"boxstyle": "round,pad=0.4", "fc": self._colours["labelBack"], "ec": "none"}
        drawn = self._ax.text(
            0.012,
            0.985,
            text,
            transform=self._ax.transAxes,
            va="top",
            fontsize=9,
            color=self._colours["label"],
            bbox={**face, "alpha": 0.88},
            zorder=30,
            parse_math=False,
        )
        self._keep(drawn)


class Panels:
    """A grid of scenes in one figure: a row an episode, a column a moment; mutable.

    Args:
        episodes: To draw.
        columns: How many moments stand side by side.
        dark: In dark colours.
    """

    def __init__(self, episodes: Sequence[EpisodeReplay], columns: int, *, dark: bool) -> None:
        rows = len(episodes)
        width, height = _panel_size(rows, columns)
        size = (columns * width + GAP, rows * height + GAP)  # px
        self._figure = Figure(figsize=(size[0] / DPI, size[1] / DPI), dpi=DPI)
        self._figure.set_facecolor(palette()["dark" if dark else "light"]["labelBack"])
        self._canvas = FigureCanvasAgg(self._figure)
        across = ACROSS if columns == 1 else STRIP_ACROSS
        self._painters: list[list[ScenePainter]] = []
        for row, episode in enumerate(episodes):
            bottom = (rows - 1 - row) * height + GAP
            boxes = [
                (
                    (column * width + GAP) / size[0],
                    bottom / size[1],
                    (width - GAP) / size[0],
                    (height - GAP) / size[1],
                )
                for column in range(columns)
            ]
            self._painters.append(
                [
                    ScenePainter(self._figure.add_axes(box), episode, across=across, dark=dark)
                    for box in boxes
                ]
            )

    def draw(self, times: Sequence[float]) -> np.ndarray:
        """Show moments, one a column, and return the pixels: uint8 (height, width, 3)."""
        for row in self._painters:
            for painter, seconds in zip(row, times, strict=True):
                painter.draw(seconds)
        self._canvas.draw()
        return np.asarray(self._canvas.buffer_rgba())[..., :3].copy()


def _panel_size(rows: int, columns: int) -> tuple[int, int]:
    """Return width and height of one scene, even numbers of pixels."""
    if columns == 1:
        return (960, 540) if rows == 1 else (960, 430)
    return 480, 360


def _shortened(text: str) -> str:
    return text if len(text) <= 40 else f"{text[:39]}…"


def _level(upper: bool, kind: str) -> float:
    """Return the drawing order of a kind of piece: bridges above all that lies on the ground."""
    order = ("pavement", "junction", "bridge", "road", "edge", "between", "middle", "zebra", "stop")
    return (4.0 if upper else 0.0) + 0.3 * order.index(kind)
