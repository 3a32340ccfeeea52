"""Closed-loop validation: computes a network's driving score during training."""

from dataclasses import dataclass
from pathlib import Path

from plant_bench.data_files import routes_dir
from plant_bench.errors import InputError
from plant_bench.runner.run.episode_queue import SuiteEvent, run_suite
from plant_bench.runner.run.score_run import ScoreRequest, open_run
from plant_bench.runner.run.summary_files import write_summary
from plant_bench.towns.routes import SUITES
from plant_bench.training.threads import threads_kept
from plant_bench.world.route import load_suite


@dataclass(frozen=True)
class ClosedLoop:
    """Settings of the validation runs.

    Attributes:
        suite: A suite's name, or a folder or file of routes.
        routes: Selection of its routes, as in `plant-bench score --routes`; None for all.
        hazards: Whether the routes' hazards are active.
        workers: Number of processes that drive.
    """

    suite: str
    routes: str | None = None
    hazards: bool = True
    workers: int = 1


def closed_loop_score(agent: str, out: Path, drive: ClosedLoop) -> float:
    """Return the driving score of a planner, 0 to 100.

    Args:
        agent: The planner with the current weights, as in `plant-bench score --agent`.
        out: Folder of the run; finished episodes in it are not driven again.
        drive: The routes to drive.

    Raises:
        PlantBenchError: The run cannot start or continue.
    """
    request = ScoreRequest(
        agent=agent,
        suite=drive.suite,
        routes=drive.routes,
        repetitions=1,
        hazards=drive.hazards,
    )
    with threads_kept():
        run = open_run(request, out)
        run_suite(
            run.missing, run.folder, workers=drive.workers, recordings=False, on_event=_ignore
        )
    return write_summary(run.folder).driving_score.mean


def check_suite(suite: str) -> None:
    """Check that a validation suite has no route of the benchmark's suites.

    Raises:
        InputError: It has one, so a model selected on it could not be evaluated on the benchmark;
            or there is no such suite.
    """
    known = {
        route.checksum: name for name in SUITES for route in load_suite(str(routes_dir() / name))
    }
    for route in load_suite(suite):
        if route.checksum in known:
            message = (
                f"--validate-suite {suite} contains {route.id}, a route of the benchmark's suite "
                f"'{known[route.checksum]}': a model selected on it could not be evaluated on it. "
                "Omit the option to drive the held-out routes of the data, or give other routes."
            )
            raise InputError(message)


def _ignore(_event: SuiteEvent) -> None:
    """Ignore an event: a validation shows no progress."""
