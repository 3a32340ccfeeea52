"""Profiles an episode: time by part of the loop, and by function.

    python benchmarks/profile_episode.py [--agent expert] [--route town05-0] [--functions 25]

The parts are timed without the profiler, in three runs; the list of functions is of a fourth run
with the profiler, which inflates times, so only its order is meaningful.
"""

import argparse
import cProfile
import pstats
import statistics
import tempfile
from pathlib import Path

from plant_bench.agents.loading.checksum import agent_checksum
from plant_bench.runner.episode.jobs import make_jobs
from plant_bench.runner.episode.loop import run_episode
from plant_bench.runner.episode.timing import Timing
from plant_bench.world.route import load_suite

PARTS = ("start_up", "simulation", "privileged", "agent", "referee", "recording")


def main() -> None:
    """Print both tables."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--agent", default="expert")
    parser.add_argument("--route", default="town05-0")
    parser.add_argument("--functions", type=int, default=25)
    options = parser.parse_args()
    routes = [route for route in load_suite("longest6") if route.id == options.route]
    job = make_jobs(
        options.agent,
        agent_checksum(options.agent),
        routes,
        repetitions=1,
        seed=0,
        density="dense",
    )[0]
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "episode.parquet"
        run_episode(job, recording=file)  # warm-up
        timings = [run_episode(job, recording=file).timing for _ in range(3)]
        profile = cProfile.Profile()
        profile.enable()
        run_episode(job, recording=file)
        profile.disable()
    print_parts(timings)
    pstats.Stats(profile).sort_stats("tottime").print_stats(options.functions)


def print_parts(timings: list[Timing]) -> None:
    """Print the median share of each part, and the speed of the episode."""
    walls = [timing.wall_s for timing in timings]
    for part in PARTS:
        shares = [getattr(timing, f"{part}_s") / timing.wall_s for timing in timings]
        print(f"{part:<12} {100.0 * statistics.median(shares):5.1f} %")
    speed = timings[0].simulated_s / statistics.median(walls)
    print(f"one process: {speed:.0f} x real time, {timings[0].ticks} ticks")


if __name__ == "__main__":
    main()
