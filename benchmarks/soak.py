"""Soak test: odd planners drive many episodes; no simulation may crash, every block is explained.

    python benchmarks/soak.py --episodes 1000 --out reports/soak
    python benchmarks/soak.py --suite mymaps/routes --agent expert --episodes 200 --out reports/soak

The same command continues with what is missing. Exit code 1 if a simulation crashed.
"""

import argparse
import math
import sys
from collections import Counter
from pathlib import Path

import plant_bench as pb
from plant_bench.scoring.results import EpisodeResult, Status

HERE = Path(__file__).resolve().parent
ODD = ("Late", "Jerky", "OffTheLane", "StopsAnywhere", "Random", "Reverse")
NEAR = 40.0  # m between a blocked ego and the place of a hazard that may block it


def main() -> int:
    """Drive, count, and print what ended badly."""
    options = _options()
    agents = options.agent or [f"{HERE / 'odd_planners.py'}:{name}" for name in ODD]
    routes = len(pb.load_suite(options.suite))
    repetitions = max(1, math.ceil(options.episodes / (routes * len(agents))))
    statuses: Counter[str] = Counter()
    crashed = 0
    for agent in agents:
        name = agent.rpartition(":")[2] or agent
        run = pb.score(
            agent,
            suite=options.suite,
            repetitions=repetitions,
            workers=options.workers,
            out=options.out / name,
            recordings=False,
        )
        for result in run.results:
            statuses[f"{name}: {result.status.value}"] += 1
            if result.status is Status.SIMULATION_CRASHED:
                crashed += 1
                print(f"CRASH  {name} {result.route} r{result.repetition}: {result.reason}")
            elif result.status is Status.BLOCKED:
                print(f"block  {name} {result.route} r{result.repetition}: {_block(result)}")
        print(f"{name}: {len(run.results)} episodes", flush=True)
    for status, count in sorted(statuses.items()):
        print(f"{count:6d}  {status}")
    print(f"{sum(statuses.values())} episodes, {crashed} simulation crashes")
    return 1 if crashed else 0


def _block(result: EpisodeResult) -> str:
    """Describe where an ego was blocked, and which hazard was near."""
    at = result.completion * result.route_length
    near = [
        f"{hazard.kind.value} at {hazard.at:.0f} m ({hazard.phase.value} {hazard.reason})".strip()
        for hazard in result.hazards
        if abs(hazard.at - at) < NEAR
    ]
    return f"at {at:.0f} of {result.route_length:.0f} m, hazards near: {', '.join(near) or 'none'}"


def _options() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--suite", default="longest6", help="route suite, or its folder")
    parser.add_argument("--agent", action="append", help="planner; default: the odd planners")
    parser.add_argument("--episodes", type=int, default=1000, help="at least so many in total")
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--out", type=Path, default=Path("reports/soak"))
    return parser.parse_args()


if __name__ == "__main__":
    sys.exit(main())
