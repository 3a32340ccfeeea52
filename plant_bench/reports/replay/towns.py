"""What of a town is drawn under a replay, for pages and for pictures."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from plant_bench.foreign_text import script_json
from plant_bench.reports.replay.packing import CENTI, pack, quantised
from plant_bench.towns.picture import is_flat, lane_borders, stop_bars, stretches, zebra
from plant_bench.towns.streets import Shape, thin_out
from plant_bench.world.town import Town

TOWN_FORMAT = 1
KINDS = ("pavement", "junction", "road", "bridge", "edge", "middle", "between", "zebra", "stop")


@dataclass(frozen=True, eq=False)
class Piece:
    """One thing to draw.

    Attributes:
        kind: One of `KINDS`.
        upper: Whether it lies on a bridge, above all that does not.
        width: Of a road's stroke, metres; 0 for areas and for paint.
        points: A polygon for "pavement", "junction" and "zebra", else a line.
    """

    kind: str
    upper: bool
    width: float
    points: Shape


@lru_cache(maxsize=8)
def town_pieces(town: Town) -> tuple[Piece, ...]:
    """Return what is drawn of a town, in no order: kinds and levels say what lies above."""
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
    """Return the script that tells the page of a town.

    Args:
        town: To draw.
        checksum: Of the town, so that the page can say if a replay is of another state of it.
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
    told = {
        "format": TOWN_FORMAT,
        "name": town.name,
        "checksum": checksum,
        "kinds": list(KINDS),
        "columns": packed.columns,
        "data": packed.data,
    }
    return f"plantBench.addTown({script_json(told)});\n"


def _thinned(line: Shape) -> Shape:
    """Return a line in the plane without the points that a straight line has no need of."""
    return thin_out(line[:, :2]) if len(line) > 2 else line[:, :2]
