"""`plant-bench replay`."""

import dataclasses
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from plant_bench.cli.progress import ending_at_ctrl_c

if TYPE_CHECKING:
    from plant_bench.reports.replay.movie import MovieRequest
    from plant_bench.reports.replay.replay_source import ReplaySource


def replay(
    run: Annotated[Path, typer.Argument(help="A folder that `score --recordings` wrote.")],
    route: Annotated[str, typer.Argument(help="A route's id or number, as town01-0.")],
    repetition: Annotated[
        int | None, typer.Option(help="Of the route; the first one without it.", min=0)
    ] = None,
    against: Annotated[
        Path | None, typer.Option(help="Another run: its drive of the same route beside it.")
    ] = None,
    html: Annotated[Path | None, typer.Option(help="Folder for a page that plays it.")] = None,
    mp4: Annotated[Path | None, typer.Option(help="Film; needs plant-bench[video].")] = None,
    gif: Annotated[Path | None, typer.Option(help="Moving picture of a part.")] = None,
    png: Annotated[
        Path | None, typer.Option(help="Picture of one moment; a strip with --from and --to.")
    ] = None,
    time: Annotated[
        float | None,
        typer.Option(help="Moment of --png, seconds; else the first infraction or the middle."),
    ] = None,
    start: Annotated[float | None, typer.Option("--from", help="First second shown.")] = None,
    end: Annotated[float | None, typer.Option("--to", help="Last second shown.")] = None,
    fps: Annotated[float | None, typer.Option(help="Pictures a second: MP4 20, GIF 10.")] = None,
    dark: Annotated[bool, typer.Option("--dark", help="Pictures in dark colours.")] = False,
    expert: Annotated[
        bool, typer.Option("--expert", help="Show whom the expert would brake for, in blue.")
    ] = False,
) -> None:
    """Show an episode from above, as a page that plays it, a film or a picture.

    The run must have recordings: `plant-bench score --recordings`. A page works from disk, without
    a network; `plant-bench serve` is there for browsers that refuse that.

    Red box: top relevance to the planner. Blue box: whom the expert would brake for; in the run of
    another planner only with --expert, which simulates the episode again (about 0.1 s a second).
    White dashes: whom the planner itself says it brakes for.

    For instance:

        plant-bench replay reports/plant-longest6 town02-5 --html reports/replay

        plant-bench replay reports/plant-longest6 town02-5 --against reports/expert-longest6 --gif
        crash.gif --from 240 --to 250

        plant-bench replay reports/plant-longest6 town02-5 --png crash.png --time 242
    """
    from plant_bench.errors import InputError
    from plant_bench.reports.replay.movie import MovieRequest, check_folder, check_path
    from plant_bench.reports.replay.replay_source import source_in_run

    made = {"png": png, "gif": gif, "mp4": mp4}
    files = {name: path for name, path in made.items() if path is not None}
    if html is None and not files:
        message = "Say what to make of it: --html FOLDER, --png FILE, --gif FILE or --mp4 FILE."
        raise InputError(message)
    wanted = MovieRequest(time, start, end, fps, dark)
    for name, path in files.items():
        check_path(name, path)
    if html is not None:
        check_folder(html)
    sources = [source_in_run(run, route, repetition)]
    if against is not None:
        sources.append(source_in_run(against, route, sources[0].result.repetition))
    wanted.check(max(source.result.duration for source in sources))
    if expert:
        from plant_bench.runner.review.expert_queries import ask_expert

        sources = [dataclasses.replace(source, ask_expert=ask_expert) for source in sources]
    with ending_at_ctrl_c("Stopped. What was half written is removed."):
        if html is not None:
            _write_page(sources, html)
        if files:
            _write_files(sources, files, wanted)


def _write_page(sources: "list[ReplaySource]", out: Path) -> None:
    from rich.progress import MofNCompleteColumn

    from plant_bench.cli.progress import progress_bars
    from plant_bench.reports.replay.replay_site import write_replays
    from plant_bench.reports.replay.replay_source import load_recording

    for source in sources:
        load_recording(source)  # a page would tell as well what is wrong, but later
    with progress_bars(8, MofNCompleteColumn()) as bars:
        bar = bars.add_task("replays", total=len(sources))

        def told(done: int, count: int) -> None:
            bars.update(bar, completed=done, total=count)

        write_replays(out, sources, workers=1, progress=told)
    typer.echo(f"{out / 'replay.html'}#{'&'.join(source.id for source in sources)}")


def _write_files(
    sources: "list[ReplaySource]", files: dict[str, Path], wanted: "MovieRequest"
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

            def told(done: int, count: int, task: TaskID = task) -> None:
                bars.update(task, completed=done, total=count)

            SAVERS[name](episodes, wanted, path, told)
    for path in files.values():
        typer.echo(path)
