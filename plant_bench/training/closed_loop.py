"""Closed-loop validation: scores a network during training by letting it drive."""

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
    """What is driven for validation.

    Attributes:
        suite: A suite's name, or a folder or file of routes.
        routes: Selection of them, as in `plant-bench score --routes`.
        hazards: Whether their hazards are played.
        workers: Processes.
    """

    suite: str
    routes: str | None = None
    hazards: bool = True
    workers: int = 1


def closed_loop_score(agent: str, out: Path, drive: ClosedLoop) -> float:
    """Return the driving score, 0 to 100, of a planner.

    Args:
        agent: As for `plant-bench score --agent`: it drives with the model in training.
        out: Folder of the run; what is finished there is not driven again.
        drive: What to drive.

    Raises:
        PlantBenchError: The run cannot be made.
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
            run.missing, run.folder, workers=drive.workers, recordings=False, on_event=_not_shown
        )
    return write_summary(run.folder).driving_score.mean


def check_suite(suite: str) -> None:
    """Check that a suite is none of the benchmark's, nor holds a route of theirs.

    Raises:
        InputError: It is or does: weights chosen by a score on it have a score there that says
            nothing. Or there is no such suite.
    """
    known = {
        route.checksum: name for name in SUITES for route in load_suite(str(routes_dir() / name))
    }
    for route in load_suite(suite):
        if route.checksum in known:
            message = (
                f"--validate-suite {suite} holds {route.id}, a route of the benchmark's suite "
                f"'{known[route.checksum]}': weights chosen by it could not be scored on it. Leave "
                "the option out to drive the routes held out of the data, or give other routes."
            )
            raise InputError(message)


def _not_shown(_event: SuiteEvent) -> None:
    """Take no notice."""
