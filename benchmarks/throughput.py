"""Benchmark: simulated time over wall time, and memory, by planner, town and number of actors.

    python benchmarks/throughput.py
    python benchmarks/throughput.py --agents expert --towns town03 --densities empty light dense

Each planner drives the first route of each town in a separate process, twice; the second drive is
printed, in which caches are warm. Absolute values depend on the machine: compare ratios. `x real`
is of one process; memory is its peak.
"""

import argparse
import multiprocessing
import resource
import tempfile
from pathlib import Path

from plant_bench.agents.loading.checksum import agent_checksum
from plant_bench.data.recording import Recording
from plant_bench.runner.episode.jobs import make_jobs
from plant_bench.runner.episode.loop import run_episode
from plant_bench.world.route import Route, load_suite
from plant_bench.world.town import load_town

HEAD = (
    "planner            density   town     km of lanes  in sight  x real  us/tick:   world  planner"
)


def main() -> None:
    """Print a row for each planner, density and town."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--agents", nargs="+", default=["cruise", "rule-based", "expert", "plant"])
    parser.add_argument("--densities", nargs="+", default=["dense"])
    parser.add_argument("--towns", nargs="+", default=[f"town0{number}" for number in range(1, 7)])
    arguments = parser.parse_args()
    first = {route.town: route for route in reversed(load_suite("longest6"))}
    routes = [first[town] for town in arguments.towns]
    spawn = multiprocessing.get_context("spawn")
    print(HEAD)
    for agent in arguments.agents:
        for density in arguments.densities:
            with spawn.Pool(1) as pool:
                memory = pool.apply(drive, (agent, density, routes))
            print(f"{agent:<18} {density:<9} peak memory {memory:.0f} MB", flush=True)


def drive(agent: str, density: str, routes: list[Route]) -> float:
    """Drive routes, print a row for each, and return the process's peak memory, MB."""
    jobs = make_jobs(agent, agent_checksum(agent), routes, repetitions=1, seed=0, density=density)
    for job in jobs:
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder) / "episode.parquet"
            for _ in range(2):
                timing = run_episode(job, recording=file).timing
            recording = Recording.load(file)
            rows = recording.complete_rows
            in_sight = sum(len(recording[row].actors) for row in rows)
        lanes = load_town(job.route.town).lane_km
        world = 1e6 * (timing.simulation_s + timing.privileged_s) / timing.ticks
        planner = 1e6 * timing.agent_s / timing.ticks
        print(
            f"{agent:<18} {density:<9} {job.route.town:<8} {lanes:11.1f}  "
            f"{in_sight / len(rows):8.1f}  {timing.simulated_s / timing.wall_s:6.0f}  "
            f"{world:16.0f}  {planner:7.0f}",
            flush=True,
        )
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0


if __name__ == "__main__":
    main()
