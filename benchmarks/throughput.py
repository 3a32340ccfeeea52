"""Benchmark: simulated time over wall time, and memory, by planner, town and number of actors.

    python benchmarks/throughput.py
    python benchmarks/throughput.py --agents expert --towns town03 --densities empty light dense

Each planner drives the first route of each town in a process of its own, one after the other, and
twice: the second drive is told, in which all that a process works out once is there. Read the
ratios; `x real` is of one process. Memory is the process's peak.
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
    "planner            density   town     km of lanes  in sight  x real  us a tick: world  planner"
)


def main() -> None:
    """Print a row for each planner, density and town."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--agents", nargs="+", default=["cruise", "rule-based", "expert", "plant"])
    parser.add_argument("--densities", nargs="+", default=["dense"])
    parser.add_argument("--towns", nargs="+", default=[f"town0{number}" for number in range(1, 7)])
    given = parser.parse_args()
    first = {route.town: route for route in reversed(load_suite("longest6"))}
    routes = [first[town] for town in given.towns]
    spawn = multiprocessing.get_context("spawn")
    print(HEAD)
    for agent in given.agents:
        for density in given.densities:
            with spawn.Pool(1) as pool:
                memory = pool.apply(drive, (agent, density, routes))
            print(f"{agent:<18} {density:<9} {memory:.0f} MB at most", flush=True)


def drive(agent: str, density: str, routes: list[Route]) -> float:
    """Drive routes, print a row each, and return the process's peak of memory, MB."""
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
