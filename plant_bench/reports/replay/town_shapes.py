"""Shapes of a town for replays: roads, markings, crossings; for pages and images."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from plant_bench.reports.replay.column_compression import CENTI, pack, quantised
from plant_bench.text_escaping import script_json
from plant_bench.towns.street_shapes import Shape, thin_out
from plant_bench.towns.town_image import is_flat, lane_borders, stop_bars, stretches, zebra
from plant_bench.world.town import Town

TOWN_FORMAT = 1
KINDS = ("pavement", "junction", "road", "bridge", "edge", "middle", "between", "zebra", "stop")


@dataclass(frozen=True, eq=False)
class Piece:
    """One shape to draw.

    Attributes:
        kind: One of `KINDS`.
        upper: Whether it is on a bridge, and drawn above everything else.
        width: Line width of a road, metres; 0 for areas and markings.
        points: A polygon for "pavement", "junction" and "zebra", else a line.
    """

    kind: str
    upper: bool
    width: float
    points: Shape


@lru_cache(maxsize=8)
def town_pieces(town: Town) -> tuple[Piece, ...]:
    """Return the shapes of a town, unordered: `kind` and `upper` give the drawing order."""
    pieces = [
        Piece("pavement", False, 0.0, np.array(area.outline))
        for area in town.areas
        if area.kind != "crossing" and area.outline
    ]
    pieces += [
        Piece("junction", False, 0.0, np.array(junction.outline))
        for junction in town.junctions.values()
        if junction.outline and is_flat(town, junction.id)
    ]
    for lane in town.lanes.values():
        for upper in (False, True):
            for line in stretches(lane, upper):
                thin = _thinned(line)
                pieces.append(Piece("road", upper, lane.width + 0.3, thin))
                if upper:
                    pieces.append(Piece("bridge", upper, lane.width + 1.8, thin))
                pieces += [
                    Piece(kind, upper, 0.0, _thinned(border))
                    for kind, border in lane_borders(lane, line)
                ]
    pieces += [
        Piece("zebra", False, 0.0, stripe)
        for area in town.areas
        if area.kind == "crossing"
        for stripe in zebra(np.array(area.outline))
    ]
    return (*pieces, *(Piece("stop", False, 0.0, bar) for bar in stop_bars(town)))


def town_script(town: Town, checksum: str) -> str:
    """Return the script that passes a town to the page.

    Args:
        town: The town.
        checksum: Checksum of the town, so that the page can detect a replay of another version.
    """
    pieces = town_pieces(town)
    points = quantised(np.concatenate([piece.points for piece in pieces]), CENTI)
    per_piece: dict[str, Callable[[Piece], int]] = {
        "kind": lambda piece: KINDS.index(piece.kind),
        "upper": lambda piece: int(piece.upper),
        "width": lambda piece: round(piece.width * CENTI),
        "count": lambda piece: len(piece.points),
    }
    packed = pack(
        {name: (np.array([of(piece) for piece in pieces]), 0) for name, of in per_piece.items()}
        | {"x": (points[:, 0], 2), "y": (points[:, 1], 2)}
    )
    content = {
        "format": TOWN_FORMAT,
        "name": town.name,
        "checksum": checksum,
        "kinds": list(KINDS),
        "columns": packed.columns,
        "data": packed.data,
    }
    return f"plantBench.addTown({script_json(content)});\n"


def _thinned(line: Shape) -> Shape:
    """Return a line in 2D without the points that straight parts do not need."""
    return thin_out(line[:, :2]) if len(line) > 2 else line[:, :2]
