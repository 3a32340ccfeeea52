"""Benchmark: time per tick with traffic near the ego only, compared with traffic in the whole town.

    python benchmarks/neighbourhood.py [--seconds 60]

Both drive the same routes at the same density, one after the other in one process; the last column
is their ratio. Only the simulation is timed: SUMO, insertion and removal of traffic, and the scene.
"""

import argparse
import time
from unittest import mock

from plant_bench.agents.cruise import Cruise
from plant_bench.scoring.referee import Referee
from plant_bench.sensing.observe import Sensors
from plant_bench.sim import traffic
from plant_bench.sim.simulation import Simulation
from plant_bench.world.route import Route, Scenario, load_suite
from plant_bench.world.scene import TICK


def cost_of_a_tick(route: Route, seconds: float) -> tuple[float, float]:
    """Return the time per tick, microseconds, and the mean number of vehicles."""
    agent = Cruise()
    agent.reset(route)
    spent, vehicles, ticks = 0.0, 0, 0
    with Simulation(Scenario(route, seed=1)) as simulation:
        referee = Referee(simulation.town, route)
        while ticks < seconds / TICK and referee.status is None:
            scene = simulation.scene
            referee.judge(scene)
            control = agent.act(
                Sensors(route, 0, agent.inputs).observe(scene, referee.progress, referee.offset)
            )
            begin = time.perf_counter()
            simulation.step(control)
            spent += time.perf_counter() - begin
            vehicles += simulation.population
            ticks += 1
    return 1e6 * spent / ticks, vehicles / ticks


def main() -> None:
    """Print a row for each town."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seconds", type=float, default=60.0, help="simulated time on each route")
    seconds = parser.parse_args().seconds
    longest = {route.town: route for route in reversed(load_suite("longest6"))}
    print("town    around the ego        whole town            ratio")
    for town, route in sorted(longest.items()):
        near, some = cost_of_a_tick(route, seconds)
        with mock.patch.multiple(traffic, FILL_RADIUS=1e6, EXIT_RADIUS=1e6):
            full, many = cost_of_a_tick(route, seconds)
        print(
            f"{town}  {near:5.0f} us {some:4.0f} cars   {full:6.0f} us {many:4.0f} cars   "
            f"{full / near:5.1f}"
        )


if __name__ == "__main__":
    main()
