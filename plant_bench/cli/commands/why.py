"""`plant-bench why`: explains the infractions of a run."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from plant_bench.cli.number_options import number_option
from plant_bench.cli.options import MOST_REPETITIONS
from plant_bench.cli.progress import exit_on_ctrl_c, progress_bars

if TYPE_CHECKING:
    from rich.progress import Progress, TaskID

    from plant_bench.runner.run.folder import RunFolder
    from plant_bench.scoring.results import EpisodeResult


def explain_run(
    run: Annotated[Path, typer.Argument(help="Folder of a run with recordings.")],
    route: Annotated[
        str | None,
        typer.Argument(help="Id or number of a route. Default: list all infractions of the run."),
    ] = None,
    repetition: Annotated[
        int | None,
        number_option(
            "Repetition of the route. Default: all with infractions.", 0, MOST_REPETITIONS - 1
        ),
    ] = None,
    out: Annotated[
        Path | None, typer.Option(help="PNG file, or folder for images. Default: RUN/why.")
    ] = None,
    before: Annotated[
        float, number_option("Seconds shown before each infraction.", 0.5, 60.0)
    ] = 4.0,
) -> None:
    """Explain infractions: the seconds before each one, and what the expert would have done.

    The episode is simulated again with the recorded controls, and every tick is compared with the
    recording. The expert (for its action) and the planner (for its ranking) are queried at these
    ticks; their actions are not executed.

    Example commands:

        plant-bench why reports/plant-longest6

        plant-bench why reports/plant-longest6 town03-1

        plant-bench why reports/plant-longest6 town03-1 --repetition 0 --out why.png
    """
    from plant_bench.reports.why.incident_list import print_infractions
    from plant_bench.runner.run.folder import RunFolder

    with exit_on_ctrl_c():
        folder = RunFolder.open(run)
        if route is None:
            print_infractions(folder.results(), str(run))
        else:
            _explain(folder, route, repetition, out or folder.path / "why", before)


def _explain(
    folder: "RunFolder", route: str, repetition: int | None, out: Path, before: float
) -> None:
    """Print and draw the infractions of a route, episode by episode."""
    from plant_bench.api.why import explain
    from plant_bench.reports.episode_selection import episodes_of
    from plant_bench.reports.why.incident_text import episode_line, print_episode

    several = len(episodes_of(folder, route, repetition)) > 1
    with _EpisodeBar() as bar:
        for item in explain(folder, route, repetition, before, bar):
            if item.postmortem is None:
                typer.echo(f"{episode_line(item.result)}: no infraction.")
                continue
            print_episode(item.postmortem, item.findings)
            for path in item.save_pictures(out, tagged=several):
                typer.echo(f"Image: {path}")


class _EpisodeBar:
    """A progress bar for each episode, removed before its text is printed; mutable."""

    def __init__(self) -> None:
        self._shown: tuple[Progress, TaskID] | None = None

    def __enter__(self) -> "_EpisodeBar":  # noqa: PYI034 - the run-time type check has no Self
        return self

    def __exit__(self, *_: object) -> None:
        self._end()

    def __call__(self, result: "EpisodeResult", share: float) -> None:
        """Show the progress of an episode, 0 to 1."""
        if self._shown is None:
            from rich.progress import TaskProgressColumn

            bars = progress_bars(len(result.route) + 18, TaskProgressColumn())
            bars.start()
            text = f"{result.route}, repetition {result.repetition}"
            self._shown = bars, bars.add_task(text, total=1.0)
        bars, task = self._shown
        bars.update(task, completed=share)
        if share >= 1.0:
            self._end()

    def _end(self) -> None:
        if self._shown is not None:
            self._shown[0].stop()
            self._shown = None
