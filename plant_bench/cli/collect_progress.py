"""Progress bars of `plant-bench collect` on standard error."""

import typer
from rich.progress import TaskID, TextColumn

from plant_bench.cli.progress import progress_bars
from plant_bench.runner.collect.collection import (
    CollectEvent,
    DriveEnded,
    DriveProgressed,
    DriveStarted,
    TownsPrepared,
)


class CollectProgress:
    """Progress bars that follow the events of a collection; mutable.

    Attributes:
        bars: The bars; a context manager that shows them.
        frames: Number of frames in the data so far.

    Args:
        target: Number of frames requested.
    """

    def __init__(self, target: int) -> None:
        self.bars = progress_bars(44, TextColumn("{task.fields[count]:>17}"))
        self.frames = 0
        self._target = target
        self._total = self.bars.add_task("preparing towns and routes", total=target, count="")
        self._workers: dict[int, TaskID] = {}
        self._driven_s = self._wall_s = self._start_up_s = 0.0
        self._episodes = self._failed = 0

    def __call__(self, event: CollectEvent) -> None:
        """Update the bars with an event."""
        match event:
            case TownsPrepared():
                self.bars.console.print(f"{event.count} towns are ready.", highlight=False)
            case DriveStarted():
                self._begin(event.worker, f"worker {event.worker}: {event.name}")
            case DriveProgressed():
                self.bars.update(self._workers[event.worker], completed=event.share)
            case DriveEnded():
                self._end(event)

    def print_speed(self, wall_s: float, workers: int) -> None:
        """Print the speed of this collection, if any episode was driven."""
        if not self._episodes:
            typer.echo("Nothing to drive: the data already has enough frames.")
            return
        typer.echo(
            f"Driven: {self._episodes} episodes, {self._driven_s / 3600.0:.2f} h simulated in "
            f"{wall_s / 60.0:.1f} min with {workers} workers: {self._driven_s / wall_s:.0f} x real "
            f"time (start-up: {self._start_up_s / max(self._wall_s, 1e-9):.0%} of worker time)"
        )

    def _begin(self, worker: int, text: str) -> None:
        if worker in self._workers:
            self.bars.reset(self._workers[worker], description=text)
        else:
            self._workers[worker] = self.bars.add_task(text, total=1.0, count="")

    def _end(self, event: DriveEnded) -> None:
        note, timing = event.note, event.timing
        self.frames += 0 if note.left_out else note.frames
        self._failed += bool(note.left_out)
        if event.worker is not None:
            self._episodes += 1
        if timing is not None:
            self._driven_s += timing.simulated_s
            self._wall_s += timing.wall_s
            self._start_up_s += timing.start_up_s
        if event.worker is not None and (note.left_out or not self.bars.console.is_terminal):
            text = note.left_out or f"{note.frames} frames"
            self.bars.console.print(f"{event.name}: {text}", highlight=False, markup=False)
        count = f"{self.frames:,}/{self._target:,}"
        description = f"frames at 2 Hz ({self._failed} episodes excluded)"
        self.bars.update(self._total, completed=self.frames, description=description, count=count)
