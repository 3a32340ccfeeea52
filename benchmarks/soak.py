"""Soak test: odd planners drive many episodes; no crash, and no hazard that blocks the ego.

    python benchmarks/soak.py --episodes 1000
    python benchmarks/soak.py --suite a/routes --suite b/routes --agent expert --episodes 200

An ego is blocked by a hazard if it is at most 40 m from the place of a hazard that was triggered.
The same command continues with what is missing. Exit code 1 if a simulation crashed or a hazard
blocked the ego.
"""

import argparse
import math
import sys
from collections import Counter
from collections.abc import Sequence
from pathlib import Path

import odd_planners

import plant_bench as pb
from plant_bench.errors import PlantBenchError
from plant_bench.scoring.results import EpisodeResult, HazardRecord, Status
from plant_bench.world.hazard import Phase

NEAR = 40.0  # m along the route between a blocked ego and the place of a hazard that blocks it
TRIGGERED = (Phase.COMMITTED, Phase.DONE)  # a dormant or void hazard does not act


def main(arguments: Sequence[str] | None = None) -> int:
    """Drive, count, and print what ended badly.

    Args:
        arguments: Of the command line; None for those of this process.

    Returns:
        1 if a simulation crashed or a hazard blocked the ego, else 0.
    """
    options = _options(arguments)
    file = Path(odd_planners.__file__)
    agents = options.agent or [f"{file}:{name}" for name in odd_planners.NAMES]
    suites = options.suite or ["longest6"]
    routes = sum(len(pb.load_suite(suite)) for suite in suites)
    repetitions = max(1, math.ceil(options.episodes / (routes * len(agents))))
    statuses: Counter[str] = Counter()
    crashes = blocks = 0
    for suite in suites:
        for agent in agents:
            name = agent.rpartition(":")[2] or agent
            run = pb.score(
                agent,
                suite=suite,
                repetitions=repetitions,
                workers=options.workers,
                out=options.out / folder_name(suite) / folder_name(name),
                recordings=False,
            )
            for result in run.results:
                statuses[f"{name}: {result.status.value}"] += 1
                crashes += result.status is Status.SIMULATION_CRASHED
                blocks += bool(blocking_hazards(result))
                if line := ending(result):
                    print(f"{suite} {name} {result.route} r{result.repetition}: {line}")
            print(f"{suite} {name}: {len(run.results)} episodes", flush=True)
    for status, count in sorted(statuses.items()):
        print(f"{count:6d}  {status}")
    total = sum(statuses.values())
    print(f"{total} episodes, {crashes} simulation crashes, {blocks} blocked by a hazard")
    return 1 if crashes or blocks else 0


def blocking_hazards(result: EpisodeResult) -> tuple[HazardRecord, ...]:
    """Return the triggered hazards near a blocked ego; none if it was not blocked."""
    if result.status is not Status.BLOCKED:
        return ()
    return tuple(hazard for hazard in _near(result) if hazard.phase in TRIGGERED)


def ending(result: EpisodeResult) -> str:
    """Describe how an episode crashed or where its ego was blocked; else empty."""
    if result.status is Status.SIMULATION_CRASHED:
        return f"simulation crashed: {result.reason}"
    if result.status is not Status.BLOCKED:
        return ""
    by = ", ".join(map(_words, blocking_hazards(result)))
    others = ", ".join(_words(item) for item in _near(result) if item.phase not in TRIGGERED)
    at = f"at {_place(result):.0f} of {result.route_length:.0f} m"
    nearby = f"; also near: {others}" if others else ""
    return f"blocked by {by} {at}{nearby}" if by else f"blocked, by no hazard, {at}{nearby}"


def folder_name(name: str) -> str:
    """Return a folder's name for a suite or planner.

    >>> folder_name("longest6"), folder_name("../maps/a/routes"), folder_name("plant@models/b")
    ('longest6', 'maps-a-routes', 'plant@models-b')
    """
    return "-".join(part for part in Path(name).parts if part not in ("/", "..")) or "suite"


def _place(result: EpisodeResult) -> float:
    return result.completion * result.route_length


def _near(result: EpisodeResult) -> list[HazardRecord]:
    at = _place(result)
    return [hazard for hazard in result.hazards if abs(hazard.at - at) <= NEAR]


def _words(hazard: HazardRecord) -> str:
    reason = f": {hazard.reason}" if hazard.reason else ""
    return f"{hazard.kind.value} at {hazard.at:.0f} m ({hazard.phase.value}{reason})"


def _options(arguments: Sequence[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument(
        "--suite", action="append", help="route suite or its folder; may be repeated"
    )
    parser.add_argument("--agent", action="append", help="planner; default: the odd planners")
    parser.add_argument("--episodes", type=int, default=1000, help="minimum, in total")
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--out", type=Path, default=Path("reports/soak"))
    return parser.parse_args(arguments)


if __name__ == "__main__":
    try:
        sys.exit(main())
    except PlantBenchError as error:
        print(f"soak.py: {error}", file=sys.stderr)
        sys.exit(2)
