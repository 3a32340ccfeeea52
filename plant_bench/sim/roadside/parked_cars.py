"""Parked cars beside quiet streets, known to the ego, the referee and planners, but not to SUMO.

The places depend on the town; which of them are occupied depends on the episode.
"""

import random
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float

from plant_bench.agent import PATH_POSES, Privileged
from plant_bench.geometry.box import corners
from plant_bench.sim.roadside.lane_distance import Roadway
from plant_bench.world.actor_ids import PARKED
from plant_bench.world.hazard_table import HAZARDS
from plant_bench.world.route import Scenario
from plant_bench.world.scene import TICK, ActorKind, Actors
from plant_bench.world.town import Lane, Town

QUIET = 13.9  # m/s: cars are parked where the limit is not above 50 km/h
FROM_LANE = 0.3  # m between a car and the lane beside it, at least
FROM_ENDS = 12.0  # m kept free at both ends of an edge
GAPS = (0.8, 1.6)  # m between two places
FILLED = 0.7  # share of the places that are taken
SIZES = ((3.97, 1.75), (4.47, 1.84), (4.86, 1.92), (5.32, 2.01))  # m, as the traffic's cars
VAN_LENGTH = 5.0  # m from which a car is a van


@dataclass(frozen=True, eq=False)
class Places:
    """Where cars may be parked in a town; immutable.

    Attributes:
        edges: The edges beside which they are.
        poses: Box centres x, y, yaw.
        heights: z, metres.
        extents: Lengths and widths.
    """

    edges: frozenset[str]
    poses: Float[np.ndarray, "places 3"]
    heights: Float[np.ndarray, " places"]
    extents: Float[np.ndarray, "places 2"]


def parking_places(town: Town, roadway: Roadway) -> Places:
    """Choose street sides and the places along them; deterministic for a town's name."""
    draw = random.Random(f"parked cars of {town.name}")
    sides = [
        lanes[0]
        for lanes in town.edges.values()
        if lanes[0].index == 1 and lanes[0].speed_limit <= QUIET  # lane 0 is a sidewalk
    ]
    chosen = [lane for lane in sides if draw.random() < town.life.parking]
    rows = [row for lane in chosen for row in _along(lane, draw)]
    table = np.array(rows, dtype=float).reshape(-1, 6)
    keep = np.array([_clear(row, roadway) for row in table], dtype=bool)
    table = table[keep]
    edges = frozenset(lane.edge for lane in chosen)
    return Places(edges, table[:, :3], table[:, 3], table[:, 4:])


def _along(lane: Lane, draw: random.Random) -> list[tuple[float, ...]]:
    """Return x, y, yaw, z, length and width of the places to the right of a lane."""
    rows = []
    at = FROM_ENDS
    while True:
        length, width = draw.choice(SIZES)
        middle, at = at + 0.5 * length, at + length
        if at > lane.length - FROM_ENDS:
            return rows
        x, y, z = (float(np.interp(middle, lane.along, lane.points[:, axis])) for axis in range(3))
        ahead, back = (
            [np.interp(middle + by, lane.along, lane.points[:, axis]) for axis in (0, 1)]
            for by in (2.0, -2.0)
        )
        yaw = float(np.arctan2(ahead[1] - back[1], ahead[0] - back[0]))
        aside = 0.5 * lane.width + FROM_LANE + 0.02 + 0.5 * width
        rows.append((x + aside * np.sin(yaw), y - aside * np.cos(yaw), yaw, z, length, width))
        at += draw.uniform(*GAPS)


def _clear(row: Float[np.ndarray, " 6"], roadway: Roadway) -> bool:
    points = corners(row[None, :3], row[None, 4:])[0]
    edges = [points + share * (np.roll(points, -1, axis=0) - points) for share in (0.0, 0.33, 0.67)]
    return bool((roadway.clearance(np.concatenate(edges)) >= FROM_LANE - 0.02).all())


class ParkedCars:
    """The parked cars of one episode; immutable except for the cars in sight.

    Args:
        places: The town's parking places.
        scenario: Its seed selects the occupied places; its hazards keep some free.
    """

    def __init__(self, places: Places, scenario: Scenario) -> None:
        draw = random.Random(scenario.seed ^ PARKED.start)
        taken = np.array([draw.random() < FILLED for _ in places.poses], dtype=bool)
        taken &= ~_kept_free(places, scenario)
        kinds = np.where(places.extents[:, 0] > VAN_LENGTH, ActorKind.VAN, ActorKind.CAR)
        count = int(taken.sum())
        self._heights = places.heights[taken]
        self.all = Actors(
            PARKED.start + np.arange(count),
            places.poses[taken].astype(np.float32),
            np.zeros(count, np.float32),
            places.extents[taken].astype(np.float32),
            kinds[taken].astype(np.uint8),
        )
        self._seen = self.all.only(np.zeros(0, np.intp))
        self._paths = np.zeros((0, PATH_POSES, 3))

    def look(self, x: float, y: float, z: float, sight: float, level: float) -> None:
        """Update the cars in sight of a place and on its level."""
        poses = self.all.poses
        near = (poses[:, 0] - x) ** 2 + (poses[:, 1] - y) ** 2 < sight**2
        chosen = np.flatnonzero(near & (np.abs(self._heights - z) < level))
        if not np.array_equal(PARKED.start + chosen, self._seen.ids):
            self._seen = self.all.only(chosen)
            standing = self._seen.poses[:, None].astype(float)
            self._paths = np.tile(standing, (1, PATH_POSES, 1))

    @property
    def seen(self) -> Actors:
        """The cars in sight, ordered by id."""
        return self._seen

    def facts(self, tick: int) -> Privileged:
        """Return the privileged facts of the cars in sight: they are stationary."""
        still = np.zeros(len(self._seen))
        return Privileged(self._paths, still, still, still, np.full(len(still), tick * TICK))


def _kept_free(places: Places, scenario: Scenario) -> Bool[np.ndarray, " places"]:
    """Return a mask of the places too near to a hazard of the scenario."""
    free = np.zeros(len(places.poses), dtype=bool)
    route = scenario.route
    for hazard in scenario.played_hazards:
        around = HAZARDS[hazard.kind].kept_free
        if around:
            x, y = (np.interp(hazard.at, route.along, route.points[:, axis]) for axis in (0, 1))
            away = np.hypot(places.poses[:, 0] - x, places.poses[:, 1] - y)
            free |= away < around + 0.5 * places.extents[:, 0]
    return free
