"""What hazards may do with the world, and what they may know of it."""

import math
import random
from collections.abc import Mapping

import numpy as np
from jaxtyping import Float

from plant_bench.agent import PATH_POSES, PATH_STEP
from plant_bench.geometry.polyline import resample, value_at
from plant_bench.sim.sumo import EGO_ID, Sumo, VehicleState
from plant_bench.sim.traffic import SIGHT, Traffic
from plant_bench.sim.vehicle_types import VehicleType
from plant_bench.world.driver_braking import SPARE, stopping_distance
from plant_bench.world.route import Passage, Route
from plant_bench.world.scene import EGO_LENGTH, TICK, ActorKind, EgoState, Light
from plant_bench.world.town import Lane, Link, Town

STILL = 0.05  # m/s sideways below which a driver is not changing lanes
ASSUMED_ACCELERATION = 2.0  # m/s2 of an ego that is free to go


class HazardWorld:
    """The world as hazards handle it; mutable. One for an episode, shared by its hazards.

    Actors are either placed by a script at every tick (`put`, `place`) or SUMO's own vehicles that
    a script commands (`send`, `drive`). Both have numbers, are seen in scenes like all others, and
    are never touched by the traffic's own management until they are released or taken away.

    Attributes:
        town: The lanes.
        route: The ego's.
        progress: The ego's, metres along it.
        tick: Of the episode.
        light: What the next light on the route shows the ego.
    """

    def __init__(self, sumo: Sumo, traffic: Traffic, town: Town, route: Route) -> None:
        self._sumo = sumo
        self._traffic = traffic
        self.town = town
        self.route = route
        self.progress = 0.0
        self.tick = 0
        self._states: Mapping[int, VehicleState] = {}
        self._along = route.along.tolist()
        self._x, self._y = route.points.T.tolist()
        self._z = route.elevations.tolist()
        self._headings = route.headings.tolist()
        self._limits = route.speed_limits.tolist()
        self.paths: dict[int, Float[np.ndarray, "steps 3"]] = {}

    def refresh(self, tick: int, progress: float, states: Mapping[int, VehicleState]) -> None:
        """Take note of a new tick; called before the scripts are."""
        self.tick, self.progress, self._states = tick, progress, states

    # What a script may know

    @property
    def time(self) -> float:
        """Seconds since the start of the episode."""
        return self.tick * TICK

    def seen(self) -> Mapping[int, VehicleState]:
        """Return the vehicles in the ego's sight by number; positions are of the front bumper."""
        return self._states

    def kind_of(self, actor: int) -> VehicleType:
        """Return the size and kind of an actor."""
        return self._traffic.types[actor]

    def pose_at(self, along: float) -> tuple[float, float, float]:
        """Return x, y and heading of the route at an arc length."""
        columns = (self._x, self._y, self._headings)
        x, y, heading = (value_at(along, self._along, column) for column in columns)
        return x, y, heading

    def speed_limit_at(self, along: float) -> float:
        """Return the speed limit of the route at an arc length, m/s."""
        return value_at(along, self._along, self._limits)

    def distance_to(self, along: float) -> float:
        """Return how far the ego's front is from an arc length of the route; negative beyond."""
        return along - self.progress - 0.5 * EGO_LENGTH

    def soonest_arrival(self, ego: EgoState, along: float) -> float:
        """Return the time in which the ego's front could be there: it speeds up to the limit."""
        distance = max(self.distance_to(along), 0.0)
        limit = max(self.speed_limit_at(self.progress), self.speed_limit_at(along), ego.speed)
        ramp = (limit**2 - ego.speed**2) / (2.0 * ASSUMED_ACCELERATION)
        if ramp >= distance:
            root = math.sqrt(ego.speed**2 + 2.0 * ASSUMED_ACCELERATION * distance)
            return (root - ego.speed) / ASSUMED_ACCELERATION
        return (limit - ego.speed) / ASSUMED_ACCELERATION + (distance - ramp) / limit

    def arrival(self, ego: EgoState, along: float) -> float:
        """Return the time in which the ego's front is there at its present speed, or infinity."""
        distance = self.distance_to(along)
        return max(distance, 0.0) / ego.speed if ego.speed > 0.1 else math.inf

    def slack(self, ego: EgoState, along: float) -> float:
        """Return the metres left before an arc length if a surprised driver brakes now.

        The criterion of avoidability; see `world.braking`.
        """
        limit = self.speed_limit_at(self.progress)
        return self.distance_to(along) - stopping_distance(ego, limit)

    def avoidable(self, ego: EgoState, along: float) -> bool:
        """Tell whether a surprised driver could still stop before an arc length."""
        return self.slack(ego, along) >= SPARE

    def light(self, passage: Passage) -> Light:
        """Return what a passage's signal shows the ego; UNKNOWN where there is none."""
        if passage.signal is None:
            return Light.UNKNOWN
        return self._sumo.signals.light(passage.signal, passage.signal_index)

    def opens_in(self, passage: Passage) -> float:
        """Return the seconds until a passage's signal shows the ego green; 0 without one."""
        if self.light(passage) in (Light.GREEN, Light.UNKNOWN) or passage.signal is None:
            return 0.0
        return self._sumo.signals.time_to_green(passage.signal, passage.signal_index)

    def lane_state(self, lane: str) -> list[tuple[int, float, float]]:
        """Return number, arc length of the front and speed of all on a lane, the rear first."""
        known = self.town.lanes[lane]
        scale = known.length / self._sumo.lane_length(lane)
        return [
            (number, position * scale, speed)
            for number, position, speed in self._sumo.vehicles_on(lane)
        ]

    def is_free(self, x: float, y: float, radius: float) -> bool:
        """Tell whether no vehicle's front is within a radius (of those in the ego's sight)."""
        return all(math.hypot(state.x - x, state.y - y) > radius for state in self._states.values())

    # What a script may do

    def put(self, kind: VehicleType, x: float, y: float, yaw: float) -> int:
        """Put out an actor, by its box centre, that the script places at every tick it moves."""
        number = self._traffic.number()
        self._traffic.types[number] = kind
        self._traffic.scripted.add(number)
        edge = self.route.edges[0]
        self._sumo.commands.add_scripted(number, kind.name, edge)
        self.place(number, x, y, yaw, 0.0)
        return number

    def place(self, actor: int, x: float, y: float, yaw: float, speed: float) -> None:
        """Place an actor's box centre for the next tick; it goes straight on from there."""
        self._sumo.commands.place(actor, self.kind_of(actor).length, x, y, yaw, speed)
        ahead = PATH_STEP * np.arange(PATH_POSES)
        self.paths[actor] = np.stack(
            (x + ahead * math.cos(yaw), y + ahead * math.sin(yaw), np.full(PATH_POSES, yaw)), axis=1
        )

    def place_along(
        self,
        actor: int,
        line: Float[np.ndarray, "points 2"],
        at: Float[np.ndarray, " points"],
        along: float,
        speed: float,
    ) -> None:
        """Place an actor's box centre on a polyline (arc lengths `at`), which is its true path."""
        where = np.minimum(along + PATH_STEP * np.arange(PATH_POSES), at[-1])
        x, y = np.interp(where, at, line[:, 0]), np.interp(where, at, line[:, 1])
        before, after = np.maximum(where - 1.0, 0.0), np.minimum(where + 1.0, at[-1])
        yaw = np.arctan2(
            np.interp(after, at, line[:, 1]) - np.interp(before, at, line[:, 1]),
            np.interp(after, at, line[:, 0]) - np.interp(before, at, line[:, 0]),
        )
        length = self.kind_of(actor).length
        self._sumo.commands.place(actor, length, float(x[0]), float(y[0]), float(yaw[0]), speed)
        self.paths[actor] = np.stack((x, y, yaw), axis=1)

    def send(
        self, kind: VehicleType, edges: tuple[str, ...], lane: Lane, at: float, speed: float
    ) -> int:
        """Ask for a vehicle of SUMO's on a lane (front at an arc length) that the script commands.

        SUMO leaves it out where there is no safe room: `on_road` tells from the next tick on.
        """
        number = self._traffic.number()
        self._traffic.types[number] = kind
        self._traffic.scripted.add(number)
        scale = self._sumo.lane_length(lane.id) / lane.length
        self._sumo.add_vehicle(number, kind.name, edges, lane.index, at * scale, speed)
        return number

    def on_road(self, vehicle: int) -> bool:
        """Tell whether SUMO has taken a vehicle, and not lost it."""
        return self._sumo.exists(vehicle)

    def state_of(self, vehicle: int) -> VehicleState | None:
        """Return a vehicle's state if it is on the road, in sight or not."""
        return self._sumo.state_of(vehicle)

    def command(self, vehicle: int) -> None:
        """Take a vehicle of the traffic under command; until `release` nothing else touches it."""
        self._traffic.scripted.add(vehicle)

    def may_be_placed(self, vehicle: int, state: VehicleState) -> bool:
        """Tell whether a vehicle of SUMO's is not changing lanes, so that a script may place it."""
        return abs(state.lateral) < STILL and self._sumo.commands.is_centred(vehicle)

    def keep_lane(self, vehicle: int) -> None:
        """Have a vehicle of SUMO's begin no lane change; before it is placed, until `release`."""
        self._sumo.commands.keep_lane(vehicle)

    def drive(self, vehicle: int, speed: float, *, lawless: bool = False) -> None:
        """Command a vehicle's speed; a lawless one minds neither lights nor the right of way."""
        self._sumo.commands.drive(vehicle, speed, lawless=lawless)

    def brake_hard(self, vehicle: int, deceleration: float) -> None:
        """Let a vehicle stop with a deceleration, m/s2."""
        self._sumo.commands.brake(vehicle, deceleration)

    def release(self, vehicle: int) -> None:
        """Give a vehicle back to the traffic."""
        self._sumo.commands.release(vehicle)
        self._traffic.scripted.discard(vehicle)

    def onward(self, edge: str, kind: ActorKind, draw: random.Random) -> list[str]:
        """Return a random way on for a kind of vehicle, of edges that begin after an edge."""
        return self._traffic.onward(edge, kind, draw)

    def reroute(self, vehicle: int, edges: tuple[str, ...]) -> bool:
        """Change where a vehicle goes, its present edge first; False where SUMO refuses."""
        return self._sumo.set_route(vehicle, edges)

    def remove(self, actor: int) -> None:
        """Take an actor off the road."""
        if self._sumo.exists(actor):
            self._sumo.remove(actor)
        self._traffic.scripted.discard(actor)
        self.paths.pop(actor, None)

    # Along the ego's route

    def lane_at(self, along: float) -> Lane | None:
        """Return the route's lane at an arc length; None inside junctions."""
        for span in self.route.lanes:
            if span.start <= along < span.end:
                lane = self.town.lanes[span.lane]
                return lane if lane.junction is None else None
        return None

    def send_along(self, kind: VehicleType, lane: Lane, front: float, speed: float) -> int | None:
        """As `send`, with the front at an arc length of the route, whose way it drives.

        The lane is the route's there, or its neighbour; None where the place is not on it.
        """
        x, y, _ = self.pose_at(front)
        line = resample(lane.points[:, :2], 1.0)
        place = int(np.argmin(np.hypot(line[:, 0] - x, line[:, 1] - y)))
        edges = self.route.edges
        braked = speed * speed / 5.0 + 1.0  # m that SUMO wants before the lane's end
        if lane.edge not in edges or not 0 < place < len(line) - 1 - braked:
            return None
        at = place * lane.length / (len(line) - 1)
        return self.send(kind, edges[edges.index(lane.edge) :], lane, at, speed)

    def out_of_sight(self, along: float) -> bool:
        """Tell whether an arc length of the route is too far from the ego to be seen."""
        (x, y, _), (px, py, _) = self.pose_at(self.progress), self.pose_at(along)
        return math.hypot(px - x, py - y) > SIGHT + 2.0

    def hand_back(self, vehicle: int) -> None:
        """Release a vehicle whose path a script gave."""
        self.release(vehicle)
        self.paths.pop(vehicle, None)

    # Vehicles of SUMO's that a script brings to a place

    def along_lane(self, state: VehicleState) -> float:
        """Return the arc length of a vehicle's front on its lane, as the town measures lanes."""
        known = self.town.lanes.get(state.lane)
        if known is None:
            return state.lane_position
        return state.lane_position * known.length / self._sumo.lane_length(known.id)

    def light_of(self, link: Link) -> Light:
        """Return what a way's signal shows to those who would take it; UNKNOWN without one."""
        if link.signal is None:
            return Light.UNKNOWN
        return self._sumo.signals.light(link.signal, link.signal_index)

    def next_via(self, vehicle: int) -> str:
        """Return the first lane inside the next junction on a vehicle's path, or ""."""
        ahead = self._sumo.next_links(vehicle)
        return ahead[0].via if ahead else ""

    def is_commanded(self, vehicle: int) -> bool:
        """Tell whether a script has a vehicle under command."""
        return vehicle in self._traffic.scripted

    def unforgiving(self, vehicle: int, *, on: bool) -> None:
        """Have a driver insist on its right of way over the ego on junctions, or no more."""
        self._sumo.commands.ignore(vehicle, (int(EGO_ID),) if on else ())

    def beside_road(self, seen: Mapping[int, VehicleState]) -> dict[int, VehicleState]:
        """Return the placed actors in sight that SUMO leaves out, since they stand on no lane."""
        if all(actor in seen for actor in self.paths):
            return {}
        x, y, _ = self.pose_at(self.progress)
        z = value_at(self.progress, self._along, self._z)
        states = {actor: self.state_of(actor) for actor in self.paths if actor not in seen}
        return {
            actor: state._replace(z=z, lane="", lane_position=0.0)
            for actor, state in states.items()
            if state is not None and math.hypot(state.x - x, state.y - y) < SIGHT
        }
