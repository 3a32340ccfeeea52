"""Draws one scene of a replay as an image, in the style of the replay page."""

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.colors import to_rgb

from plant_bench.agent import NO_ACTOR
from plant_bench.geometry.box import corners
from plant_bench.reports.replay.actor_shapes import BODIES, GLASS, Polygon, placed, shown_extent
from plant_bench.reports.replay.background import BackgroundPainter
from plant_bench.reports.replay.overlay import place_at, stop_line
from plant_bench.reports.replay.replay_episode import EpisodeReplay
from plant_bench.reports.replay.replay_page import palette
from plant_bench.reports.replay.snapshots import Snapshot, snapshot_at
from plant_bench.world.hazard import Phase
from plant_bench.world.hazard_table import HAZARDS
from plant_bench.world.scene import EGO_EXTENT, ActorKind, Light

BOXES = {  # margin around the actor in metres, line width in points, line style
    "relevance": (1.2, 2.2, "solid"),
    "expert": (2.2, 2.2, "solid"),
    "outline": (3.2, 3.2, "solid"),  # under "ownReason": visible on any background
    "ownReason": (3.2, 1.8, (0, (3.5, 2.0))),
}
RECENT = 2.5  # s for which an infraction is highlighted


class ScenePainter:
    """Draws scenes of one episode into one axes; mutable.

    Args:
        ax: The axes; their size and the figure's must not change afterwards.
        episode: The episode.
        across: Width of the scene, metres.
        dark: Whether to use the colours of the page's dark mode.
    """

    def __init__(self, ax: Axes, episode: EpisodeReplay, *, across: float, dark: bool) -> None:
        self._ax = ax
        self._episode = episode
        self._colours = palette()["dark" if dark else "light"]
        box = ax.get_window_extent()
        self._across, self._up = across, across * box.height / box.width
        self._metre = box.width / across * 72.0 / ax.figure.dpi  # in points
        town, route = episode.town, episode.route
        self._ground = BackgroundPainter(ax, town, route, self._colours, self._metre)
        self._artists: list[Artist] = []  # of the present scene

    def draw(self, seconds: float) -> None:
        """Draw the scene at a time in seconds."""
        snapshot = snapshot_at(self._episode, seconds)
        x, y = float(snapshot.ego[0]), float(snapshot.ego[1])
        for artist in self._artists:
            artist.remove()
        self._artists.clear()
        if not self._ground.has_drawn(snapshot.ego[:2], max(self._across, self._up) / 2):
            self._ground.draw(snapshot.ego[:2])
        self._ax.set_xlim(x - self._across / 2, x + self._across / 2)
        self._ax.set_ylim(y - self._up / 2, y + self._up / 2)
        self._draw_attention(snapshot)
        self._draw_actors(snapshot)
        self._draw_ego(snapshot)
        self._draw_lights(snapshot)
        self._draw_marks(seconds)
        self._draw_caption(snapshot)

    def _keep(self, artist: Artist) -> None:
        self._artists.append(artist)

    def _draw_attention(self, snapshot: Snapshot) -> None:
        rows = np.flatnonzero(snapshot.shares)
        lines = [[snapshot.ego[:2], snapshot.poses[row, :2]] for row in rows]
        shares = snapshot.shares[rows]
        lines = LineCollection(
            lines,
            colors=[(*to_rgb(self._colours["relevance"]), 0.25 + 0.65 * share) for share in shares],
            linewidths=0.6 + 2.2 * shares,
            zorder=12,
        )
        self._keep(self._ax.add_collection(lines))

    def _draw_actors(self, snapshot: Snapshot) -> None:
        bodies: list[Polygon] = []
        fills: list[np.ndarray] = []
        glass: list[Polygon] = []
        plain, hot = (np.array(to_rgb(self._colours[name])) for name in ("actor", "relevance"))
        for row, number in enumerate(snapshot.kinds.tolist()):
            kind = ActorKind(number)
            extent = shown_extent(kind, snapshot.extents[row])
            parts = placed(BODIES[kind], snapshot.poses[row], extent)
            bodies += parts
            fills += [plain + (hot - plain) * snapshot.shares[row]] * len(parts)
            glass += placed(GLASS[kind], snapshot.poses[row], extent)
        outline = self._colours["outline"]
        shapes = PolyCollection(
            bodies, facecolors=fills or "none", edgecolors=outline, linewidths=0.7, zorder=13
        )
        panes = PolyCollection(glass, facecolors=self._colours["glass"], linewidths=0, zorder=13.1)
        self._keep(self._ax.add_collection(shapes))
        self._keep(self._ax.add_collection(panes))
        if snapshot.shares.any():
            self._draw_box(snapshot, int(np.argmax(snapshot.shares)), "relevance")
        self._draw_box_of(snapshot, snapshot.expert_brakes_for, "expert")
        self._draw_box_of(snapshot, snapshot.brakes_for, "outline")
        self._draw_box_of(snapshot, snapshot.brakes_for, "ownReason")

    def _draw_box_of(self, snapshot: Snapshot, actor: int, colour: str) -> None:
        for row in np.flatnonzero((snapshot.ids == actor) & (actor != NO_ACTOR)):
            self._draw_box(snapshot, int(row), colour)

    def _draw_box(self, snapshot: Snapshot, row: int, colour: str) -> None:
        """Draw a box around an actor; its size depends on the meaning, so that none overlap."""
        margin, width, style = BOXES[colour]
        extent = snapshot.extents[row] + margin
        outline = corners(snapshot.poses[[row]], extent[None])[0]
        line = np.concatenate([outline, outline[:1]])
        (drawn,) = self._ax.plot(
            *line.T, color=self._colours[colour], linewidth=width, linestyle=style, zorder=15
        )
        self._keep(drawn)

    def _draw_ego(self, snapshot: Snapshot) -> None:
        colours, pose = self._colours, snapshot.ego[:3]
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
        if len(snapshot.plan):
            line = np.concatenate([snapshot.ego[None, :2], snapshot.plan])
            style = {"color": colours["plan"], "linewidth": 1.5, "zorder": 17}
            dots = {"marker": "o", "markersize": 5, "markeredgecolor": colours["outline"]}
            (drawn,) = self._ax.plot(*line.T, markevery=slice(1, None), **style, **dots)
            self._keep(drawn)

    def _draw_lights(self, snapshot: Snapshot) -> None:
        route = self._episode.route
        for passage, state in zip(route.signal_passages, snapshot.lights.tolist(), strict=True):
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
        """Draw three lamps, so that the state is visible without colour."""
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
            self._text(x, y, HAZARDS[hazard.kind].letter, colours["outline"], face, zorder=11.0)
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
            self._text(item.x + aside, item.y + aside, "×", "white", face, zorder=23.0)

    def _text(
        self, x: float, y: float, text: str, colour: str, face: dict, *, zorder: float
    ) -> None:
        style = {"color": colour, "fontsize": 8, "fontweight": "bold", "ha": "center"}
        text_drawn = self._ax.text(
            x, y, text, va="center", bbox=face, zorder=zorder, clip_on=True, **style
        )
        self._keep(text_drawn)

    def _draw_caption(self, snapshot: Snapshot) -> None:
        """Write planner, time and speed; the name is not parsed as a formula."""
        minutes, rest = divmod(round(snapshot.time, 1), 60.0)
        title = _shortened(self._episode.source.title)
        speed, limit = (f"{3.6 * value:.0f}" for value in (snapshot.ego[3], snapshot.limit))
        text = f"{title}   {int(minutes)}:{rest:04.1f}   {speed} of {limit} km/h"
        if snapshot.reason:
            text += f"   {snapshot.reason}"
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


def _shortened(text: str) -> str:
    return text if len(text) <= 40 else f"{text[:39]}…"
