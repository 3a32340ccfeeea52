"""A run that is being driven, on the terminal: its bars, what failed, and how far it came."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import typer
from rich.progress import TaskID, TextColumn

from plant_bench.api import score
from plant_bench.api.score import Driving, Listener, failures_of
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


class RunProgress:
    """Bars on standard error that follow a run's events; progress counts metres of route.

    Args:
        jobs: All jobs of the run.
        missing: Those that are yet to run.
        penalties: By which infractions become scores.
    """

    def __init__(self, jobs: list[Job], missing: list[Job], penalties: PenaltyScheme) -> None:
        self._law = penalties
        self._progress = progress_bars(34, TextColumn("{task.fields[count]:>9}"))
        self._ended = len(jobs) - len(missing)
        self._count = len(jobs)
        self._metres = 0.0  # of episodes that have ended
        total = sum(job.route.length for job in missing)
        self._whole = self._progress.add_task("all episodes", total=total, count="")
        self._bars: dict[int, TaskID] = {}
        self._running: dict[int, float] = {}

    @contextmanager
    def shown(self) -> Iterator[None]:
        """Show the bars as long as the context lasts."""
        with self._progress:
            self._refresh()
            try:
                yield
            finally:
                for bar in self._bars.values():
                    self._progress.remove_task(bar)

    def __call__(self, event: SuiteEvent) -> None:
        """Show what has happened."""
        match event:
            case EpisodeStarted():
                self._show(event.worker, f"{event.job.route.id} r{event.job.repetition}")
            case EpisodeProgressed():
                self._running[event.worker] = event.share * event.job.route.length
                self._progress.update(self._bars[event.worker], completed=event.share)
            case EpisodeRetried():
                self._say(event.job, f"{event.reason} Trying once more.")
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
            self._say(event.job, f"{result.status}: {result.reason}")
        elif not self._progress.console.is_terminal:
            self._say(event.job, f"{result.status}, DS {result.driving_score_by(self._law):.1f}")

    def _show(self, worker: int, text: str) -> None:
        description = f"worker {worker}: {text}"
        if worker in self._bars:
            self._progress.reset(self._bars[worker], description=description)
        else:
            self._bars[worker] = self._progress.add_task(description, total=1.0, count="")

    def _say(self, job: Job, text: str) -> None:
        name = f"{job.route.id} r{job.repetition}"
        self._progress.console.print(f"{name}: {text}", highlight=False, markup=False)

    def _refresh(self) -> None:
        metres = self._metres + sum(self._running.values())
        count = f"{self._ended}/{self._count}"
        self._progress.update(self._whole, completed=metres, count=count)


class Watch:
    """Shows each run that is driven; mutable.

    Attributes:
        run: The one that is driven, or was the last.

    Args:
        penalties: By which infractions become scores.
        named: Say whose run it is.
    """

    def __init__(self, penalties: PenaltyScheme, *, named: bool = False) -> None:
        self.run: Run | None = None
        self._law = penalties
        self._named = named

    @contextmanager
    def __call__(self, run: Run) -> Iterator[Listener]:
        """Show a run as long as the context lasts."""
        self.run = run
        if self._named:
            typer.echo(f"{run.jobs[0].agent}:", err=True)
        for note in run.notes:
            typer.echo(note, err=True)
        progress = RunProgress(run.jobs, run.missing, self._law)
        with progress.shown():
            yield progress

    @contextmanager
    def ending_at_ctrl_c(self) -> Iterator[None]:
        """Say what of the run is kept when Ctrl-C has ended it, and leave.

        Raises:
            typer.Exit: Ctrl-C was pressed.
        """
        try:
            yield
        except KeyboardInterrupt:
            if self.run is None:
                raise
            say_stopped(self.run)
            raise typer.Exit(EXIT_INTERRUPTED) from None


def drive_missing(request: ScoreRequest, out: Path | None, how: Driving) -> Run | None:
    """Drive what of a run has no record, and show how it goes; None if Ctrl-C ended it.

    Raises:
        PlantBenchError: The run cannot be started or cannot go on.
    """
    watch = Watch(how.penalties)
    try:
        return score.drive_missing(request, out, how, watch)
    except KeyboardInterrupt:
        if watch.run is None:
            raise
        say_stopped(watch.run)
        return None


def say_crashes(run: Run) -> int:
    """Tell of episodes that failed for another reason than driving; return the exit code."""
    code = 0
    for failure in failures_of(run):
        code = EXIT_FAILED if failure.status is Status.SIMULATION_CRASHED else EXIT_INPUT
        typer.secho(f"plant-bench: {failure}", err=True, fg=typer.colors.RED)
    return code


def say_stopped(run: Run) -> None:
    """Say what of a run is kept."""
    left = run.unfinished()
    typer.echo(
        f"Stopped. {len(run.jobs) - left} of {len(run.jobs)} episodes are finished and kept in "
        f"{run.folder.path}. The same command again runs the other {left}.",
        err=True,
    )
