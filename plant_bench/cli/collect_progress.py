"""Live progress of `plant-bench collect` on standard error."""

import typer
from rich.progress import TaskID, TextColumn

from plant_bench.cli.progress import progress_bars
from plant_bench.runner.collect.collection import Began, CollectEvent, Ended, TownsPrepared, Went


class CollectProgress:
    """Bars on standard error that follow what is collected; mutable.

    Attributes:
        bars: To be shown as long as it lasts.
        frames: That are in the data so far.

    Args:
        wanted: Frames asked for.
    """

    def __init__(self, wanted: int) -> None:
        self.bars = progress_bars(44, TextColumn("{task.fields[count]:>17}"))
        self.frames = 0
        self._wanted = wanted
        self._whole = self.bars.add_task("preparing towns and routes", total=wanted, count="")
        self._workers: dict[int, TaskID] = {}
        self._driven_s = self._wall_s = self._start_up_s = 0.0
        self._episodes = self._failed = 0

    def __call__(self, event: CollectEvent) -> None:
        """Show what has happened."""
        match event:
            case TownsPrepared():
                self.bars.console.print(f"{event.count} towns are ready.", highlight=False)
            case Began():
                self._begin(event.worker, f"worker {event.worker}: {event.name}")
            case Went():
                self.bars.update(self._workers[event.worker], completed=event.share)
            case Ended():
                self._end(event)

    def say_speed(self, wall_s: float, workers: int) -> None:
        """Print how fast it went, if anything was driven."""
        if not self._episodes:
            typer.echo("Nothing was left to drive: there were enough frames before.")
            return
        typer.echo(
            f"Driven now: {self._episodes} episodes, {self._driven_s / 3600.0:.2f} h simulated in "
            f"{wall_s / 60.0:.1f} min with {workers} workers: {self._driven_s / wall_s:.0f} x real "
            f"time (start-up {self._start_up_s / max(self._wall_s, 1e-9):.0%} of the workers' time)"
        )

    def _begin(self, worker: int, text: str) -> None:
        if worker in self._workers:
            self.bars.reset(self._workers[worker], description=text)
        else:
            self._workers[worker] = self.bars.add_task(text, total=1.0, count="")

    def _end(self, event: Ended) -> None:
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
        count = f"{self.frames:,}/{self._wanted:,}"
        about = f"frames at 2 Hz ({self._failed} episodes left out)"
        self.bars.update(self._whole, completed=self.frames, description=about, count=count)
