"""Runs a scenario in SUMO: takes the ego's controls and returns scenes."""

import math
from bisect import bisect_right

import numpy as np

from plant_bench.agent import Control, Privileged
from plant_bench.geometry.polyline import Cursor
from plant_bench.geometry.pose import wrap_angle
from plant_bench.sim.densities import density_of
from plant_bench.sim.ego import advance
from plant_bench.sim.gridlock import Gridlock
from plant_bench.sim.hazards.director import Director
from plant_bench.sim.hazards.hazard_world import HazardWorld
from plant_bench.sim.lane_paths import LanePaths
from plant_bench.sim.roadside.roadside_actors import LEVEL_GAP, RoadsideActors
from plant_bench.sim.scene_builder import join, join_facts, vehicle_actors
from plant_bench.sim.sumo import Sumo, VehicleState
from plant_bench.sim.town_layout import places_of
from plant_bench.sim.traffic import MANAGE_INTERVAL, SIGHT, Traffic
from plant_bench.world.actor_ids import TRAFFIC
from plant_bench.world.hazard import HazardOutcome
from plant_bench.world.route import Scenario
from plant_bench.world.scene import EGO_LENGTH, TICK, Actors, EgoState, Scene
from plant_bench.world.town import Lane

WARM_UP = 300  # ticks of traffic before the episode starts: 15 s
LIGHT_SIGHT = 60.0  # m ahead of the ego's centre at which a light comes into view
LIGHT_BEHIND = 25.0  # m behind the ego's centre until which a light is still known


class Simulation:
    """One scenario in SUMO; a context manager, mutable, one per process.

    with Simulation(scenario) as simulation:
        scene = simulation.scene
        while ...:
            scene = simulation.step(control)

    Args:
        scenario: All that the episode depends on.
        self_driving: Let SUMO's driver drive the ego; controls are ignored then.

    Raises:
        InputError: The scenario's town or density does not exist.
        SimulationError: SUMO fails.
    """

    def __init__(self, scenario: Scenario, *, self_driving: bool = False) -> None:
        route = scenario.route
        self._scenario = scenario
        self._self_driving = self_driving
        places = places_of(route.town, route.town_folders)
        self.town = places.town
        density = density_of(scenario.density)
        self._sumo = Sumo(route.town_dir / "town.net.xml", scenario.seed)
        self._cursor = Cursor(route.points)
        self._elevations = route.elevations.tolist()
        self._signals = route.signal_passages
        self._entries = route.signal_entries
        self._traffic = Traffic(self._sumo, places.streets, density, scenario.seed)
        self._paths = LanePaths(self._sumo, self.town)
        self._hazard_world = HazardWorld(self._sumo, self._traffic, self.town, route)
        self._director = Director(self._hazard_world, scenario.played_hazards, scenario.seed)
        self._roadside = RoadsideActors(self._sumo, self._traffic, places, scenario)
        self._gridlock = Gridlock(
            self._sumo.commands, self._traffic.scripted, self._roadside.proxies
        )
        self._states: dict[int, VehicleState] = {}
        try:
            self._warm_up()
            self._sumo.show(route.points, _places_of(scenario))
            self.scene = self._look(0, self._start())
        except BaseException:
            self.close()
            raise

    def __enter__(self) -> "Simulation":  # noqa: PYI034 - as in sumo.py
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """End SUMO; the process may then start another simulation."""
        self._sumo.__exit__()

    def step(self, control: Control) -> Scene:
        """Advance the world by one tick and return the new scene.

        Raises:
            SimulationError: SUMO has lost the ego.
        """
        tick = self.scene.tick + 1
        if not self._self_driving:
            ego = advance(self.scene.ego, self._director.disturb(control))
        else:
            ego = self.scene.ego
        if tick % MANAGE_INTERVAL == 0:
            self._traffic.manage(ego.x, ego.y)
            self._roadside.manage(ego.x, ego.y)
        self._present(ego)
        self._cursor.advance(ego.x, ego.y)
        self._hazard_world.refresh(tick, self._cursor.progress, self._states)
        if not self._director.idle:
            self._director.step(ego)
        self._roadside.step(tick, ego, self._cursor.progress, self.scene.actors)
        self._sumo.step()
        if self._self_driving:
            ego = self._driven(ego)
        self.scene = self._look(tick, ego)
        self._gridlock.step(tick, ego, self.scene.actors, self._states, self.privileged)
        return self.scene

    @property
    def outcomes(self) -> tuple[HazardOutcome, ...]:
        """The outcomes of the route's hazards."""
        return self._director.outcomes

    @property
    def population(self) -> int:
        """Number of vehicles in the simulation, visible or not, without the ego."""
        return len(self._sumo.vehicles())

    def privileged(self) -> Privileged:
        """Return the privileged facts of the current scene's actors."""
        scene = self.scene
        vehicles = self._paths.facts(
            scene.tick, scene.actors, self._states, self._hazard_world.paths
        )
        return join_facts(vehicles, *self._roadside.facts(scene.tick))

    def _start(self) -> EgoState:
        x, y = self._scenario.route.points[0].tolist()
        return EgoState(x, y, float(self._scenario.route.headings[0]), 0.0)

    def _warm_up(self) -> None:
        start = self._start()
        route = self._scenario.route
        if self._self_driving:
            lane, at = self._start_lane()
            self._sumo.add_self_driving_ego(route.edges, lane.index, at)
        else:
            self._sumo.add_ego(route.edges, *start.pose)
        self._sumo.watch(SIGHT)
        self._traffic.fill(start.x, start.y)
        self._roadside.fill(start.x, start.y)
        for tick in range(WARM_UP):
            if tick % MANAGE_INTERVAL == 0:
                self._traffic.manage(start.x, start.y)
            self._present(start)
            self._roadside.step(tick - WARM_UP, start, 0.0, Actors.none())
            self._sumo.step()
        if self._self_driving:
            self._sumo.let_ego_go()

    def _present(self, ego: EgoState) -> None:
        """Show the ego to SUMO, unless SUMO drives it."""
        if not self._self_driving:
            self._sumo.move_ego(ego.x, ego.y, ego.yaw, ego.speed)

    def _start_lane(self) -> tuple[Lane, float]:
        """Return the route's first lane, and SUMO's position of the ego's front on it."""
        route = self._scenario.route
        lane = self.town.lanes[route.lanes[0].lane]
        away = np.hypot(*(lane.points[:, :2] - route.points[0]).T)
        front = float(lane.along[away.argmin()]) + 0.5 * EGO_LENGTH
        return lane, front * self._sumo.lane_length(lane.id) / lane.length

    def _driven(self, before: EgoState) -> EgoState:
        """Return the state of the ego that SUMO drives."""
        state = self._sumo.ego()
        half = 0.5 * EGO_LENGTH
        return EgoState(
            x=state.x - half * math.cos(state.yaw),
            y=state.y - half * math.sin(state.yaw),
            yaw=wrap_angle(state.yaw),
            speed=state.speed,
            acceleration=(state.speed - before.speed) / TICK,
        )

    def _look(self, tick: int, ego: EgoState) -> Scene:
        height = self._elevations[self._cursor.index]
        seen = self._sumo.watched()
        if beside := self._hazard_world.beside_road(seen):
            seen = {**seen, **beside}
        self._states = {
            key: state
            for key, state in sorted(seen.items())
            if key in TRAFFIC and abs(state.z - height) < LEVEL_GAP
        }
        vehicles = vehicle_actors(self._states, self._traffic.types)
        actors = join(vehicles, *self._roadside.look(ego.x, ego.y, height))
        return Scene(tick, ego, actors, self._see_lights())

    def _see_lights(self) -> np.ndarray:
        at = self._cursor.progress
        lights = np.zeros(len(self._entries), np.uint8)
        first = bisect_right(self._entries, at - LIGHT_BEHIND)
        last = bisect_right(self._entries, at + LIGHT_SIGHT)
        for index in range(first, last):
            passage = self._signals[index]
            if passage.signal is not None:
                lights[index] = self._sumo.signals.light(passage.signal, passage.signal_index)
        return lights


def _places_of(scenario: Scenario) -> list[tuple[str, float, float]]:
    """Return the kind and the place of each of a scenario's hazards."""
    route = scenario.route
    x, y = route.points.T
    return [
        (
            hazard.kind.value,
            float(np.interp(hazard.at, route.along, x)),
            float(np.interp(hazard.at, route.along, y)),
        )
        for hazard in scenario.played_hazards
    ]
