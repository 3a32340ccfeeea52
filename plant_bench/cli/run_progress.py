"""Drives a run with terminal output: progress bars, failures, and the message after Ctrl-C."""

import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import typer
from rich.progress import TaskID, TextColumn

from plant_bench.api import score
from plant_bench.api.score import ExecutionSettings, Listener, failures_of
from plant_bench.cli.options import EXIT_FAILED, EXIT_INPUT, EXIT_INTERRUPTED
from plant_bench.cli.progress import progress_bars
from plant_bench.runner.episode.jobs import Job
from plant_bench.runner.run.episode_queue import (
    EpisodeEnded,
    EpisodeProgressed,
    EpisodeRetried,
    EpisodeStarted,
    SuiteEvent,
)
from plant_bench.runner.run.score_run import Run, ScoreRequest
from plant_bench.scoring.infractions import Status
from plant_bench.scoring.penalties import PenaltyScheme

QUIET = 60.0  # s without a line in a pipe or file, before one says how far an episode is


class RunProgress:
    """Progress bars that follow the events of a run; progress is in metres of route.

    Args:
        jobs: All jobs of the run.
        missing: The jobs that are still to be run.
        penalties: Penalty scheme of the scores shown.
    """

    def __init__(self, jobs: list[Job], missing: list[Job], penalties: PenaltyScheme) -> None:
        self._penalties = penalties
        self._progress = progress_bars(34, TextColumn("{task.fields[count]:>9}"))
        self._ended = len(jobs) - len(missing)
        self._count = len(jobs)
        self._metres = 0.0  # of episodes that have ended
        total = sum(job.route.length for job in missing)
        self._whole = self._progress.add_task("all episodes", total=total, count="")
        self._bars: dict[int, TaskID] = {}
        self._running: dict[int, float] = {}
        self._last_line = time.monotonic()

    @contextmanager
    def shown(self) -> Iterator[None]:
        """Show the bars within the context."""
        with self._progress:
            self._refresh()
            try:
                yield
            finally:
                for bar in self._bars.values():
                    self._progress.remove_task(bar)

    def __call__(self, event: SuiteEvent) -> None:
        """Update the bars with an event."""
        match event:
            case EpisodeStarted():
                self._show(event.worker, f"{event.job.route.id} r{event.job.repetition}")
            case EpisodeProgressed():
                self._running[event.worker] = event.share * event.job.route.length
                self._progress.update(self._bars[event.worker], completed=event.share)
                quiet = time.monotonic() - self._last_line >= QUIET
                if quiet and not self._progress.console.is_terminal:
                    self._print(event.job, f"{100.0 * event.share:.1f} % of the route driven.")
            case EpisodeRetried():
                self._print(event.job, f"{event.reason} Retrying.")
                self._running.pop(event.worker, None)
            case EpisodeEnded():
                self._end(event)
        self._refresh()

    def _end(self, event: EpisodeEnded) -> None:
        self._running.pop(event.worker, None)
        self._metres += event.job.route.length
        self._ended += 1
        result = event.result
        if result.status in (Status.SIMULATION_CRASHED, Status.AGENT_CRASHED):
            self._print(event.job, f"{result.status}: {result.reason}")
        elif not self._progress.console.is_terminal:
            score = result.driving_score_by(self._penalties)
            self._print(event.job, f"{result.status}, DS {score:.1f}")

    def _show(self, worker: int, text: str) -> None:
        description = f"worker {worker}: {text}"
        if worker in self._bars:
            self._progress.reset(self._bars[worker], description=description)
        else:
            self._bars[worker] = self._progress.add_task(description, total=1.0, count="")

    def _print(self, job: Job, text: str) -> None:
        self._last_line = time.monotonic()
        name = f"{job.route.id} r{job.repetition}"
        self._progress.console.print(f"{name}: {text}", highlight=False, markup=False)

    def _refresh(self) -> None:
        metres = self._metres + sum(self._running.values())
        count = f"{self._ended}/{self._count}"
        self._progress.update(self._whole, completed=metres, count=count)


class RunMonitor:
    """Shows the progress of each run; mutable.

    Attributes:
        run: The current run, or the last one.

    Args:
        penalties: Penalty scheme of the scores shown.
        named: Print the agent's name before each run.
    """

    def __init__(self, penalties: PenaltyScheme, *, named: bool = False) -> None:
        self.run: Run | None = None
        self._penalties = penalties
        self._named = named

    @contextmanager
    def __call__(self, run: Run) -> Iterator[Listener]:
        """Show the progress of a run within the context."""
        self.run = run
        if self._named:
            typer.echo(f"{run.jobs[0].agent}:", err=True)
        for note in run.notes:
            typer.echo(note, err=True)
        progress = RunProgress(run.jobs, run.missing, self._penalties)
        with progress.shown():
            yield progress

    @contextmanager
    def exit_on_ctrl_c(self) -> Iterator[None]:
        """Print which episodes are kept and exit if Ctrl-C is pressed.

        Raises:
            typer.Exit: Ctrl-C was pressed.
        """
        try:
            yield
        except KeyboardInterrupt:
            if self.run is None:
                raise
            print_stopped(self.run)
            raise typer.Exit(EXIT_INTERRUPTED) from None


def drive_missing(
    request: ScoreRequest, out: Path | None, settings: ExecutionSettings
) -> Run | None:
    """Drive the episodes of a run that have no record, with progress bars; None after Ctrl-C.

    Raises:
        PlantBenchError: The run cannot start or continue.
    """
    monitor = RunMonitor(settings.penalties)
    try:
        return score.drive_missing(request, out, settings, monitor)
    except KeyboardInterrupt:
        if monitor.run is None:
            raise
        print_stopped(monitor.run)
        return None


def print_failures(run: Run) -> int:
    """Print the crashes of agent and simulator; return the exit code."""
    code = 0
    for failure in failures_of(run):
        code = EXIT_FAILED if failure.status is Status.SIMULATION_CRASHED else EXIT_INPUT
        typer.secho(f"plant-bench: {failure}", err=True, fg=typer.colors.RED)
    return code


def print_stopped(run: Run) -> None:
    """Print how many episodes of a stopped run are kept."""
    left = run.unfinished()
    typer.echo(
        f"Stopped. {len(run.jobs) - left} of {len(run.jobs)} episodes are finished and kept in "
        f"{run.folder.path}. Run the same command again for the other {left}.",
        err=True,
    )
