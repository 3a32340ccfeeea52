"""Junction conflict: a vehicle arrives at a conflict point in a junction together with the ego.

The next vehicle to leave an approach is taken under command, or one is spawned on an empty
approach. Its arrival time tracks the ego's until it evidently enters the junction, or the ego could
only just stop; then its speed is frozen. A vehicle that cannot arrive in time is replaced.
"""

import math
import random

from plant_bench.sim.hazards.arrival import expected_arrival, speed_to_arrive, time_to_go
from plant_bench.sim.hazards.behaviour import HoldsTraffic
from plant_bench.sim.hazards.conflicting_vehicle import (
    ConflictingVehicle,
    first_on,
    place_on,
    reroute,
    spawn_on,
)
from plant_bench.sim.hazards.hazard_world import HazardWorld
from plant_bench.world.conflicting_paths import Approach, approaches, passage_at
from plant_bench.world.driver_braking import SPARE
from plant_bench.world.hazard import Hazard, Phase
from plant_bench.world.hazard_table import load_part
from plant_bench.world.route import Passage
from plant_bench.world.scene import EgoState, Light

FREEZE_MARGIN = 2.0  # m of slack beyond `SPARE` at which the vehicle's speed is frozen
SOON = 1.5  # s before the ego's arrival at which the speed is frozen at the latest
EVIDENT = 4.0  # s before the ego's arrival from which a vehicle that evidently goes is frozen
EARLY = 0.3  # s that a vehicle starts before it must
START_BEFORE_GREEN = 1.5  # s before the ego's green at which a vehicle may start from its line
MIN_PACE = 0.6  # of its speed; a slower vehicle waits at its line instead
ARRIVAL_TOLERANCE = 0.6  # s between both arrivals up to which the two still touch
EVIDENT_BRAKING = 3.5  # m/s2: a vehicle that needs more to stop evidently will not stop
FASTEST = 1.35  # times its speed, for a vehicle that is late
PASSED = 8.0  # m behind the conflict point at which the vehicle is released
OPEN = (Light.GREEN, Light.UNKNOWN)
MAX_TRIES = 4  # vehicles spawned for one hazard
MAX_DURATION = 40.0  # s that a committed hazard may take
STOPPED_SPEED = 1.0  # m/s below which the ego counts as waiting


class JunctionConflict(HoldsTraffic):
    """One conflicting vehicle at a junction; mutable. The hazard's kind selects its approaches.

    Parameters: `speed` (m/s of the vehicle; by default somewhat more than the ego's limit).

    Attributes:
        ignores_rules: Whether the vehicle ignores lights and right of way.
        waiting_tolerance: Seconds that the vehicle may arrive before an ego that waits for it.
    """

    ignores_rules = True
    waiting_tolerance = 0.0

    def __init__(self, hazard: Hazard, world: HazardWorld, draw: random.Random) -> None:
        self.phase = Phase.ARMED
        self.reason = ""
        self._void_reason = "no vehicle could be there in time"
        self._draw = draw
        self._passage = passage_at(world.route, hazard.at)
        self._approaches: list[Approach] = []
        limit = max(world.speed_limit_at(hazard.at - 20.0), world.speed_limit_at(hazard.at))
        usual = max(limit, 8.0) * draw.uniform(1.0, 1.15)
        self._speed = hazard.parameters.get("speed", usual)
        self._tries = 0
        self._pending: ConflictingVehicle | None = None
        self.conflicting: ConflictingVehicle | None = None
        self._pace = self._speed
        self._begun = math.inf
        if self._passage is not None:
            fits, passage = load_part(hazard.kind, "fits"), self._passage
            ways = approaches(world.town, world.route, passage)
            self._approaches = [way for way in ways if fits(way, passage)]
            draw.shuffle(self._approaches)
        if not self._approaches:
            self.phase, self.reason = Phase.VOID, "no conflicting approach here"

    def step(self, ego: EgoState, world: HazardWorld) -> None:
        """Find a vehicle, time its arrival, and release it when it has passed."""
        if self.phase is Phase.COMMITTED:
            self._pass(world)
        elif self.phase is Phase.ARMED and self._passage is not None:
            if self.conflicting is None:
                self._seek(ego, world, self._passage)
            else:
                self._adapt(ego, world, self._passage, self.conflicting)

    def _seek(self, ego: EgoState, world: HazardWorld, passage: Passage) -> None:
        if self._pending is not None:
            self._tries += 1
            if world.on_road(self._pending.vehicle):
                self.conflicting = self._pending
            else:
                self._void_reason = "SUMO did not insert the vehicle"
                world.remove(self._pending.vehicle)
            self._pending = None
            return
        if not any(world.avoidable(ego, self._clear(way)) for way in self._approaches):
            self.end(world, Phase.VOID, self._void_reason)
            return
        for way in self._approaches:
            if not _is_timely(world, passage, way):
                self._void_reason = "the ego's light was not green in time"
            elif self._take(ego, world, passage, way):
                return

    def _take(self, ego: EgoState, world: HazardWorld, passage: Passage, way: Approach) -> bool:
        time = expected_arrival(ego, world, way.at, passage)
        first = first_on(world, way)
        front = None if first is None else place_on(world, way, first)
        if first is not None and front is not None and not world.is_commanded(first):
            state = world.state_of(first)
            speed = 0.0 if state is None else state.speed
            to_go = way.meets + 0.5 * world.kind_of(first).length - front
            if time_to_go(to_go, speed, self._top(world, way)) <= time + ARRIVAL_TOLERANCE:
                if not self._may_take(world, way, first):
                    self._void_reason = "others were on the approach"
                    return False
                self.conflicting = ConflictingVehicle(world, way, first)
                return True
        run = self._speed * time
        if self._tries < MAX_TRIES and run <= way.meets + 15.0:
            vehicle = spawn_on(world, way, min(run, way.meets - 5.0), self._speed, self._draw)
            if vehicle is not None:
                self._pending = ConflictingVehicle(world, way, vehicle)
                return True
        return False

    def _may_take(self, world: HazardWorld, way: Approach, vehicle: int) -> bool:
        """Tell whether a vehicle takes this approach's link, or can be rerouted to it."""
        if world.next_via(vehicle) == way.link.via[0]:
            return True
        return reroute(world, way, vehicle, self._draw)

    def _adapt(
        self, ego: EgoState, world: HazardWorld, passage: Passage, conflicting: ConflictingVehicle
    ) -> None:
        front = conflicting.front(world)
        way = conflicting.approach
        if front is None or front > way.meets:
            self._void_reason = "the vehicle came too early"
            self.let_go(world)
            return
        time = expected_arrival(ego, world, way.at, passage)
        speed, to_go = conflicting.speed(world), conflicting.way_to_go(front)
        top = self._top(world, way)
        late = time_to_go(to_go, speed, top) > time + ARRIVAL_TOLERANCE and front < way.stop
        if late or not _is_timely(world, passage, way):
            self._void_reason = "the vehicle could not be there in time"
            self.let_go(world)
            return
        self._pace = min(speed_to_arrive(to_go, time, speed), top)
        if not world.avoidable(ego, self._clear(way)):
            self.end(world, Phase.VOID, self._void_reason)
        elif world.light(passage) in OPEN and self._is_due(ego, world, conflicting, front, time):
            self._decide(ego, world, conflicting, front, time)
        elif world.opens_in(passage) > START_BEFORE_GREEN or self._holds(time, to_go, speed):
            self.command(world, conflicting, min(self._pace, self._speed), front)
        else:
            self.command(world, conflicting, self._pace, front, ignores_rules=self.ignores_rules)

    def _top(self, world: HazardWorld, way: Approach) -> float:
        """Return the maximum speed of a late vehicle."""
        if self.ignores_rules:
            return FASTEST * self._speed
        return world.town.lanes[way.link.source].speed_limit

    def _holds(self, time: float, to_go: float, speed: float) -> bool:
        """Tell whether the vehicle need not start yet, and would be very slow if it did."""
        early = time > time_to_go(to_go, speed, self._speed) + EARLY
        return early and self._pace < MIN_PACE * self._speed

    def _is_due(
        self,
        ego: EgoState,
        world: HazardWorld,
        conflicting: ConflictingVehicle,
        front: float,
        time: float,
    ) -> bool:
        way = conflicting.approach
        if time < EVIDENT and self._goes(way, conflicting.speed(world), front):
            return True
        near = world.slack(ego, self._clear(way)) <= SPARE + FREEZE_MARGIN
        return near or world.arrival(ego, self._clear(way)) <= SOON

    def _clear(self, way: Approach) -> float:
        """Return the place before which the ego must stop; with priority, of all approaches."""
        return way.clear if self.ignores_rules else min(one.clear for one in self._approaches)

    def _decide(
        self,
        ego: EgoState,
        world: HazardWorld,
        conflicting: ConflictingVehicle,
        front: float,
        time: float,
    ) -> None:
        """Freeze the speed if both conflict; else go on while the ego could still stop."""
        way, speed = conflicting.approach, conflicting.speed(world)
        there = time_to_go(conflicting.way_to_go(front), speed, self._pace)
        waits = ego.speed < STOPPED_SPEED and there < time < there + self.waiting_tolerance
        if not self.ignores_rules and world.light_of(way.link) not in OPEN and front < way.stop:
            self._void_reason = "the vehicle's light was not green"
        elif abs(there - time) > ARRIVAL_TOLERANCE and not waits:
            self._void_reason = "the vehicle could not be there in time"
        elif not self._goes(way, speed, front):
            self._void_reason = "the vehicle did not evidently go in time"
        else:
            self.phase, self._begun = Phase.COMMITTED, world.time
        self.command(world, conflicting, self._pace, front, ignores_rules=self.ignores_rules)

    def _goes(self, way: Approach, speed: float, front: float) -> bool:
        """Tell whether a vehicle that would have to yield evidently will not."""
        needs = speed**2 / (2.0 * EVIDENT_BRAKING)
        return (
            not self.ignores_rules or way.link.control == "major" or needs > way.stop - front - 0.5
        )

    def command(
        self,
        world: HazardWorld,
        conflicting: ConflictingVehicle,
        pace: float,
        front: float,
        *,
        ignores_rules: bool = False,
    ) -> None:
        """Drive the vehicle at a pace."""
        world.drive(conflicting.vehicle, max(pace, 0.0), ignores_rules=ignores_rules)
        if ignores_rules:
            conflicting.publish_path(world, front)

    def over(self, world: HazardWorld, conflicting: ConflictingVehicle) -> bool:
        """Tell whether a committed hazard is over."""
        front = conflicting.front(world)
        return front is None or front > conflicting.approach.meets + PASSED

    def _pass(self, world: HazardWorld) -> None:
        conflicting = self.conflicting
        if (
            conflicting is None
            or world.time - self._begun > MAX_DURATION
            or self.over(world, conflicting)
        ):
            self.end(world, Phase.DONE)
            return
        front = conflicting.front(world)
        if front is not None and front <= conflicting.approach.meets + PASSED:
            self.command(world, conflicting, self._pace, front, ignores_rules=self.ignores_rules)

    def let_go(self, world: HazardWorld) -> None:
        """Return the vehicle to the traffic."""
        if self.conflicting is not None:
            self.conflicting.let_go(world)
            self.conflicting = None


def _is_timely(world: HazardWorld, passage: Passage, way: Approach) -> bool:
    """Tell whether a vehicle would not enter before the ego may."""
    return world.light(passage) in OPEN or world.light_of(way.link) is not Light.GREEN
