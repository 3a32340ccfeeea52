"""The interface through which hazards observe and change the simulation."""

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

MAX_LATERAL_SPEED = 0.05  # m/s; above, a driver is changing lanes
LAST_TURN, LAST_TURN_TIME = 0.2, 0.6  # m and s before a lane's end; no rerouting later
ASSUMED_ACCELERATION = 2.0  # m/s2 of an ego with free road


class HazardWorld:
    """The simulation as hazards see and change it; mutable. One per episode, shared by its hazards.

    Actors are either placed by a hazard at every tick (`put`, `place`), or SUMO vehicles that a
    hazard commands (`send`, `drive`). Both have ids, appear in scenes like all other actors, and
    are left alone by the traffic management until they are released or removed.

    Attributes:
        town: The town.
        route: The ego's route.
        progress: Arc length of the ego on its route, metres.
        tick: Tick of the episode.
        paths: Privileged paths of actors by id: x, y, yaw.
        owner: Place of the hazard that is stepped now, metres along the route.
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
        self.owner = 0.0
        self._owned: dict[int, float] = {}  # hazard of each actor that is placed or commanded

    def refresh(self, tick: int, progress: float, states: Mapping[int, VehicleState]) -> None:
        """Update to a new tick; called before the hazards are stepped."""
        self.tick, self.progress, self._states = tick, progress, states

    # Queries

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
        """Return the distance from the ego's front to a place on the route; negative beyond."""
        return along - self.progress - 0.5 * EGO_LENGTH

    def soonest_arrival(self, ego: EgoState, along: float) -> float:
        """Return the ego's earliest arrival at an arc length: it accelerates to the limit."""
        distance = max(self.distance_to(along), 0.0)
        limit = max(self.speed_limit_at(self.progress), self.speed_limit_at(along), ego.speed)
        ramp = (limit**2 - ego.speed**2) / (2.0 * ASSUMED_ACCELERATION)
        if ramp >= distance:
            root = math.sqrt(ego.speed**2 + 2.0 * ASSUMED_ACCELERATION * distance)
            return (root - ego.speed) / ASSUMED_ACCELERATION
        return (limit - ego.speed) / ASSUMED_ACCELERATION + (distance - ramp) / limit

    def arrival(self, ego: EgoState, along: float) -> float:
        """Return the time until the ego's front arrives at its current speed, or infinity."""
        distance = self.distance_to(along)
        return max(distance, 0.0) / ego.speed if ego.speed > 0.1 else math.inf

    def slack(self, ego: EgoState, along: float) -> float:
        """Return the distance left before an arc length if a driver with reaction time brakes now.

        This is the criterion of avoidability; see `world.driver_braking`.
        """
        limit = self.speed_limit_at(self.progress)
        return self.distance_to(along) - stopping_distance(ego, limit)

    def avoidable(self, ego: EgoState, along: float) -> bool:
        """Tell whether a driver with reaction time could still stop before an arc length."""
        return self.slack(ego, along) >= SPARE

    def light(self, passage: Passage) -> Light:
        """Return the ego's light at a passage; UNKNOWN without a signal."""
        if passage.signal is None:
            return Light.UNKNOWN
        return self._sumo.signals.light(passage.signal, passage.signal_index)

    def opens_in(self, passage: Passage) -> float:
        """Return the seconds until the ego's light at a passage is green; 0 without a signal."""
        if self.light(passage) in (Light.GREEN, Light.UNKNOWN) or passage.signal is None:
            return 0.0
        return self._sumo.signals.time_to_green(passage.signal, passage.signal_index)

    def lane_state(self, lane: str) -> list[tuple[int, float, float]]:
        """Return id, arc length of the front and speed of a lane's vehicles, rearmost first."""
        known = self.town.lanes[lane]
        scale = known.length / self._sumo.lane_length(lane)
        return [
            (number, position * scale, speed)
            for number, position, speed in self._sumo.vehicles_on(lane)
        ]

    def is_free(self, x: float, y: float, radius: float) -> bool:
        """Tell whether no visible vehicle's front is within a radius."""
        return all(math.hypot(state.x - x, state.y - y) > radius for state in self._states.values())

    # Actions

    def put(self, kind: VehicleType, x: float, y: float, yaw: float) -> int:
        """Spawn an actor at a box centre; the hazard places it at every tick at which it moves."""
        number = self._traffic.number()
        self._traffic.types[number] = kind
        self._traffic.scripted.add(number)
        self._owned[number] = self.owner
        edge = self.route.edges[0]
        self._sumo.commands.add_scripted(number, kind.name, edge)
        self.place(number, x, y, yaw, 0.0)
        return number

    def place(self, actor: int, x: float, y: float, yaw: float, speed: float) -> None:
        """Place an actor's box centre for the next tick; its path is straight ahead."""
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
        """Spawn a SUMO vehicle on a lane (front at an arc length) under the hazard's command.

        SUMO does not insert it where that would be unsafe; check `on_road` from the next tick.
        """
        number = self._traffic.number()
        self._traffic.types[number] = kind
        self._traffic.scripted.add(number)
        self._owned[number] = self.owner
        scale = self._sumo.lane_length(lane.id) / lane.length
        self._sumo.add_vehicle(number, kind.name, edges, lane.index, at * scale, speed)
        return number

    def on_road(self, vehicle: int) -> bool:
        """Tell whether SUMO has inserted a vehicle and still has it."""
        return self._sumo.exists(vehicle)

    def state_of(self, vehicle: int) -> VehicleState | None:
        """Return a vehicle's state if it is on the road, visible or not."""
        return self._sumo.state_of(vehicle)

    def command(self, vehicle: int) -> None:
        """Take a traffic vehicle under command until `release`."""
        self._traffic.scripted.add(vehicle)
        self._owned[vehicle] = self.owner

    def may_be_placed(self, vehicle: int, state: VehicleState) -> bool:
        """Tell whether a SUMO vehicle may be placed: it is not changing lanes."""
        return abs(state.lateral) < MAX_LATERAL_SPEED and self._sumo.commands.is_centred(vehicle)

    def keep_lane(self, vehicle: int) -> None:
        """Forbid lane changes of a SUMO vehicle until `release`; call before placing it."""
        self._sumo.commands.keep_lane(vehicle)

    def drive(self, vehicle: int, speed: float, *, ignores_rules: bool = False) -> None:
        """Command a vehicle's speed; with `ignores_rules` it ignores lights and right of way."""
        self._sumo.commands.drive(vehicle, speed, ignores_rules=ignores_rules)

    def brake_hard(self, vehicle: int, deceleration: float) -> None:
        """Stop a vehicle with a deceleration, m/s2."""
        self._sumo.commands.brake(vehicle, deceleration)

    def release(self, vehicle: int) -> None:
        """Return a vehicle to the traffic."""
        self._sumo.commands.release(vehicle)
        self._traffic.scripted.discard(vehicle)
        self._owned.pop(vehicle, None)

    def onward(self, edge: str, kind: ActorKind, draw: random.Random) -> list[str]:
        """Return random edges that continue from an edge for a kind of vehicle."""
        return self._traffic.onward(edge, kind, draw)

    def reroute(self, vehicle: int, edges: tuple[str, ...]) -> bool:
        """Change a vehicle's route, current edge first; False if SUMO refuses it."""
        return self._sumo.set_route(vehicle, edges)

    def remove(self, actor: int) -> None:
        """Take an actor off the road."""
        if self._sumo.exists(actor):
            self._sumo.remove(actor)
        self._traffic.scripted.discard(actor)
        self.paths.pop(actor, None)
        self._owned.pop(actor, None)

    def abandon(self, owner: float) -> None:
        """Take all actors of a hazard off the road."""
        for actor in [actor for actor, place in self._owned.items() if place == owner]:
            self.remove(actor)

    # Along the ego's route

    def lane_at(self, along: float) -> Lane | None:
        """Return the route's lane at an arc length; None inside junctions."""
        for span in self.route.lanes:
            if span.start <= along < span.end:
                lane = self.town.lanes[span.lane]
                return lane if lane.junction is None else None
        return None

    def send_along(self, kind: VehicleType, lane: Lane, front: float, speed: float) -> int | None:
        """As `send`, with the front at an arc length of the ego's route, which it follows.

        The lane is the route's or an adjacent one; None if the place is not on it.
        """
        x, y, _ = self.pose_at(front)
        line = resample(lane.points[:, :2], 1.0)
        place = int(np.argmin(np.hypot(line[:, 0] - x, line[:, 1] - y)))
        edges = self.route.edges
        braked = speed * speed / 5.0 + 1.0  # m that SUMO requires before the lane's end
        if lane.edge not in edges or not 0 < place < len(line) - 1 - braked:
            return None
        at = place * lane.length / (len(line) - 1)
        return self.send(kind, edges[edges.index(lane.edge) :], lane, at, speed)

    def out_of_sight(self, along: float) -> bool:
        """Tell whether an arc length of the route is too far from the ego to be seen."""
        (x, y, _), (px, py, _) = self.pose_at(self.progress), self.pose_at(along)
        return math.hypot(px - x, py - y) > SIGHT + 2.0

    def hand_back(self, vehicle: int) -> None:
        """Release a vehicle and delete its privileged path; its route follows from its lane."""
        self._follow_lane(vehicle)
        self.release(vehicle)
        self.paths.pop(vehicle, None)

    def _follow_lane(self, vehicle: int) -> None:
        """Reroute a vehicle whose lane does not lead along its route.

        It was moved to that lane, and would otherwise wait at the lane's end to change back.
        """
        state = self._sumo.state_of(vehicle)
        lane = None if state is None else self.town.lanes.get(state.lane)
        if state is None or lane is None or lane.junction is not None:
            return
        left = lane.length - self.along_lane(state)
        if left < LAST_TURN + LAST_TURN_TIME * state.speed:
            return
        links = self.town.links_from.get(lane.id, ())
        exits = [self.town.lanes[link.target].edge for link in links]
        ahead = self._sumo.remaining_route(vehicle)[1:2]
        if ahead and ahead[0] not in exits:
            draw = random.Random(f"{vehicle}|{self.tick}")
            for edge in exits:
                onward = self.onward(edge, self.kind_of(vehicle).kind, draw)
                if self.reroute(vehicle, (lane.edge, edge, *onward)):
                    return

    # SUMO vehicles under command

    def along_lane(self, state: VehicleState) -> float:
        """Return the arc length of a vehicle's front on its lane, in the town's geometry."""
        known = self.town.lanes.get(state.lane)
        if known is None:
            return state.lane_position
        return state.lane_position * known.length / self._sumo.lane_length(known.id)

    def light_of(self, link: Link) -> Light:
        """Return the light of a link; UNKNOWN without a signal."""
        if link.signal is None:
            return Light.UNKNOWN
        return self._sumo.signals.light(link.signal, link.signal_index)

    def next_via(self, vehicle: int) -> str:
        """Return the first lane inside the next junction on a vehicle's path, or ""."""
        ahead = self._sumo.next_links(vehicle)
        return ahead[0].via if ahead else ""

    def is_commanded(self, vehicle: int) -> bool:
        """Tell whether a hazard has a vehicle under command."""
        return vehicle in self._traffic.scripted

    def ignore_ego(self, vehicle: int, *, on: bool) -> None:
        """Let a driver ignore the ego at junctions, insisting on its right of way, or not."""
        self._sumo.commands.ignore(vehicle, (int(EGO_ID),) if on else ())

    def beside_road(self, seen: Mapping[int, VehicleState]) -> dict[int, VehicleState]:
        """Return placed actors in sight that SUMO does not report because they are on no lane."""
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
