"""Arranges scenes in a grid in one image: a row per episode, a column per moment."""

from collections.abc import Sequence

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from plant_bench.reports.replay.replay_episode import EpisodeReplay
from plant_bench.reports.replay.replay_page import palette
from plant_bench.reports.replay.scene_image import ScenePainter

ACROSS, STRIP_ACROSS = 90.0, 56.0  # m: width of a scene, in one column and in several
DPI = 100
GAP = 4  # px between scenes


class SceneGrid:
    """A grid of scenes in one figure: a row per episode, a column per moment; mutable.

    Args:
        episodes: Episodes to draw.
        columns: Number of moments.
        dark: Whether to use dark colours.
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
        """Draw moments, one per column, and return the pixels: uint8 (height, width, 3)."""
        for row in self._painters:
            for painter, seconds in zip(row, times, strict=True):
                painter.draw(seconds)
        self._canvas.draw()
        return np.asarray(self._canvas.buffer_rgba())[..., :3].copy()


def _panel_size(rows: int, columns: int) -> tuple[int, int]:
    """Return width and height of one scene in pixels; both even."""
    if columns == 1:
        return (960, 540) if rows == 1 else (960, 430)
    return 480, 360
