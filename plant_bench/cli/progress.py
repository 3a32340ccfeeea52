"""Live progress on the terminal: one bar for each worker and one for the whole run."""

from collections.abc import Iterator
from contextlib import contextmanager

from rich.progress import TaskID, TextColumn

from plant_bench.cli.bars import progress_bars
from plant_bench.runner.episode.jobs import Job
from plant_bench.runner.run.suite import (
    EpisodeEnded,
    EpisodeProgressed,
    EpisodeRetried,
    EpisodeStarted,
    SuiteEvent,
)
from plant_bench.scoring.infractions import Status
from plant_bench.scoring.laws import Law


class RunProgress:
    """Bars on standard error that follow a run's events; progress counts metres of route.

    Args:
        jobs: All jobs of the run.
        missing: Those that are yet to run.
        law: By which infractions become scores.
    """

    def __init__(self, jobs: list[Job], missing: list[Job], law: Law) -> None:
        self._law = law
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
