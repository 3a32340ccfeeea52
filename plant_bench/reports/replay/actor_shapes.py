"""Top-view polygons of actors, one shape for each kind, as on the replay page."""

import numpy as np
from jaxtyping import Float

from plant_bench.world.scene import ActorKind

Polygon = Float[np.ndarray, "points 2"]
LEAST_LENGTH = {ActorKind.PEDESTRIAN: 1.1, ActorKind.BICYCLE: 1.9, ActorKind.MOTORCYCLE: 2.2}  # m


def _rectangle(left: float, right: float, low: float, high: float) -> Polygon:
    return np.array([(left, low), (right, low), (right, high), (left, high)])


def _rounded(corner: float) -> Polygon:
    """Return the unit square with bevelled corners: `corner` of its length and twice its width."""
    c, d, h = corner, 2.0 * corner, 0.5
    return np.array(
        [(-h + c, -h), (h - c, -h), (h, -h + d), (h, h - d)]
        + [(h - c, h), (-h + c, h), (-h, h - d), (-h, -h + d)]
    )


def _disc(x: float, radius: float) -> Polygon:
    turn = np.linspace(0.0, 2.0 * np.pi, 16, endpoint=False)
    return np.stack([x + radius * np.cos(turn), 2.0 * radius * np.sin(turn)], axis=1)


def _walker() -> Polygon:
    turn = np.linspace(0.75, 2.0 * np.pi - 0.75, 14)
    rim = 0.5 * np.stack([np.cos(turn), np.sin(turn)], axis=1)
    return np.concatenate([[(0.85, 0.0)], rim])


# Fractions of length and width. BODIES are filled with the actor's colour, GLASS is dark.
BODIES: dict[ActorKind, list[Polygon]] = {
    ActorKind.CAR: [_rounded(0.1)],
    ActorKind.VAN: [_rounded(0.04)],
    ActorKind.TRUCK: [_rectangle(-0.5, 0.24, -0.5, 0.5), _rectangle(0.27, 0.5, -0.46, 0.46)],
    ActorKind.BUS: [_rounded(0.03)],
    ActorKind.MOTORCYCLE: [_rectangle(-0.5, 0.5, -0.25, 0.25)],
    ActorKind.BICYCLE: [_rectangle(-0.5, 0.5, -0.12, 0.12), _rectangle(0.2, 0.3, -0.5, 0.5)],
    ActorKind.PEDESTRIAN: [_walker()],
    ActorKind.STATIC: [_rectangle(-0.5, 0.5, -0.5, 0.5)],
}
GLASS: dict[ActorKind, list[Polygon]] = {
    ActorKind.CAR: [_rectangle(0.1, 0.26, -0.38, 0.38), _rectangle(-0.36, -0.26, -0.35, 0.35)],
    ActorKind.VAN: [_rectangle(0.3, 0.42, -0.42, 0.42)],
    ActorKind.TRUCK: [_rectangle(0.42, 0.475, -0.39, 0.39)],
    ActorKind.BUS: [
        _rectangle(0.44, 0.485, -0.42, 0.42),
        *(
            _rectangle(place * 0.11, place * 0.11 + 0.075, side, side + 0.12)
            for place in range(-4, 4)
            for side in (-0.42, 0.3)
        ),
    ],
    ActorKind.MOTORCYCLE: [_disc(-0.05, 0.16)],
    ActorKind.BICYCLE: [_disc(-0.08, 0.15)],
    ActorKind.PEDESTRIAN: [],
    ActorKind.STATIC: [_rectangle(-0.2, 0.2, -0.2, 0.2)],
}


def placed(
    shapes: list[Polygon], pose: Float[np.ndarray, " 3"], extent: Float[np.ndarray, " 2"]
) -> list[Polygon]:
    """Return shapes of a unit box, transformed to the world frame.

    Args:
        shapes: Points as fractions of length and width.
        pose: x, y, yaw of the box.
        extent: Its length and width, metres.
    """
    cos, sin = np.cos(pose[2]), np.sin(pose[2])
    turn = np.array([[cos, sin], [-sin, cos]])
    return [(shape * extent) @ turn + pose[:2] for shape in shapes]


def shown_extent(kind: ActorKind, extent: Float[np.ndarray, " 2"]) -> Float[np.ndarray, " 2"]:
    """Return the size at which an actor is drawn: small ones are enlarged."""
    return extent * max(1.0, LEAST_LENGTH.get(kind, 0.0) / max(float(extent[0]), 1e-3))
