"""Draws the static background of replay images: the town and the route."""

import numpy as np
from jaxtyping import Float
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PolyCollection

from plant_bench.reports.replay.town_shapes import Piece, town_pieces
from plant_bench.world.route import Route
from plant_bench.world.town import Town

NEAR = 200.0  # m: the town is drawn up to this distance
DASH = (3.0, 4.0)  # m of paint, m of gap
AREAS = ("pavement", "junction", "zebra")
PAINT_WIDTH = {"edge": 0.14, "between": 0.13, "middle": 0.17, "stop": 0.4}  # m
COLOUR_OF = {"junction": "road", "edge": "paint", "between": "paint", "stop": "paint"}
ORDER = ("pavement", "junction", "bridge", "road", "edge", "between", "middle", "zebra", "stop")


class BackgroundPainter:
    """Draws the part of a town and a route near a point into axes; mutable.

    Args:
        ax: The axes.
        town: The town.
        route: The route, drawn over the town.
        colours: A colour scheme of `palette()`.
        metre: Length of a metre in the image, points.
    """

    def __init__(
        self, ax: Axes, town: Town, route: Route, colours: dict[str, str], metre: float
    ) -> None:
        self._ax = ax
        self._route = route
        self._colours = colours
        self._metre = metre
        self._pieces = town_pieces(town)
        self._lows = np.array([piece.points.min(axis=0) for piece in self._pieces])
        self._highs = np.array([piece.points.max(axis=0) for piece in self._pieces])
        self._middle = np.full(2, np.inf)

    def has_drawn(self, place: Float[np.ndarray, " 2"], reach: float) -> bool:
        """Return whether everything within `reach` metres of a place is drawn already."""
        return bool(np.abs(place - self._middle).max() + reach <= NEAR)

    def draw(self, middle: Float[np.ndarray, " 2"]) -> None:
        """Clear the axes, and draw everything within `NEAR` of a place."""
        self._middle = middle
        self._ax.clear()
        self._ax.set_facecolor(self._colours["ground"])
        self._ax.set(xticks=[], yticks=[])
        self._ax.spines[:].set_visible(False)
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
            *self._route.points.T,
            color=self._colours["route"],
            linewidth=0.9 * self._metre,
            alpha=0.55,
            solid_capstyle="round",
            zorder=8,
        )


def _level(upper: bool, kind: str) -> float:
    """Return the z-order of a kind of piece: bridges are above everything on the ground."""
    return (4.0 if upper else 0.0) + 0.3 * ORDER.index(kind)
