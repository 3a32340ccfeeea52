"""Draws a scene from above: lanes, route, plan, lights and actors; the ego points upwards."""

import math
from functools import lru_cache

import numpy as np
import shapely
from jaxtyping import Float
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.patches import Polygon

from plant_bench.agent import NO_ACTOR
from plant_bench.geometry.box import corners
from plant_bench.geometry.pose import from_frame, to_frame
from plant_bench.reports.why.incident_findings import Finding
from plant_bench.runner.review.review_frames import Moment, Postmortem
from plant_bench.world.scene import EGO_LENGTH, EGO_WIDTH, ActorKind, Light
from plant_bench.world.town import Town

SIDE, BEHIND, AHEAD = 19.0, 13.0, 44.0  # m shown beside, behind and before the ego
LABEL = 4.0  # m: actors closer to the edge are not labelled
SPEED_LINE = 0.5  # s: an actor's speed line is the distance driven in this time
GROUND, STREET, EDGE = "#eceee8", "#c9ccd0", "#f6f6f4"
ROUTE, PLAN = "#2f9e44", "#e8590c"
EGO, TOP, EXPERTS, OTHER, WALKER = "#ffd60a", "#e03131", "#1c7ed6", "#868e96", "#5f3dc4"
INK = "#212529"
LIGHTS = {Light.RED: "#e03131", Light.YELLOW: "#f59f00", Light.GREEN: "#2f9e44"}

Points = Float[np.ndarray, "points 2"]


def draw_moment(ax: Axes, moment: Moment, finding: Finding, postmortem: Postmortem) -> None:
    """Draw one moment into the axes of a panel."""
    ax.set_xlim(-SIDE, SIDE)
    ax.set_ylim(-BEHIND, AHEAD)
    ax.set_aspect("equal")
    ax.set_xticks([])
    ax.set_yticks([])
    ax.set_facecolor(GROUND)
    _draw_streets(ax, moment, postmortem.route.load_town())
    _draw_route(ax, moment)
    _draw_light(ax, moment, postmortem)
    _draw_way(ax, moment, finding)
    _draw_actors(ax, moment, finding)
    _draw_plan(ax, moment)
    _draw_ego(ax)


def _turned(points: np.ndarray, moment: Moment) -> Points:
    """Return world points in the panel's frame: the ego at the origin, forward is up."""
    ahead = to_frame(np.asarray(points, float).reshape(-1, 2), *moment.scene.ego.pose)
    return np.stack((-ahead[:, 1], ahead[:, 0]), axis=1)


@lru_cache(maxsize=4)
def _streets(town: Town) -> tuple[list[shapely.Polygon], shapely.STRtree]:
    """Return the lanes of a town as polygons, and a spatial index of them."""
    areas = [
        shapely.LineString(lane.points[:, :2]).buffer(0.5 * lane.width, cap_style="flat")
        for lane in town.lanes.values()
    ]
    parts = [part for area in areas for part in shapely.get_parts(area)]
    return parts, shapely.STRtree(parts)


def _draw_streets(ax: Axes, moment: Moment, town: Town) -> None:
    areas, index = _streets(town)
    ego = moment.scene.ego
    near = index.query(shapely.Point(ego.x, ego.y).buffer(SIDE + AHEAD))
    rings = [_turned(np.array(areas[place].exterior.coords), moment) for place in near]
    ax.add_collection(
        PolyCollection(rings, facecolors=STREET, edgecolors=EDGE, linewidths=0.6, zorder=1)
    )


def _draw_route(ax: Axes, moment: Moment) -> None:
    if moment.seen.route is not None:
        line = _turned(moment.seen.route.points, moment)
        ax.plot(line[:, 0], line[:, 1], color=ROUTE, lw=3.0, alpha=0.55, zorder=2)


def _draw_plan(ax: Axes, moment: Moment) -> None:
    """Draw the waypoints of the plan in the frame of the ego pose when the plan was made."""
    if moment.plan is None:
        return
    world = from_frame(moment.plan.waypoints, *moment.planned_at.pose)
    dots = _turned(world, moment)
    ax.plot(
        dots[:, 0], dots[:, 1], color=PLAN, lw=1.2, marker="o", ms=4.0, mec="white", mew=0.6,
        zorder=8,
    )  # fmt: skip


def _draw_way(ax: Axes, moment: Moment, finding: Finding) -> None:
    """Draw the path of the actor hit, from this moment to the incident."""
    later = [item.scene for item in finding.moments if item.scene.tick >= moment.scene.tick]
    way = [
        scene.actors.poses[scene.actors.ids == finding.incident.infraction.actor, :2]
        for scene in later
    ]
    line = _turned(np.concatenate([np.zeros((0, 2)), *way]), moment)
    ax.plot(line[:, 0], line[:, 1], color=INK, lw=1.0, ls=(0, (4, 3)), zorder=6)


def _draw_light(ax: Axes, moment: Moment, postmortem: Postmortem) -> None:
    """Draw the route's stop lines in the colours of their lights."""
    route = postmortem.route
    for place, entry in enumerate(route.signal_entries):
        colour = LIGHTS.get(Light(int(moment.scene.lights[place])))
        if colour is None:
            continue
        row = min(int(np.searchsorted(route.along, entry)), len(route.points) - 1)
        heading = float(route.headings[row])
        across = 2.0 * np.array([-math.sin(heading), math.cos(heading)])
        ends = _turned(np.stack((route.points[row] - across, route.points[row] + across)), moment)
        ax.plot(ends[:, 0], ends[:, 1], color=colour, lw=4.0, solid_capstyle="butt", zorder=5)


def _draw_actors(ax: Axes, moment: Moment, finding: Finding) -> None:
    actors = moment.scene.actors
    if not len(actors):
        return
    hit = finding.incident.infraction.actor
    ranking = None if moment.planner is None else moment.planner.ranking
    top = ranking[0] if ranking else NO_ACTOR
    reason = None if moment.expert is None else moment.expert.reason
    experts = NO_ACTOR if reason is None else reason.actor
    boxes = corners(actors.poses.astype(float), actors.extents.astype(float))
    for row, box in enumerate(boxes):
        actor = int(actors.ids[row])
        walks = actors.kinds[row] == ActorKind.PEDESTRIAN
        patch = Polygon(
            _turned(box, moment),
            facecolor=TOP if actor == top else WALKER if walks else OTHER,
            edgecolor=EXPERTS if actor == experts else "white",
            linewidth=3.0 if actor == experts else 0.7,
            zorder=7 if actor in (top, experts, hit) else 4,
        )
        ax.add_patch(patch)
        if actor == hit:
            ax.add_patch(_hatched(_turned(box, moment)))
        _draw_speed(ax, moment, row)
        if actor in (top, experts, hit):
            _label(ax, actor, *_turned(actors.poses[row, :2], moment)[0].tolist())


def _hatched(box: Points) -> Polygon:
    return Polygon(box, facecolor="none", edgecolor=INK, hatch="//////", linewidth=0.0, zorder=8)


def _label(ax: Axes, actor: int, x: float, y: float) -> None:
    if abs(x) < SIDE - LABEL and LABEL - BEHIND < y < AHEAD - LABEL:
        ax.annotate(
            str(actor), (x, y), xytext=(7, 7), textcoords="offset points", fontsize=7, color=INK,
            zorder=10, bbox={"boxstyle": "round,pad=0.15", "fc": "white", "ec": "none",
                             "alpha": 0.8},
        )  # fmt: skip


def _draw_speed(ax: Axes, moment: Moment, row: int) -> None:
    actors = moment.scene.actors
    x, y, yaw = (float(value) for value in actors.poses[row])
    half, far = 0.5 * float(actors.extents[row, 0]), SPEED_LINE * float(actors.speeds[row])
    if far < 0.1:
        return
    along = np.array([math.cos(yaw), math.sin(yaw)])
    line = _turned(np.stack(((x, y) + half * along, (x, y) + (half + far) * along)), moment)
    ax.plot(line[:, 0], line[:, 1], color=INK, lw=0.9, zorder=6)


def _draw_ego(ax: Axes) -> None:
    half, wide = 0.5 * EGO_LENGTH, 0.5 * EGO_WIDTH
    ax.add_patch(
        Polygon(
            [(-wide, -half), (wide, -half), (wide, half), (-wide, half)],
            facecolor="white",
            edgecolor=INK,
            linewidth=0.8,
            alpha=0.7,
            zorder=8,
        )
    )
    ax.add_patch(
        Polygon(
            [(-wide, -half), (wide, -half), (0.0, half)],
            facecolor=EGO,
            edgecolor=INK,
            linewidth=1.0,
            zorder=9,
        )
    )
