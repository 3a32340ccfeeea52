"""A walker or rider crosses the road (CARLA types 3 and 4), with or without a parked van before it.

The walker starts when the ego's soonest arrival equals its own way to the ego's lane, so that a
driver who goes on meets it; it starts beside the road, and far enough from the ego's lane for a
surprised driver to stop. It waits beside the road before and after, until the ego is far away, and
does not go where it would step in front of anybody but the ego; once they have passed, it hurries.
"""

import math
import random

import numpy as np

from plant_bench.geometry.polyline import distance_to
from plant_bench.sim.hazards.hazard_world import HazardWorld
from plant_bench.sim.sumo import VehicleState
from plant_bench.sim.vehicle_types import RIDER, VAN, WALKER
from plant_bench.world.crossing_distance import FARTHEST_START, SPEED_SPREAD, meets_at, needed_start
from plant_bench.world.hazard import Hazard, Phase
from plant_bench.world.scene import EGO_WIDTH, TICK, EgoState

AHEAD_OF_TIME = 0.3  # s by which the walker is early: the ego meets it, not its trail
STANDS = 3.0  # s for which the walker is there before it moves, at least
FARTHEST_KERB = 16.0  # m beside the ego's path at which a road's end is looked for
FROM_KERB = 0.7  # m beside the road where the walker stands
HASTE = 1.35  # times its speed that a walker goes who had to let others pass
HURRY = 1.6  # times its speed that a walker goes at the most where the road is wide
PASSED = 30.0  # m behind the ego at which all are taken away
VAN_BESIDE = 3.1  # m from the ego's path to the van's middle, at least
VAN_FROM_KERB = 1.2  # m beside the road to the van's middle
VAN_BEFORE = 5.0  # m before the walker
BEFORE, BEHIND = 1.5, 0.5  # s that others come later than the walker, or have gone before it
BODY = 6.0  # m that a vehicle is long, with some room


class Crossing:
    """One walker or rider, from the right or the left; mutable.

    Parameters: `speed` (m/s), `side` (-1 from the right, 1 from the left), `rider` (1 for a
    bicycle), `hidden` (1 for a parked van before it).
    """

    def __init__(self, hazard: Hazard, stage: HazardWorld, draw: random.Random) -> None:
        parameters = hazard.parameters
        self.phase = Phase.ARMED
        self.reason = ""
        self._at = hazard.at
        self._kind = RIDER if parameters.get("rider", 0.0) else WALKER
        self._speed = parameters.get("speed", 1.4)
        self._speed *= draw.uniform(1.0 - SPEED_SPREAD, 1.0 + SPEED_SPREAD)
        self._side = 1.0 if parameters.get("side", -1.0) > 0 else -1.0
        self._hidden = bool(parameters.get("hidden", 0.0))
        limit = stage.speed_limit_at(hazard.at)
        self._enters = meets_at(self._kind.length)
        reach = 0.5 * self._kind.length + FROM_KERB
        self._near, far = (_kerb(stage, hazard.at, side) for side in (self._side, -self._side))
        wanted = min(needed_start(self._speed, limit, self._kind.length), FARTHEST_START)
        self._offset = max(wanted, self._near + reach)
        self._speed *= min(max(self._offset / wanted, 1.0), HURRY)
        self._fastest = self._speed * HASTE
        self._end_offset = -max(far + reach, self._enters + 1.0)
        self._since = stage.time
        self._held = False
        self._actors: list[int] = []

    def step(self, ego: EgoState, stage: HazardWorld) -> None:
        """Put the walker out, let it go in time, and take it away behind the ego."""
        if stage.distance_to(self._at + VAN.length) < -PASSED:
            self._end(stage)
        elif not self._actors:
            self._appear(stage)
        elif self.phase is Phase.COMMITTED and self._offset > self._end_offset:
            self._offset -= self._speed * TICK
            speed = self._speed if self._offset > self._end_offset else 0.0
            stage.place(self._actors[0], *self._pose(stage), speed)
        elif self.phase is Phase.ARMED and not self.reason:
            self._wait(ego, stage)

    def _wait(self, ego: EgoState, stage: HazardWorld) -> None:
        """Start in time, or as soon as others have passed; who gives up goes on standing there."""
        if not stage.avoidable(ego, self._at - 0.5 * self._kind.width):
            self.reason = "others were in the way" if self._held else "the ego was too near to stop"
            return
        way = self._offset - self._enters
        time = stage.soonest_arrival(ego, self._at) - AHEAD_OF_TIME
        if stage.time - self._since < STANDS or time > way / self._speed:
            return
        speed = min(way / max(time, 0.1), self._fastest)
        if self._endangers(ego, stage, speed):
            self._held = True
        else:
            self._speed, self.phase = speed, Phase.COMMITTED

    def _endangers(self, ego: EgoState, stage: HazardWorld, pace: float) -> bool:
        """Tell whether somebody who goes on straight would be where the walker is then.

        Those right behind the ego are not: it stops before them.
        """
        x, y, _ = stage.pose_at(self._at)
        _, _, yaw = self._pose(stage)
        cos, sin = math.cos(yaw), math.sin(yaw)
        for number, state in stage.seen().items():
            across = -math.sin(state.yaw) * cos + math.cos(state.yaw) * sin
            if number in self._actors or abs(across) < 0.3 or _follows(state, ego):
                continue
            dx, dy = x - state.x, y - state.y
            # Where its way meets the walker's: metres along its own, and along the walker's.
            own = (cos * dy - sin * dx) / -across
            place = (math.cos(state.yaw) * dy - math.sin(state.yaw) * dx) / -across
            walked = place + self._offset
            if not 0.0 < walked < self._offset - self._end_offset or own < -BODY:
                continue
            speed = max(state.speed, 0.5)
            meets = walked / pace
            if own / speed - BEFORE < meets < (own + BODY) / speed + BEHIND:
                return True
        return False

    def _appear(self, stage: HazardWorld) -> None:
        x, y, yaw = self._pose(stage)
        if not stage.is_free(x, y, 2.0):
            return
        if self._hidden:
            px, py, heading = stage.pose_at(self._at - VAN_BEFORE)
            aside = self._side * max(VAN_BESIDE, self._near + VAN_FROM_KERB)
            vx, vy = px - aside * math.sin(heading), py + aside * math.cos(heading)
            if stage.is_free(vx, vy, 3.0):
                self._actors.append(stage.put(VAN, vx, vy, heading))
        self._actors.insert(0, stage.put(self._kind, x, y, yaw))
        self._since = stage.time

    def _pose(self, stage: HazardWorld) -> tuple[float, float, float]:
        x, y, heading = stage.pose_at(self._at)
        aside = self._side * self._offset
        yaw = heading - self._side * 0.5 * math.pi
        return x - aside * math.sin(heading), y + aside * math.cos(heading), yaw

    def _end(self, stage: HazardWorld) -> None:
        for actor in self._actors:
            stage.remove(actor)
        if self.phase is Phase.COMMITTED:
            self.phase = Phase.DONE
        else:
            self.phase = Phase.VOID
            self.reason = self.reason or "the spot was taken"


def _follows(state: VehicleState, ego: EgoState) -> bool:
    """Tell whether a vehicle is behind the ego on its lane."""
    cos, sin = math.cos(ego.yaw), math.sin(ego.yaw)
    dx, dy = state.x - ego.x, state.y - ego.y
    behind = cos * dx + sin * dy < 0.0 and abs(cos * dy - sin * dx) < EGO_WIDTH
    return behind and math.cos(state.yaw - ego.yaw) > 0.8


def _kerb(stage: HazardWorld, at: float, side: float) -> float:
    """Return how far beside the ego's path the road ends, oncoming lanes included."""
    x, y, heading = stage.pose_at(at)
    height = float(np.interp(at, stage.route.along, stage.route.elevations))
    lanes = [
        lane
        for lane in stage.town.lanes.values()
        if np.abs(lane.points[:, 2] - height).min() < 3.0
        and distance_to(lane.points[:, :2], x, y) < FARTHEST_KERB + lane.width
    ]
    road = 0.0
    for aside in np.arange(0.25, FARTHEST_KERB, 0.25):
        px, py = x - side * aside * math.sin(heading), y + side * aside * math.cos(heading)
        inside = (distance_to(lane.points[:, :2], px, py) < 0.5 * lane.width for lane in lanes)
        if any(inside):
            road = float(aside)
        elif aside > road + 1.0:
            break
    return road
