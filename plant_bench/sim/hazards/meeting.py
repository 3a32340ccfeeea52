"""The script shared by the hazards of junctions: a vehicle arrives where ways meet with the ego.

A vehicle that is next to leave a lane is taken under command, or one is put out on an empty
approach. Its arrival follows the ego's until the ego could only just stop; then it is frozen.
"""

import math
import random

import numpy as np

from plant_bench.sim.hazards.approach import (
    PULL,
    Approach,
    Rival,
    approaches,
    first_on,
    passage_at,
    place_on,
    put_out,
    speed_to_arrive,
)
from plant_bench.sim.hazards.stage import SPARE, Stage
from plant_bench.world.hazard import Hazard, Phase
from plant_bench.world.route import Passage
from plant_bench.world.scene import EGO_WIDTH, EgoState, Light

CURVE_BRAKING = 1.8  # m/s2 that the ego is thought to brake with before a bend
GAIN = 2.0  # m/s2 that the ego is thought to speed up with
LEEWAY = 2.0  # m of slack, beyond what is spared, at which the vehicle is frozen
SOON = 1.5  # s before the ego's arrival at which the vehicle is frozen at the latest
CLEARING = 3.0  # s that the ego's light is thought to stay closed when the other's is, too
EARLY = 0.3  # s by which a vehicle goes before it must, to be in time
MISS = 0.6  # s between the arrivals of the two up to which they still touch
EVIDENT_BRAKING = 3.5  # m/s2: a driver who would need more to stop is seen not to
FASTEST = 1.35  # times its speed that a vehicle may go to be in time
CLEAR = 0.5 * EGO_WIDTH + 0.5  # m before the meeting place where the ego's front must stay
PASSED = 8.0  # m behind the meeting place at which the vehicle is let go
OPEN = (Light.GREEN, Light.UNKNOWN)
MOST_TRIES = 4  # vehicles that are put out for one hazard
LONGEST = 40.0  # s that a hazard may take once it has begun


class Meeting:
    """One vehicle that meets the ego on a junction; mutable. A kind says which, and how it drives.

    Parameters: `speed` (m/s of the vehicle; without it, somewhat more than the ego's limit).

    Attributes:
        lawless: Whether the vehicle minds neither light nor right of way.
    """

    lawless = True

    def __init__(self, hazard: Hazard, stage: Stage, draw: random.Random) -> None:
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
        self._pending: Rival | None = None
        self.rival: Rival | None = None
        self._pace = self._speed
        self._begun = math.inf
        if self._passage is not None:
            ways = approaches(stage.town, stage.route, self._passage)
            self._ways = [way for way in ways if self.fits(way, self._passage)]
            draw.shuffle(self._ways)
        if not self._ways:
            self.phase, self.reason = Phase.VOID, "no other way meets the ego's here"

    def fits(self, way: Approach, passage: Passage) -> bool:
        """Tell whether a way is one that this kind's vehicle may take."""
        raise NotImplementedError

    def step(self, ego: EgoState, stage: Stage) -> None:
        """Find a vehicle, bring it there in time, and let it go when it has passed."""
        if self.phase is Phase.COMMITTED:
            self._pass(stage)
        elif self.phase is Phase.ARMED and self._passage is not None:
            if self.rival is None:
                self._seek(ego, stage, self._passage)
            else:
                self._adapt(ego, stage, self._passage, self.rival)

    def _open(self, stage: Stage, passage: Passage) -> bool:
        return stage.light(passage) in OPEN

    def _seek(self, ego: EgoState, stage: Stage, passage: Passage) -> None:
        if self._pending is not None:
            self._tries += 1
            if stage.on_road(self._pending.vehicle):
                self.rival = self._pending
            else:
                self._why = "SUMO did not put the vehicle in"
                stage.remove(self._pending.vehicle)
            self._pending = None
            return
        beyond = stage.distance_to(min(way.at for way in self._ways)) < 2.0
        if beyond or self._tries == MOST_TRIES:
            self._end(stage, Phase.VOID, self._why)
            return
        for way in self._ways:
            if not self._timely(stage, passage, way):
                self._why = "the ego's light was not green in time"
            elif self._take(ego, stage, way):
                return

    def _timely(self, stage: Stage, passage: Passage, way: Approach) -> bool:
        """Tell whether a vehicle would not go before the ego may."""
        return self._open(stage, passage) or stage.light_of(way.link) is not Light.GREEN

    def _take(self, ego: EgoState, stage: Stage, way: Approach) -> bool:
        time = expected_arrival(ego, stage, way.at)
        if self._passage is not None and not self._open(stage, self._passage):
            time += CLEARING
        first = first_on(stage, way)
        if first is None:
            run = self._speed * time
            if run > way.meets + 15.0:
                return False  # too early for a run of this length
            vehicle = put_out(stage, way, min(run, way.meets - 5.0), self._speed, self._draw)
            if vehicle is None:
                return False
            self._pending = Rival(stage, way, vehicle)
            return True
        front = place_on(stage, way, first)
        if front is None or stage.next_via(first) != way.link.via[0] or stage.is_commanded(first):
            self._why = "others were on the approach"
            return False
        self.rival = Rival(stage, way, first)
        return True

    def _adapt(self, ego: EgoState, stage: Stage, passage: Passage, rival: Rival) -> None:
        front = rival.front(stage)
        way = rival.approach
        if front is None or front > way.meets:
            self._why = "the vehicle came too early"
            self.let_go(stage)
            return
        if not self._timely(stage, passage, way):
            self.let_go(stage)
            return
        may_go = self._open(stage, passage)
        time = expected_arrival(ego, stage, way.at) + (0.0 if may_go else CLEARING)
        speed = rival.speed(stage)
        pace = speed_to_arrive(rival.way_to_go(front), time, speed)
        self._pace = min(pace, self._top(stage, way))
        if stage.distance_to(way.at) < 0.0:
            self._end(stage, Phase.VOID, self._why)
        elif may_go and self._is_due(ego, stage, way):
            self._decide(ego, stage, rival, front, time)
        elif not may_go or self._holds(stage, way, rival.way_to_go(front), speed, time):
            self.command(stage, rival, min(self._pace, self._speed), front)
        else:
            self.command(stage, rival, self._pace, front, lawless=self.lawless)

    def _top(self, stage: Stage, way: Approach) -> float:
        """Return the highest speed of a vehicle that is late."""
        return FASTEST * self._speed if self.lawless else way_limit(stage, way)

    def _holds(self, stage: Stage, way: Approach, to_go: float, speed: float, time: float) -> bool:
        """Tell whether the vehicle need not go yet, or had better not, for it would be late."""
        if time > time_to_go(to_go, speed, self._speed) + EARLY:
            return True
        late = time_to_go(to_go, speed, self._top(stage, way)) > time + MISS
        before_line = to_go - (way.meets - way.stop)
        return late and speed**2 / (2.0 * EVIDENT_BRAKING) < before_line - 2.0

    def _is_due(self, ego: EgoState, stage: Stage, way: Approach) -> bool:
        slack = stage.slack(ego, way.at - CLEAR)
        return slack <= SPARE + LEEWAY or stage.arrival(ego, way.at - CLEAR) <= SOON

    def _decide(self, ego: EgoState, stage: Stage, rival: Rival, front: float, time: float) -> None:
        way = rival.approach
        speed = rival.speed(stage)
        there = time_to_go(rival.way_to_go(front), speed, self._pace)
        if not stage.avoidable(ego, way.at - CLEAR):
            self._end(stage, Phase.VOID, "the ego was too near to stop")
        elif not self.lawless and stage.light_of(way.link) not in OPEN and front < way.stop:
            self._end(stage, Phase.VOID, "the vehicle's light was not green")
        elif abs(there - time) > MISS:
            self._end(stage, Phase.VOID, "the vehicle could not be there in time")
        elif self._may_still_yield(way, speed, front):
            self._end(stage, Phase.VOID, "the vehicle was not seen to go in time")
        else:
            self.phase, self._begun = Phase.COMMITTED, stage.time
            self.command(stage, rival, self._pace, front, lawless=self.lawless)

    def _may_still_yield(self, way: Approach, speed: float, front: float) -> bool:
        """Tell whether a vehicle that must yield could still be seen to do so."""
        needs = speed**2 / (2.0 * EVIDENT_BRAKING)
        return self.lawless and way.link.control != "major" and needs < way.stop - front - 0.5

    def command(
        self, stage: Stage, rival: Rival, pace: float, front: float, *, lawless: bool = False
    ) -> None:
        """Let the vehicle go at a pace."""
        stage.drive(rival.vehicle, max(pace, 0.0), lawless=lawless)
        if lawless:
            rival.tell(stage, front)

    def over(self, stage: Stage, rival: Rival) -> bool:
        """Tell whether a committed hazard has run its course."""
        front = rival.front(stage)
        return front is None or front > rival.approach.meets + PASSED

    def _pass(self, stage: Stage) -> None:
        rival = self.rival
        if rival is None or stage.time - self._begun > LONGEST or self.over(stage, rival):
            self._end(stage, Phase.DONE)
            return
        front = rival.front(stage)
        if front is not None and front <= rival.approach.meets + PASSED:
            self.command(stage, rival, self._pace, front, lawless=self.lawless)

    def let_go(self, stage: Stage) -> None:
        """Give the vehicle back to the traffic."""
        if self.rival is not None:
            self.rival.let_go(stage)
            self.rival = None

    def _end(self, stage: Stage, phase: Phase, reason: str = "") -> None:
        self.let_go(stage)
        self.phase, self.reason = phase, reason


def way_limit(stage: Stage, way: Approach) -> float:
    """Return the speed limit before a way's stop line, m/s."""
    return stage.town.lanes[way.link.source].speed_limit


def time_to_go(way: float, speed: float, pace: float) -> float:
    """Return the time for a way, with speed gained by `PULL` up to a pace."""
    if pace <= speed:
        return max(way, 0.0) / max(pace, 0.1)
    ramp = (pace**2 - speed**2) / (2.0 * PULL)
    if ramp >= way:
        return (math.sqrt(speed**2 + 2.0 * PULL * max(way, 0.0)) - speed) / PULL
    return (pace - speed) / PULL + (way - ramp) / pace


def expected_arrival(ego: EgoState, stage: Stage, along: float) -> float:
    """Return the soonest time in which the ego's middle is there, bends taken into account."""
    count = max(math.ceil(along - stage.progress), 1)
    route, places = stage.route, stage.progress + np.arange(count + 1)
    caps = np.maximum(np.interp(places, route.along, route.speed_limits), 1.0).tolist()
    for k in range(count - 1, -1, -1):
        caps[k] = min(caps[k], math.sqrt(caps[k + 1] ** 2 + 2.0 * CURVE_BRAKING))
    step = max(along - stage.progress, 0.0) / count
    speed, time = ego.speed, 0.0
    for k in range(count):
        after = min(math.sqrt(speed**2 + 2.0 * GAIN * step), max(caps[k + 1], speed - 0.3))
        time += 2.0 * step / max(speed + after, 0.1)
        speed = after
    return time
