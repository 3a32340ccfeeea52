"""`plant-bench replay`: shows an episode from above as a page, video or image."""

import dataclasses
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from plant_bench.cli.number_options import LONGEST_TIME, number_option
from plant_bench.cli.options import MOST_REPETITIONS, GuiOption, GuiSpeedOption
from plant_bench.cli.progress import exit_on_ctrl_c

if TYPE_CHECKING:
    from plant_bench.reports.replay.movie import MovieRequest
    from plant_bench.reports.replay.replay_source import ReplaySource


def replay(
    run: Annotated[Path, typer.Argument(help="Folder of a run with recordings.")],
    route: Annotated[str, typer.Argument(help="Id or number of a route, e.g. town01-0.")],
    repetition: Annotated[
        int | None,
        number_option("Repetition of the route. Default: the first.", 0, MOST_REPETITIONS - 1),
    ] = None,
    against: Annotated[
        Path | None, typer.Option(help="Another run, shown side by side on the same route.")
    ] = None,
    html: Annotated[
        Path | None, typer.Option(help="Folder for an HTML page that plays the episode.")
    ] = None,
    mp4: Annotated[
        Path | None, typer.Option(help="Video file; requires the extra 'video'.")
    ] = None,
    gif: Annotated[
        Path | None,
        typer.Option(help="Animated GIF file; select a part of the episode with --from and --to."),
    ] = None,
    png: Annotated[
        Path | None,
        typer.Option(help="Image file of one moment; with --from and --to a series of images."),
    ] = None,
    time: Annotated[
        float | None,
        number_option(
            "Time of the --png image, seconds. Default: the first infraction, or the middle "
            "of the episode if there is none.",
            0.0,
            LONGEST_TIME,
        ),
    ] = None,
    start: Annotated[
        float | None, number_option("Start of the part, seconds.", 0.0, LONGEST_TIME, "--from")
    ] = None,
    end: Annotated[
        float | None, number_option("End of the part, seconds.", 0.0, LONGEST_TIME, "--to")
    ] = None,
    fps: Annotated[
        float | None,
        number_option("Frames per second. Default: 20 for MP4, 10 for GIF.", 1.0, 60.0),
    ] = None,
    dark: Annotated[bool, typer.Option("--dark", help="Dark colours for images.")] = False,
    gui: GuiOption = False,
    gui_speed: GuiSpeedOption = 1.0,
    expert: Annotated[
        bool,
        typer.Option("--expert", help="Mark in blue the actor that the expert would brake for."),
    ] = False,
) -> None:
    """Show an episode from above, as an HTML page that plays it, a video or an image.

    The run must have recordings (the default of `plant-bench score`). The page opens from disk and
    needs no network; for browsers that block local files use `plant-bench serve`.

    Red box: the actor most relevant to the planner. Blue box: the actor the expert would brake
    for; for other planners only with --expert, which simulates the episode again (about 0.1 s per
    simulated second). White dashes: the actor the planner itself reports braking for.

    Example commands:

        plant-bench replay reports/plant-longest6 town02-5 --html reports/replay

        plant-bench replay reports/plant-longest6 town02-5 --against reports/expert-longest6 --gif
        crash.gif --from 240 --to 250

        plant-bench replay reports/plant-longest6 town02-5 --png crash.png --time 242

        plant-bench replay reports/plant-longest6 town02-5 --gui --gui-speed 4
    """
    from plant_bench.errors import InputError

    if gui:
        others = {
            "--html": html, "--png": png, "--gif": gif, "--mp4": mp4, "--against": against,
            "--time": time, "--from": start, "--to": end, "--fps": fps,
            "--dark": dark or None, "--expert": expert or None,
        }  # fmt: skip
        given = [name for name, value in others.items() if value is not None]
        if given:
            message = (
                f"--gui cannot be combined with {', '.join(given)}: it only shows the episode in "
                "sumo-gui. Run the command once with --gui and once without."
            )
            raise InputError(message)
        _show_in_gui(run, route, repetition, gui_speed)
        return
    from plant_bench.reports.replay.movie import MovieRequest, check_folder, check_path
    from plant_bench.reports.replay.replay_source import source_in_run

    outputs = {"png": png, "gif": gif, "mp4": mp4}
    files = {name: path for name, path in outputs.items() if path is not None}
    if html is None and not files:
        message = (
            "Expected at least one of --html FOLDER, --png FILE, --gif FILE, --mp4 FILE, --gui."
        )
        raise InputError(message)
    request = MovieRequest(time, start, end, fps, dark)
    for name, path in files.items():
        check_path(name, path)
    if html is not None:
        check_folder(html)
    sources = [source_in_run(run, route, repetition)]
    if against is not None:
        sources.append(source_in_run(against, route, sources[0].result.repetition))
    request.check(max(source.result.duration for source in sources))
    if expert:
        from plant_bench.runner.review.expert_queries import ask_expert

        sources = [dataclasses.replace(source, ask_expert=ask_expert) for source in sources]
    with exit_on_ctrl_c("Stopped. Partly written files are removed."):
        if html is not None:
            _write_page(sources, html)
        if files:
            _write_files(sources, files, request)


def _show_in_gui(run: Path, route: str, repetition: int | None, speed: float) -> None:
    """Simulate a recorded episode again in sumo-gui."""
    from plant_bench.api.gui import use_gui

    use_gui(speed)
    from plant_bench.api.why import simulate_recorded  # imports the simulation
    from plant_bench.runner.workers.window import WINDOW_CLOSED, is_window_closed

    with exit_on_ctrl_c("Stopped."):
        try:
            for tick in simulate_recorded(run, route, repetition):
                if tick.difference:
                    typer.echo(f"At tick {tick.row}, the simulation differs: {tick.difference}.")
                    break
        except Exception as error:
            if not is_window_closed(error):
                raise
            typer.echo(WINDOW_CLOSED)


def _write_page(sources: "list[ReplaySource]", out: Path) -> None:
    from rich.progress import MofNCompleteColumn

    from plant_bench.cli.progress import progress_bars
    from plant_bench.reports.replay.replay_site import write_replays
    from plant_bench.reports.replay.replay_source import load_recording

    for source in sources:
        load_recording(source)  # report a broken recording before writing the page
    with progress_bars(8, MofNCompleteColumn()) as bars:
        bar = bars.add_task("replays", total=len(sources))

        def show_progress(done: int, count: int) -> None:
            bars.update(bar, completed=done, total=count)

        write_replays(out, sources, workers=1, progress=show_progress)
    typer.echo(f"{out / 'replay.html'}#{'&'.join(source.id for source in sources)}")


def _write_files(
    sources: "list[ReplaySource]", files: dict[str, Path], request: "MovieRequest"
) -> None:
    from rich.progress import MofNCompleteColumn, TaskID

    from plant_bench.cli.progress import progress_bars
    from plant_bench.reports.replay.movie import SAVERS
    from plant_bench.reports.replay.replay_episode import load_episode

    with progress_bars(8, MofNCompleteColumn()) as bars:
        reading = bars.add_task("reading", total=len(sources))
        episodes = []
        for source in sources:
            episodes.append(load_episode(source))
            bars.advance(reading)
        for name, path in files.items():
            task = bars.add_task(name, total=None)

            def show_progress(done: int, count: int, task: TaskID = task) -> None:
                bars.update(task, completed=done, total=count)

            SAVERS[name](episodes, request, path, show_progress)
    for path in files.values():
        typer.echo(path)
