"""Builds a Route from a lane plan: centre line, junction passages and counts of manoeuvres."""

from plant_bench.towns.route_graph import StreetGraph
from plant_bench.towns.route_lanes import LanePlan, lanes_between
from plant_bench.towns.route_line import RouteLine, trace_line
from plant_bench.world.route import Passage, Route

MANOEUVRES: tuple[str, ...] = (
    "left",
    "right",
    "straight",
    "lane_change",
    "roundabout",
    "merge",
    "exit",
    "u_turn",
)
EDGES_BEYOND = 2  # after the end: SUMO's traffic ignores a vehicle on a junction at its route's end


def make_route(graph: StreetGraph, plan: LanePlan, *, name: str, start: float, end: float) -> Route:
    """Build the route of a lane plan.

    Args:
        graph: The town's edges.
        plan: The lane plan.
        name: The route's id.
        start: Arc length of its start on the first lane, metres.
        end: Arc length of its end on the last lane, metres.
    """
    return route_along(graph, plan, trace_line(graph.town, plan, start, end), name)


def route_along(graph: StreetGraph, plan: LanePlan, line: RouteLine, name: str) -> Route:
    """Build the route of a lane plan along a centre line that is already computed."""
    return Route(
        id=name,
        town=graph.town.name,
        points=line.points[:, :2],
        elevations=line.points[:, 2].round(2),
        speed_limits=line.speed_limits(graph.town),
        edges=(*plan.edges, *_edges_beyond(graph, plan)),
        lanes=line.spans,
        passages=_passages(graph, plan, line),
        lane_changes=line.changes,
        manoeuvres=count_manoeuvres(graph, plan),
    )


def count_manoeuvres(graph: StreetGraph, plan: LanePlan) -> dict[str, int]:
    """Count the manoeuvres of a lane plan.

    Turns count at junctions where roads cross or meet, but not on roundabouts; each roundabout
    counts once.
    """
    counts: dict[str, int] = dict.fromkeys(MANOEUVRES, 0)
    edges = plan.edges
    for index, edge in enumerate(edges):
        changes = abs(lanes_between(graph.town, plan.entered[index], plan.left[index]))
        counts["lane_change"] += changes
        counts["merge"] += int(changes > 0 and graph.town.lanes[plan.entered[index]].acceleration)
        counts["u_turn"] += int(edge in graph.u_turns)
        onto_ring = edge in graph.ring_edges and (
            index == 0 or edges[index - 1] not in graph.ring_edges
        )
        counts["roundabout"] += int(onto_ring)
    for link, edge, onward in zip(plan.links, edges, edges[1:], strict=False):
        if graph.is_exit(edge, onward):
            counts["exit"] += 1
        elif graph.is_crossing(link.junction):
            counts[link.turn] += 1
    return counts


def _edges_beyond(graph: StreetGraph, plan: LanePlan) -> tuple[str, ...]:
    """Return the edges that follow the end of the plan, straight on where possible."""
    town, lane, beyond = graph.town, plan.left[-1], []
    for _ in range(EDGES_BEYOND):
        links = town.links_from.get(lane, ())
        if not links:
            break
        link = min(links, key=lambda link: (link.turn != "straight", link.target))
        lane = link.target
        beyond.append(town.lanes[lane].edge)
    return tuple(beyond)


def _passages(graph: StreetGraph, plan: LanePlan, line: RouteLine) -> tuple[Passage, ...]:
    spans = iter(line.spans)
    passages = []
    for link in plan.links:
        entry = next(span.end for span in spans if span.lane == link.source)
        leave = entry
        for via in link.via:
            leave = next(span.end for span in spans if span.lane == via)
        if not graph.is_joint(link.junction):
            passage = Passage(
                junction=link.junction,
                entry=entry,
                exit=leave,
                turn=link.turn,
                control=link.control,
                signal=link.signal,
                signal_index=link.signal_index,
            )
            passages.append(passage)
    return tuple(passages)
