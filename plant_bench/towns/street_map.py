"""A map of two-way streets, and its conversion to a `StreetPlan`, the input of netconvert."""

from dataclasses import dataclass, field, replace

import numpy as np

from plant_bench.geometry.pose import wrap_angle
from plant_bench.towns.street_plan import Edge, Node, StreetPlan
from plant_bench.towns.street_shapes import Pose, Shape, curve_through
from plant_bench.towns.town_spec import TownSpec

EAST, NORTH, WEST, SOUTH = 0.0, np.pi / 2, np.pi, -np.pi / 2


@dataclass(frozen=True)
class Street:
    """A two-way street from place `start` to place `end`.

    `leave` and `arrive` are its headings at these places, in radians; `via` are poses in between.
    """

    start: str
    end: str
    leave: float
    arrive: float
    road_class: str
    via: tuple[Pose, ...] = ()

    def reversed(self) -> "Street":
        """Return the same street with start and end swapped."""
        via = tuple(pose.reversed() for pose in reversed(self.via))
        back_leave, back_arrive = self.arrive + np.pi, self.leave + np.pi
        return Street(self.end, self.start, back_leave, back_arrive, self.road_class, via)


@dataclass
class StreetMap:
    """Places, which become junctions, and the streets between them; mutable."""

    corner_radius: float
    places: dict[str, Node] = field(default_factory=dict)
    streets: list[Street] = field(default_factory=list)

    def place(self, name: str, x: float, y: float) -> None:
        """Add a place."""
        self.places[name] = Node(name, x, y)

    def link(self, start: str, end: str, leave: float, arrive: float, road_class: str) -> None:
        """Add a street."""
        self.streets.append(Street(start, end, leave, arrive, road_class))

    def degree(self, name: str) -> int:
        """Return the number of street ends at a place."""
        return sum((s.start == name) + (s.end == name) for s in self.streets)

    def dissolve_bends(self) -> None:
        """Replace every place with two arms by a bend of one street; remove places without arms."""
        for name in list(self.places):
            if self.degree(name) == 2:
                self._dissolve(name)
        self.places = {name: p for name, p in self.places.items() if self.degree(name) > 0}

    def _dissolve(self, name: str) -> None:
        joined = [s for s in self.streets if name in (s.start, s.end)]
        if len(joined) != 2:
            return
        first, second = joined
        first = first if first.end == name else first.reversed()
        second = second if second.start == name else second.reversed()
        via = self._bend(self.places[name], first.arrive, second.leave)
        merged = Street(
            first.start,
            second.end,
            first.leave,
            second.arrive,
            first.road_class,
            (*first.via, *via, *second.via),
        )
        self.streets = [s for s in self.streets if s not in joined] + [merged]

    def _bend(self, place: Node, arrive: float, leave: float) -> tuple[Pose, ...]:
        turn = abs(wrap_angle(leave - arrive))
        if turn < 0.1:
            return (Pose(place.x, place.y, arrive),)
        cut = self.corner_radius * float(np.tan(turn / 2))
        before = Pose(place.x, place.y, arrive).ahead(-cut)
        after = Pose(place.x, place.y, leave).ahead(cut)
        return (before, after)

    def turn_quarters(self, quarters: int, centre: tuple[float, float]) -> None:
        """Rotate the map by quarter turns to the left; no street may have a `via` yet."""
        angle = quarters * np.pi / 2
        cos, sin = round(float(np.cos(angle))), round(float(np.sin(angle)))
        for name, place in self.places.items():
            dx, dy = place.x - centre[0], place.y - centre[1]
            x, y = centre[0] + cos * dx - sin * dy, centre[1] + sin * dx + cos * dy
            self.places[name] = replace(place, x=x, y=y)
        self.streets = [
            replace(s, leave=s.leave + angle, arrive=s.arrive + angle) for s in self.streets
        ]

    def control(self, name: str, control: str, radius: float, **more: bool) -> None:
        """Set the control (a SUMO junction type), corner radius and other fields of a place."""
        self.places[name] = replace(self.places[name], control=control, radius=radius, **more)

    def draw_on(self, plan: StreetPlan, spec: TownSpec) -> None:
        """Add all places and streets to the plan, each street as two edges."""
        for place in self.places.values():
            plan.add_node(place)
        for street in self.streets:
            add_street(plan, spec, street.start, street.end, self.shape(street), street.road_class)

    def shape(self, street: Street) -> Shape:
        """Return the centre line of a street (n 2)."""
        start, end = self.places[street.start], self.places[street.end]
        return curve_through(
            [
                Pose(start.x, start.y, street.leave),
                *street.via,
                Pose(end.x, end.y, street.arrive),
            ]
        )


def add_street(
    plan: StreetPlan, spec: TownSpec, start: str, end: str, shape: Shape, road_class: str
) -> None:
    """Add a two-way street along a centre line as two edges."""
    road = spec.road(road_class)
    for tail, head, line in ((start, end, shape), (end, start, shape[::-1])):
        name = f"{tail}-{head}"
        while name in plan.edges:
            name += "b"
        plan.add_edge(
            Edge(
                id=name,
                start=tail,
                end=head,
                lanes=road.lanes,
                speed=road.speed,
                shape=line,
                road_class=road_class,
                priority=2 * road.lanes + (1 if road.speed_kmh > 40 else 0),
                sidewalk=road.sidewalk,
            )
        )
