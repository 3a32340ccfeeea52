"""SUMO proxies: small vehicles that represent pedestrians on the road to SUMO's drivers."""

from plant_bench.sim.sumo_commands import Commands
from plant_bench.sim.traffic import Traffic
from plant_bench.sim.vehicle_types import WALKER
from plant_bench.world.actor_ids import SUMO_PROXIES

INTERVAL = 4  # ticks between two placements: the action step of SUMO's drivers


class SumoProxies:
    """The vehicles that represent walkers; mutable.

    Args:
        commands: Commands to SUMO vehicles.
        traffic: The proxies are registered there, so that it leaves them alone.
        edge: Any edge of the network; SUMO needs one to add a vehicle.

    Attributes:
        vehicles: The vehicles by the ids of the walkers they represent.
    """

    def __init__(self, commands: Commands, traffic: Traffic, edge: str) -> None:
        self._commands, self._traffic, self._edge = commands, traffic, edge
        self.vehicles: dict[int, int] = {}
        self._next = SUMO_PROXIES.start

    def show(self, tick: int, walker: int, pose: tuple[float, float, float], speed: float) -> None:
        """Show a walker, by its box centre; call at every tick."""
        vehicle = self.vehicles.get(walker)
        if vehicle is None:
            vehicle = self._spawn(walker)
        elif (tick + walker) % INTERVAL:
            return
        self._commands.place(vehicle, WALKER.length, *pose, speed)

    def withdraw(self, walker: int) -> None:
        """Stop showing a walker, if it is shown."""
        vehicle = self.vehicles.pop(walker, None)
        if vehicle is not None:
            self._traffic.scripted.discard(vehicle)
            self._commands.withdraw(vehicle)

    def _spawn(self, walker: int) -> int:
        """Add a new vehicle, because SUMO may still have the walker's last one."""
        vehicle = self.vehicles[walker] = self._next
        self._next += 1
        self._traffic.types[vehicle] = WALKER
        self._traffic.scripted.add(vehicle)
        self._commands.add_scripted(vehicle, WALKER.name, self._edge)
        return vehicle
