"""How SUMO's drivers see who is on foot on the road: a small vehicle stands for each of them."""

from plant_bench.sim.sumo_commands import Commands
from plant_bench.sim.traffic import Traffic
from plant_bench.sim.vehicle_types import WALKER
from plant_bench.world.actor_ids import STAND_INS

INTERVAL = 4  # ticks between two placements: the action step of SUMO's drivers


class SumoProxies:
    """The vehicles that stand for walkers; mutable.

    Args:
        commands: To the vehicles.
        traffic: Told of the stand-ins, so that it leaves them alone.
        edge: Any edge of the network, on which SUMO is told that they are.
    """

    def __init__(self, commands: Commands, traffic: Traffic, edge: str) -> None:
        self._commands, self._traffic, self._edge = commands, traffic, edge
        self._vehicles: dict[int, int] = {}  # by the walker's number
        self._next = STAND_INS.start

    def show(self, tick: int, walker: int, pose: tuple[float, float, float], speed: float) -> None:
        """Show a walker, by its box centre; call at every tick."""
        vehicle = self._vehicles.get(walker)
        if vehicle is None:
            vehicle = self._put_out(walker)
        elif (tick + walker) % INTERVAL:
            return
        self._commands.place(vehicle, WALKER.length, *pose, speed)

    def withdraw(self, walker: int) -> None:
        """Show a walker no more, if it was shown."""
        vehicle = self._vehicles.pop(walker, None)
        if vehicle is not None:
            self._traffic.scripted.discard(vehicle)
            self._commands.withdraw(vehicle)

    def _put_out(self, walker: int) -> int:
        """Return a new vehicle: SUMO may not have let go of the walker's last one yet."""
        vehicle = self._vehicles[walker] = self._next
        self._next += 1
        self._traffic.types[vehicle] = WALKER
        self._traffic.scripted.add(vehicle)
        self._commands.add_scripted(vehicle, WALKER.name, self._edge)
        return vehicle
