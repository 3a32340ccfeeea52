"""The script shared by the hazards of junctions: a vehicle arrives where ways meet with the ego.

A vehicle that is next to leave a lane is taken under command, or one is put out on an empty
approach. Its arrival follows the ego's until it evidently goes, or the ego could only just stop;
then it is frozen. One that cannot be there in time is exchanged for another.
"""

import math
import random

from plant_bench.sim.hazards.arrival import expected_arrival, speed_to_arrive, time_to_go
from plant_bench.sim.hazards.behaviour import HoldsTraffic
from plant_bench.sim.hazards.conflicting_vehicle import (
    ConflictingVehicle,
    first_on,
    place_on,
    put_out,
    reroute,
)
from plant_bench.sim.hazards.hazard_world import HazardWorld
from plant_bench.world.conflicting_paths import Approach, approaches, passage_at
from plant_bench.world.driver_braking import SPARE
from plant_bench.world.hazard import Hazard, Phase
from plant_bench.world.hazard_table import load_part
from plant_bench.world.route import Passage
from plant_bench.world.scene import EgoState, Light

LEEWAY = 2.0  # m of slack, beyond what is spared, at which the vehicle is frozen
SOON = 1.5  # s before the ego's arrival at which the vehicle is frozen at the latest
EVIDENT = 4.0  # s before the ego's arrival from which on one who evidently goes is frozen
EARLY = 0.3  # s by which a vehicle goes before it must, to be in time
JUMPS = 1.5  # s before the ego's green at which a vehicle may go that starts from its line
CREEP = 0.6  # of its speed: who would be slower waits at its line instead
MISS = 0.6  # s between the arrivals of the two up to which they still touch
EVIDENT_BRAKING = 3.5  # m/s2: a driver who would need more to stop is seen not to
FASTEST = 1.35  # times its speed that a vehicle may go to be in time
PASSED = 8.0  # m behind the meeting place at which the vehicle is let go
OPEN = (Light.GREEN, Light.UNKNOWN)
MOST_TRIES = 4  # vehicles that are put out for one hazard
LONGEST = 40.0  # s that a hazard may take once it has begun
STANDING = 1.0  # m/s of an ego that waits


class JunctionConflict(HoldsTraffic):
    """One vehicle that meets the ego on a junction; mutable. The kind says which may do so.

    Parameters: `speed` (m/s of the vehicle; without it, somewhat more than the ego's limit).

    Attributes:
        lawless: Whether the vehicle minds neither light nor right of way.
        forestalls: Seconds by which the vehicle may come before an ego that waits for it.
    """

    lawless = True
    forestalls = 0.0

    def __init__(self, hazard: Hazard, stage: HazardWorld, draw: random.Random) -> None:
        self.phase = Phase.ARMED
        self.reason = ""
        self._why = "no vehicle could be there in time"
        self._draw = draw
        self._passage = passage_at(stage.route, hazard.at)
        self._ways: list[Approach] = []
        limit = max(stage.speed_limit_at(hazard.at - 20.0), stage.speed_limit_at(hazard.at))
        usual = max(limit, 8.0) * draw.uniform(1.0, 1.15)
        self._speed = hazard.parameters.get("speed", usual)
        self._tries = 0
        self._pending: ConflictingVehicle | None = None
        self.rival: ConflictingVehicle | None = None
        self._pace = self._speed
        self._begun = math.inf
        if self._passage is not None:
            fits, passage = load_part(hazard.kind, "fits"), self._passage
            ways = approaches(stage.town, stage.route, passage)
            self._ways = [way for way in ways if fits(way, passage)]
            draw.shuffle(self._ways)
        if not self._ways:
            self.phase, self.reason = Phase.VOID, "no other way meets the ego's here"

    def step(self, ego: EgoState, stage: HazardWorld) -> None:
        """Find a vehicle, bring it there in time, and let it go when it has passed."""
        if self.phase is Phase.COMMITTED:
            self._pass(stage)
        elif self.phase is Phase.ARMED and self._passage is not None:
            if self.rival is None:
                self._seek(ego, stage, self._passage)
            else:
                self._adapt(ego, stage, self._passage, self.rival)

    def _seek(self, ego: EgoState, stage: HazardWorld, passage: Passage) -> None:
        if self._pending is not None:
            self._tries += 1
            if stage.on_road(self._pending.vehicle):
                self.rival = self._pending
            else:
                self._why = "SUMO did not put the vehicle in"
                stage.remove(self._pending.vehicle)
            self._pending = None
            return
        if not any(stage.avoidable(ego, self._clear(way)) for way in self._ways):
            self.end(stage, Phase.VOID, self._why)
            return
        for way in self._ways:
            if not _timely(stage, passage, way):
                self._why = "the ego's light was not green in time"
            elif self._take(ego, stage, passage, way):
                return

    def _take(self, ego: EgoState, stage: HazardWorld, passage: Passage, way: Approach) -> bool:
        time = expected_arrival(ego, stage, way.at, passage)
        first = first_on(stage, way)
        front = None if first is None else place_on(stage, way, first)
        if first is not None and front is not None and not stage.is_commanded(first):
            state = stage.state_of(first)
            speed = 0.0 if state is None else state.speed
            to_go = way.meets + 0.5 * stage.kind_of(first).length - front
            if time_to_go(to_go, speed, self._top(stage, way)) <= time + MISS:
                if not self._may_take(stage, way, first):
                    self._why = "others were on the approach"
                    return False
                self.rival = ConflictingVehicle(stage, way, first)
                return True
        run = self._speed * time
        if self._tries < MOST_TRIES and run <= way.meets + 15.0:
            vehicle = put_out(stage, way, min(run, way.meets - 5.0), self._speed, self._draw)
            if vehicle is not None:
                self._pending = ConflictingVehicle(stage, way, vehicle)
                return True
        return False

    def _may_take(self, stage: HazardWorld, way: Approach, vehicle: int) -> bool:
        """Tell whether a vehicle goes this way, or changes its mind."""
        if stage.next_via(vehicle) == way.link.via[0]:
            return True
        return reroute(stage, way, vehicle, self._draw)

    def _adapt(
        self, ego: EgoState, stage: HazardWorld, passage: Passage, rival: ConflictingVehicle
    ) -> None:
        front = rival.front(stage)
        way = rival.approach
        if front is None or front > way.meets:
            self._why = "the vehicle came too early"
            self.let_go(stage)
            return
        time = expected_arrival(ego, stage, way.at, passage)
        speed, to_go = rival.speed(stage), rival.way_to_go(front)
        top = self._top(stage, way)
        late = time_to_go(to_go, speed, top) > time + MISS and front < way.stop
        if late or not _timely(stage, passage, way):
            self._why = "the vehicle could not be there in time"
            self.let_go(stage)
            return
        self._pace = min(speed_to_arrive(to_go, time, speed), top)
        if not stage.avoidable(ego, self._clear(way)):
            self.end(stage, Phase.VOID, self._why)
        elif stage.light(passage) in OPEN and self._is_due(ego, stage, rival, front, time):
            self._decide(ego, stage, rival, front, time)
        elif stage.opens_in(passage) > JUMPS or self._holds(time, to_go, speed):
            self.command(stage, rival, min(self._pace, self._speed), front)
        else:
            self.command(stage, rival, self._pace, front, lawless=self.lawless)

    def _top(self, stage: HazardWorld, way: Approach) -> float:
        """Return the highest speed of a vehicle that is late."""
        if self.lawless:
            return FASTEST * self._speed
        return stage.town.lanes[way.link.source].speed_limit

    def _holds(self, time: float, to_go: float, speed: float) -> bool:
        """Tell whether the vehicle need not go yet, and would creep if it did."""
        early = time > time_to_go(to_go, speed, self._speed) + EARLY
        return early and self._pace < CREEP * self._speed

    def _is_due(
        self,
        ego: EgoState,
        stage: HazardWorld,
        rival: ConflictingVehicle,
        front: float,
        time: float,
    ) -> bool:
        way = rival.approach
        if time < EVIDENT and self._goes(way, rival.speed(stage), front):
            return True
        near = stage.slack(ego, self._clear(way)) <= SPARE + LEEWAY
        return near or stage.arrival(ego, self._clear(way)) <= SOON

    def _clear(self, way: Approach) -> float:
        """Return what the ego's front must not pass; vehicles with priority come on all ways."""
        return way.clear if self.lawless else min(one.clear for one in self._ways)

    def _decide(
        self,
        ego: EgoState,
        stage: HazardWorld,
        rival: ConflictingVehicle,
        front: float,
        time: float,
    ) -> None:
        """Freeze the vehicle if the two meet; else go on while the ego could still stop."""
        way, speed = rival.approach, rival.speed(stage)
        there = time_to_go(rival.way_to_go(front), speed, self._pace)
        waits = ego.speed < STANDING and there < time < there + self.forestalls
        if not self.lawless and stage.light_of(way.link) not in OPEN and front < way.stop:
            self._why = "the vehicle's light was not green"
        elif abs(there - time) > MISS and not waits:
            self._why = "the vehicle could not be there in time"
        elif not self._goes(way, speed, front):
            self._why = "the vehicle was not seen to go in time"
        else:
            self.phase, self._begun = Phase.COMMITTED, stage.time
        self.command(stage, rival, self._pace, front, lawless=self.lawless)

    def _goes(self, way: Approach, speed: float, front: float) -> bool:
        """Tell whether a vehicle that would have to yield can be seen not to."""
        needs = speed**2 / (2.0 * EVIDENT_BRAKING)
        return not self.lawless or way.link.control == "major" or needs > way.stop - front - 0.5

    def command(
        self,
        stage: HazardWorld,
        rival: ConflictingVehicle,
        pace: float,
        front: float,
        *,
        lawless: bool = False,
    ) -> None:
        """Let the vehicle go at a pace."""
        stage.drive(rival.vehicle, max(pace, 0.0), lawless=lawless)
        if lawless:
            rival.tell(stage, front)

    def over(self, stage: HazardWorld, rival: ConflictingVehicle) -> bool:
        """Tell whether a committed hazard has run its course."""
        front = rival.front(stage)
        return front is None or front > rival.approach.meets + PASSED

    def _pass(self, stage: HazardWorld) -> None:
        rival = self.rival
        if rival is None or stage.time - self._begun > LONGEST or self.over(stage, rival):
            self.end(stage, Phase.DONE)
            return
        front = rival.front(stage)
        if front is not None and front <= rival.approach.meets + PASSED:
            self.command(stage, rival, self._pace, front, lawless=self.lawless)

    def let_go(self, stage: HazardWorld) -> None:
        """Give the vehicle back to the traffic."""
        if self.rival is not None:
            self.rival.let_go(stage)
            self.rival = None


def _timely(stage: HazardWorld, passage: Passage, way: Approach) -> bool:
    """Tell whether a vehicle would not go before the ego may."""
    return stage.light(passage) in OPEN or stage.light_of(way.link) is not Light.GREEN
