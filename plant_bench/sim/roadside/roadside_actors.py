"""Pedestrians and parked cars of one episode: the actors that SUMO does not move."""

from collections.abc import Mapping

import numpy as np

from plant_bench.agent import Privileged
from plant_bench.sim.densities import DENSITIES, density_of
from plant_bench.sim.roadside.parked_cars import ParkedCars
from plant_bench.sim.roadside.pedestrians import Walkers
from plant_bench.sim.roadside.road_crossing import CrossingRules
from plant_bench.sim.roadside.sumo_proxies import SumoProxies
from plant_bench.sim.sumo import Sumo
from plant_bench.sim.town_layout import TownPlaces
from plant_bench.sim.traffic import SIGHT, Traffic
from plant_bench.world.route import Scenario
from plant_bench.world.scene import Actors, EgoState

LEVEL_GAP = 4.5  # m of height between which two roads are levels of a crossing, not one road
LOOK_INTERVAL = 4  # ticks between two updates of the actors in sight


class RoadsideActors:
    """Pedestrians and parked cars of one episode; mutable.

    Args:
        sumo: The running simulation.
        traffic: The vehicles.
        places: The town's places.
        scenario: The scenario; its density scales the number of pedestrians, and density "empty"
            has no parked cars either.
    """

    def __init__(
        self, sumo: Sumo, traffic: Traffic, places: TownPlaces, scenario: Scenario
    ) -> None:
        route = scenario.route
        share = density_of(scenario.density) / DENSITIES["dense"]
        density = places.town.life.walkers_per_km * share
        rules = CrossingRules(sumo.signals, route)
        self._sumo_proxies = SumoProxies(sumo.commands, traffic, route.edges[0])
        self._walkers = Walkers(places.footways, rules, self._sumo_proxies, density, scenario.seed)
        self._parked = ParkedCars(places.parking, scenario) if share else None
        self._looks = 0
        self._rows = np.zeros(0, np.intp)

    @property
    def proxies(self) -> Mapping[int, int]:
        """The SUMO vehicles that represent pedestrians on the road now, by the pedestrians' ids."""
        return self._sumo_proxies.vehicles

    def fill(self, x: float, y: float) -> None:
        """Spawn pedestrians on all sidewalks around the ego, before the episode starts."""
        self._walkers.manage(x, y, inner=0.0, most=10_000)

    def manage(self, x: float, y: float) -> None:
        """Remove distant pedestrians and add others; call every `MANAGE_INTERVAL`."""
        self._walkers.manage(x, y)
        self._looks = 0

    def step(self, tick: int, ego: EgoState, progress: float, actors: Actors) -> None:
        """Move all by one tick.

        Args:
            tick: Tick of the next scene.
            ego: The ego at that tick.
            progress: Arc length of the ego on its route, metres.
            actors: Actors of the previous scene.
        """
        self._walkers.step(tick, ego, progress, actors)

    def look(self, x: float, y: float, z: float) -> tuple[Actors, Actors]:
        """Return the pedestrians and the parked cars in sight of a place."""
        if self._looks % LOOK_INTERVAL == 0:
            self._rows = self._walkers.seen(x, y, z, SIGHT, LEVEL_GAP)
            if self._parked is not None:
                self._parked.look(x, y, z, SIGHT, LEVEL_GAP)
        self._looks += 1
        parked = Actors.none() if self._parked is None else self._parked.seen
        return self._walkers.actors(self._rows), parked

    def facts(self, tick: int) -> tuple[Privileged, ...]:
        """Return the privileged facts of pedestrians and parked cars, in the same order."""
        walkers = self._walkers.facts(tick, self._rows)
        return (walkers,) if self._parked is None else (walkers, self._parked.facts(tick))
