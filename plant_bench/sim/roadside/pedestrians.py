"""Simulates pedestrians around the ego, on sidewalks and crossings.

SUMO's pedestrian model is not used: it jumps over crossings in one tick and sideways at corners,
and ends the process if a walk is disconnected. SUMO's drivers see pedestrians on the road near the
ego as small vehicles. Walkers enter and leave out of the ego's sight, wait at kerbs
(`road_crossing`) and do not walk into vehicles.
"""

import math
import random
from collections.abc import Sequence
from typing import Protocol, runtime_checkable

import numpy as np
from jaxtyping import Float, Int

from plant_bench.agent import PATH_POSES, PATH_STEP, Privileged
from plant_bench.geometry.pose import wrap_angles
from plant_bench.sim.roadside.collision_check import BODY, blocked
from plant_bench.sim.roadside.footways import Crossing, Footways, Heading
from plant_bench.sim.roadside.road_crossing import MovingVehicle, moving
from plant_bench.sim.roadside.walking_paths import SAMPLE, SAMPLES, WALK, Kerb, Walk, random_walk
from plant_bench.world.actor_ids import PEDESTRIANS
from plant_bench.world.scene import TICK, ActorKind, Actors, EgoState

ENTRY_RADIUS = 90.0  # m: walkers enter no nearer to the ego
FILL_RADIUS = 130.0  # m: their density is kept within this distance of the ego
EXIT_RADIUS = 145.0  # m: beyond it they are removed
SHOWN_RADIUS = 90.0  # m: SUMO's drivers see walkers on a road within this distance of the ego
LOOK_INTERVAL = 4  # ticks between two decisions; the pace is constant between, as for drivers
ENTRIES = 6  # walkers that may enter at one update
SPACING = 5.0  # m between the places at which walkers may enter
SPEEDS = (1.2, 1.5)  # m/s
STARTING, STOPPING = 2.0, 2.0  # m/s2
AT_KERB = 1.5  # m before the waiting place at which walkers decide whether to cross
STANDING = 0.1  # m/s
_BODIES = np.array([BODY], np.float32)
_KINDS = np.array([ActorKind.PEDESTRIAN], np.uint8)


@runtime_checkable
class Rules(Protocol):
    """Decides when a road may be crossed; implemented by `CrossingRules`."""

    def allowed(
        self,
        crossing: Crossing,
        duration: float,
        ego: EgoState,
        progress: float,
        others: Sequence[MovingVehicle],
    ) -> bool:
        """Tell whether a walker may start to cross now."""
        ...


@runtime_checkable
class Show(Protocol):
    """Shows walkers to drivers; implemented by `SumoProxies`."""

    def show(self, tick: int, walker: int, pose: tuple[float, float, float], speed: float) -> None:
        """Show a walker, by its box centre; called at every tick."""
        ...

    def withdraw(self, walker: int) -> None:
        """Stop showing a walker, if it is shown."""
        ...


class Walkers:
    """The pedestrians around the ego; mutable.

    Args:
        ways: The pedestrian network.
        rules: Decides when walkers may cross.
        sumo_proxies: Shows walkers on the road to SUMO's drivers.
        density: Walkers per kilometre of sidewalk.
        seed: Seed of all random draws.
    """

    def __init__(
        self,
        ways: Footways,
        rules: Rules,
        sumo_proxies: Show,
        density: float,
        seed: int,
    ) -> None:
        self._ways, self._rules, self._sumo_proxies = ways, rules, sumo_proxies
        self._density = density
        self._draw = random.Random(seed ^ PEDESTRIANS.start)
        self._headings, self._spots = ways.places(SPACING)
        self._number = PEDESTRIANS.start
        # One row per walker, ordered by id.
        self.ids = np.zeros(0, np.int64)
        self._at, self._pace, self._speed, self._desired, self._stop, self._since = np.zeros((6, 0))
        self._row = np.zeros(0, np.intp)  # index of the walk
        self._walks = np.zeros((16, SAMPLES, 4))
        self._held = np.zeros(0, dtype=bool)  # whether stopped to avoid a collision
        self._free: list[int] = []
        self._kerbs: dict[int, list[Kerb]] = {}  # remaining kerbs by id
        self._crossing: dict[int, Kerb] = {}  # of walkers on a road, or about to enter it
        self.poses = np.zeros((0, 4))
        self._motion = np.zeros((0, 4))  # change of poses per tick

    # The population

    def manage(
        self, x: float, y: float, *, inner: float = ENTRY_RADIUS, most: int = ENTRIES
    ) -> None:
        """Remove distant walkers, and add others beyond `inner` metres of a place."""
        far = np.hypot(self.poses[:, 0] - x, self.poses[:, 1] - y) > EXIT_RADIUS
        if far.any():
            self._remove(far)
        if not self._density or not len(self._spots):
            return
        spots = self._spots
        away = np.hypot(spots[:, 0] - x, spots[:, 1] - y)
        within = away < FILL_RADIUS
        # `_spots` has both directions
        target = round(self._density * np.count_nonzero(within) * SPACING / 2000.0)
        choices = np.flatnonzero(within & (away > inner))
        for _ in range(min(target - len(self.ids), most) if choices.size else 0):
            place = int(choices[self._draw.randrange(choices.size)])
            self._add(self._headings[place], float(spots[place, 2]))

    def _add(self, heading: Heading, at: float) -> None:
        walk = random_walk(self._ways, heading, at + self._draw.uniform(0.0, SPACING), self._draw)
        number, self._number = self._number, self._number + 1
        row = self._keep(walk)
        self._kerbs[number] = list(walk.kerbs)
        target = self._draw.uniform(*SPEEDS)
        self.ids = np.append(self.ids, number)
        self._row = np.append(self._row, row)
        self._at = np.append(self._at, 0.0)
        self._pace = np.append(self._pace, 0.0)
        self._speed = np.append(self._speed, target)
        self._desired = np.append(self._desired, target)
        self._since = np.append(self._since, math.inf)
        self._stop = np.append(self._stop, self._next_stop(number))
        self._held = np.append(self._held, np.False_)
        self.poses = np.concatenate((self.poses, walk.samples[:1]))
        self._motion = np.concatenate((self._motion, np.zeros((1, 4))))

    def _keep(self, walk: Walk) -> int:
        row = self._free.pop() if self._free else len(self._row)
        if row >= len(self._walks):
            self._walks = np.concatenate((self._walks, np.empty_like(self._walks)))
        self._walks[row] = walk.samples
        return row

    def _remove(self, gone: np.ndarray) -> None:
        for number in self.ids[gone].tolist():
            del self._kerbs[number]
            self._leave_road(number)
        self._free += self._row[gone].tolist()
        kept = ~gone
        self.ids, self._row, self.poses = self.ids[kept], self._row[kept], self.poses[kept]
        self._at, self._speed, self._desired = (
            self._at[kept],
            self._speed[kept],
            self._desired[kept],
        )
        self._stop, self._since = self._stop[kept], self._since[kept]
        self._held, self._pace, self._motion = (
            self._held[kept],
            self._pace[kept],
            self._motion[kept],
        )

    def _next_stop(self, number: int) -> float:
        kerbs = self._kerbs[number]
        return min(kerbs[0].wait if kerbs else math.inf, WALK)

    # Motion

    def step(self, tick: int, ego: EgoState, progress: float, actors: Actors) -> None:
        """Move all by one tick, and show walkers on the road near the ego to SUMO's drivers."""
        if not len(self.ids):
            return
        if tick % LOOK_INTERVAL == 0:
            self._look(ego, progress, actors)
            self._update_pace(tick)
        self._at = self._at + self._pace
        self.poses = self.poses + self._motion
        self._show(tick, ego)

    def _update_pace(self, tick: int) -> None:
        """Set each walker's pace until the next decision."""
        duration = LOOK_INTERVAL * TICK
        distance = np.maximum(self._stop - self._at, 0.0)
        speed = np.minimum(self._speed + STARTING * duration, self._desired)
        speed = np.minimum(speed, np.sqrt(2.0 * STOPPING * distance))
        speed[self._held] = 0.0
        speed = np.minimum(speed, distance / duration)
        speed[speed < 0.02] = 0.0
        self._speed = speed
        self._since = np.where(speed > STANDING, math.inf, np.minimum(self._since, tick))
        self._pace = speed * TICK
        self.poses, then = self._poses(self._at), self._poses(self._at + speed * duration)
        self._motion = (then - self.poses) / LOOK_INTERVAL
        self._motion[:, 2] = wrap_angles(then[:, 2] - self.poses[:, 2]) / LOOK_INTERVAL

    def _look(self, ego: EgoState, progress: float, actors: Actors) -> None:
        """Start permitted crossings, and stop walkers that would collide."""
        deciding = np.flatnonzero(self._stop - self._at < AT_KERB)
        others = moving(actors) if len(deciding) or self._crossing else []
        self._decide(deciding, ego, progress, others)
        self._held = np.zeros(len(self.ids), dtype=bool)
        crossing = np.searchsorted(self.ids, sorted(self._crossing))
        self._held[blocked(self.poses, crossing, ego, others)] = True

    def _poses(self, at: np.ndarray) -> Float[np.ndarray, "walkers 4"]:
        place = at / SAMPLE
        index = place.astype(np.intp)
        share = (place - index)[:, None]
        here, there = self._walks[self._row, index], self._walks[self._row, index + 1]
        turn = wrap_angles(there[:, 2] - here[:, 2])
        poses = here + share * (there - here)
        poses[:, 2] = wrap_angles(here[:, 2] + share[:, 0] * turn)
        return poses

    def _decide(
        self,
        deciding: Int[np.ndarray, " deciding"],
        ego: EgoState,
        progress: float,
        others: Sequence[MovingVehicle],
    ) -> None:
        """Let walkers at a kerb cross if they may."""
        for index in deciding.tolist():
            number = int(self.ids[index])
            if not self._kerbs[number]:
                continue
            kerb = self._kerbs[number][0]
            duration = (kerb.leave - float(self._at[index])) / float(self._desired[index])
            if self._rules.allowed(kerb.crossing, duration, ego, progress, others):
                del self._kerbs[number][0]
                self._crossing[number] = kerb
                self._stop[index] = self._next_stop(number)

    # On the road

    def _show(self, tick: int, ego: EgoState) -> None:
        for number, kerb in sorted(self._crossing.items()):
            index = int(np.searchsorted(self.ids, number))
            at = float(self._at[index])
            if at > kerb.leave:
                self._leave_road(number)
                continue
            x, y, yaw, _ = self.poses[index].tolist()
            near = math.hypot(x - ego.x, y - ego.y) < SHOWN_RADIUS
            if near and at > kerb.enter - 0.3:
                self._sumo_proxies.show(tick, number, (x, y, yaw), float(self._speed[index]))

    def _leave_road(self, number: int) -> None:
        self._crossing.pop(number, None)
        self._sumo_proxies.withdraw(number)

    # What is seen

    def seen(self, x: float, y: float, z: float, sight: float, level: float) -> np.ndarray:
        """Return the rows of walkers in sight of a place and on its level."""
        poses = self.poses
        near = (poses[:, 0] - x) ** 2 + (poses[:, 1] - y) ** 2 < sight**2
        return np.flatnonzero(near & (np.abs(poses[:, 3] - z) < level))

    def actors(self, rows: Int[np.ndarray, " rows"]) -> Actors:
        """Return walkers as actors of a scene."""
        count = len(rows)
        if not count:
            return Actors.none()
        return Actors(
            self.ids[rows],
            self.poses[rows, :3].astype(np.float32),
            self._speed[rows].astype(np.float32),
            _BODIES.repeat(count, axis=0),
            _KINDS.repeat(count),
        )

    def facts(self, tick: int, rows: Int[np.ndarray, " rows"]) -> Privileged:
        """Return privileged facts of walkers: their true paths, and where they will wait."""
        at = self._at[rows]
        place = (at / SAMPLE + 0.5).astype(np.intp) + SAMPLES * self._row[rows]
        stride = round(PATH_STEP / SAMPLE)
        places = place[:, None] + stride * np.arange(PATH_POSES)
        paths = self._walks.reshape(-1, 4).take(places, axis=0)[..., :3]
        waited = np.maximum(tick - self._since[rows], 0.0) * TICK
        stops = self._stop[rows] - at
        return Privileged(paths, np.zeros(len(rows)), self._desired[rows], stops, waited)
