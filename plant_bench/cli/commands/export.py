"""`plant-bench export`: writes a run in the format of other tools."""

from pathlib import Path
from typing import Annotated

import typer

from plant_bench.errors import InputError
from plant_bench.text_escaping import one_line

MOST_DIGITS = 6  # of a repetition


def export_run(
    run: Annotated[Path, typer.Argument(help="Folder of a run.")],
    out: Annotated[Path, typer.Option(help="The file to write.")],
    format_: Annotated[
        str,
        typer.Option(
            "--format",
            help="carla: checkpoint JSON of CARLA's leaderboard. fcd: SUMO's floating car "
            "data (XML, also .gz), of one episode.",
        ),
    ] = "carla",
    route: Annotated[
        str | None, typer.Option(help="With --format fcd: id or number of the route.")
    ] = None,
    repetition: Annotated[
        str | None,
        typer.Option(
            help="Repetition to export: a number from 0, or all. Default: all; with --format fcd "
            "the first. PlanT's own parser reads one only."
        ),
    ] = None,
) -> None:
    """Write a run as a file that other tools read.

    The checkpoint JSON of CARLA's leaderboard (1.0) holds scores, infractions and length of each
    episode. Values that it has no field for are stored under keys named "plant_bench".

    Example commands:

        plant-bench export reports/plant-longest6 --out plant_longest6.json

        plant-bench export reports/plant-longest6 --repetition 0 --out plant_0.json

        plant-bench export reports/plant-longest6 --format fcd --route town01-5 --out a.fcd.xml
    """
    from plant_bench.reports.carla_checkpoint_run import run_checkpoint
    from plant_bench.reports.carla_checkpoint_writing import write_checkpoint
    from plant_bench.reports.tables import counted
    from plant_bench.runner.run.folder import RunFolder

    if format_ not in ("carla", "fcd"):
        message = f"--format: expected carla or fcd, got '{format_}'."
        raise InputError(message)
    only = _repetition(repetition)
    if format_ == "fcd" and repetition == "all":
        message = "--repetition all: --format fcd writes one episode. Give a number from 0."
        raise InputError(message)
    if format_ == "carla" and route is not None:
        message = (
            f"--route {route}: --format carla writes all routes of a run. Leave --route out, or "
            "give --format fcd."
        )
        raise InputError(message)
    if format_ == "fcd":
        _export_fcd(run, out, route, only)
        return
    folder = RunFolder.open(run)
    checkpoint = run_checkpoint(folder, only)
    write_checkpoint(checkpoint.content, out)
    complete = checkpoint.episodes == checkpoint.expected
    missing = "" if complete else f" of {checkpoint.expected}; the run is not finished"
    typer.echo(f"{out}: {counted(checkpoint.episodes, 'episode')}{missing}.")


def _repetition(text: str | None) -> int | None:
    """Return the number of the only repetition to export, None for all."""
    if text is None or text == "all":
        return None
    if not text.isdecimal() or len(text) > MOST_DIGITS:
        message = f"--repetition: expected a number from 0, or all, got '{one_line(text)}'."
        raise InputError(message)
    return int(text)


def _export_fcd(run: Path, out: Path, route: str | None, repetition: int | None) -> None:
    from plant_bench.data.recording import Recording
    from plant_bench.reports.episode_selection import episodes_of
    from plant_bench.reports.fcd import write_fcd
    from plant_bench.reports.tables import counted
    from plant_bench.runner.run.folder import RunFolder

    if route is None:
        message = "--format fcd writes one episode: choose it with --route, such as town01-5."
        raise InputError(message)
    folder = RunFolder.open(run)
    name, _ = episodes_of(folder, route, repetition)[0]
    path = folder.recording_path(name)
    if not path.is_file():
        message = f"{run} has no recording of {name}. Score the run again with --recordings."
        raise InputError(message)
    count = write_fcd(Recording.load(path), out)
    typer.echo(f"{out}: {counted(count, 'time step')} of {name}.")
