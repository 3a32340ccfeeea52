"""What `plant-bench ablate` does: train and drive each variant, then write the table.

OUT/<training>/seed-N/model       the weights, with a card
OUT/<training>/seed-N/training    checkpoint and logs
OUT/<training>/seed-N/run         an ordinary run of `plant-bench score`
OUT/<training>/seed-N/done.json   what the finished weights were trained as, and on what
OUT/ablations.md, ablations.csv   the table, once all of them have driven
"""

import hashlib
import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path

import typer

from plant_bench.agents.plant.config import WEIGHTS_FILE
from plant_bench.api.score import Driving
from plant_bench.cli.learning import Course, Machine, learn
from plant_bench.cli.options import EXIT_INTERRUPTED
from plant_bench.cli.run_progress import drive_missing, say_crashes
from plant_bench.errors import InputError
from plant_bench.reports.ablations import (
    AblationRow,
    ablation_csv,
    ablation_markdown,
    pooled_scores,
)
from plant_bench.runner.episode.jobs import episode_name, select_routes
from plant_bench.runner.episode.timing import Timing
from plant_bench.runner.run.folder import RunFolder
from plant_bench.runner.run.score_run import Run, ScoreRequest
from plant_bench.runner.run.speed import read_timings, speed_of, write_speed
from plant_bench.runner.run.summary import write_summary
from plant_bench.sim.densities import density_of
from plant_bench.training.ablations import Recipe, Variant, trainings_of, variants_of
from plant_bench.training.shards import recordings_in
from plant_bench.training.threads import threads_kept
from plant_bench.world.route import load_suite

TABLE, CSV, DONE = "ablations.md", "ablations.csv", "done.json"


@dataclass(frozen=True)
class AblationRequest:
    """What is asked for.

    Attributes:
        names: Of the ablations; empty for all.
        base: What they start from.
        data: Folders of the recordings.
        out: Folder of all that is made.
        drives: What is driven; its agent does not count.
        seeds: Trainings of each variant.
        machine: What it runs on.
        overwrite: Make again what is finished.
        graph: Drive with ONNX graphs; in float32, so that sizes differ in nothing else.
    """

    names: Sequence[str]
    base: Recipe
    data: tuple[Path, ...]
    out: Path
    drives: ScoreRequest
    seeds: int
    machine: Machine
    overwrite: bool = False
    graph: bool = False


def ablate(request: AblationRequest) -> int:
    """Train and score every variant, and write the table.

    Returns:
        The exit code, as `plant-bench score`.

    Raises:
        PlantBenchError: A training or a run cannot be started or cannot go on.
    """
    variants = variants_of(request.names, request.base)
    _recordings(request.data)
    select_routes(load_suite(request.drives.suite), request.drives.routes)  # better now than later
    density_of(request.drives.density)
    folder = RunFolder(request.out)
    folder.make("")
    runs: dict[str, list[Run]] = {}
    for name, recipe in trainings_of(variants).items():
        runs[name] = []
        for seed in range(request.seeds):
            run = _train_and_drive(request, name, recipe, seed)
            if run is None:
                return EXIT_INTERRUPTED
            runs[name].append(run)
    rows = [_row(variant, runs[variant.training]) for variant in variants]
    folder.write(TABLE, ablation_markdown(rows, _facts(request, runs)))
    folder.write(CSV, ablation_csv(rows))
    typer.echo((request.out / TABLE).read_text(encoding="utf-8"))
    typer.echo(f"Table: {request.out / TABLE}")
    return max(say_crashes(run) for some in runs.values() for run in some)


def _train_and_drive(request: AblationRequest, name: str, recipe: Recipe, seed: int) -> Run | None:
    """Train a variant and score it; None if Ctrl-C ended it."""
    typer.echo(f"{name}, seed {seed}:", err=True)
    place = request.out / name / f"seed-{seed}"
    seeded = replace(recipe, settings=replace(recipe.settings, seed=seed))
    if not _train(request, seeded, place):
        return None
    with threads_kept():
        run = drive_missing(
            replace(request.drives, agent=f"plant-unguarded@{place / 'model'}"),
            place / "run",
            Driving(workers=request.machine.workers, overwrite=request.overwrite, recordings=False),
        )
    if run is not None:
        write_summary(run.folder)
        write_speed(run.folder, map(episode_name, run.jobs))
    return run


def _train(request: AblationRequest, recipe: Recipe, place: Path) -> bool:
    """Train what is not finished; False if Ctrl-C ended it.

    Raises:
        InputError: The folder holds weights of another training, or the data cannot be used.
    """
    done = place / DONE
    about = _training_text(request.data, recipe)
    if done.is_file() and (place / "model" / WEIGHTS_FILE).is_file() and not request.overwrite:
        if done.read_bytes() == about.encode():
            return True
        message = (
            f"{place} holds weights that were trained otherwise or on other data (see {done}). "
            "Ask for the same, choose another folder with --out, or give --overwrite."
        )
        raise InputError(message)
    finished = learn(
        Course(
            recipe,
            request.data,
            place / "model",
            place / "training",
            request.machine,
            overwrite=request.overwrite,
            graph=32 if request.graph else None,
        )
    )
    if finished:
        RunFolder(place).write(DONE, about)
    return finished


def _recordings(data: tuple[Path, ...], share: float = 1.0) -> list[Path]:
    return [path for folder in data for path in recordings_in(folder, share)]


def _training_text(data: tuple[Path, ...], recipe: Recipe) -> str:
    """Return what a training depends on as text: equal where it need not be made again."""
    names = [f"{path.name} {path.stat().st_size}" for path in _recordings(data, recipe.share)]
    digest = hashlib.sha256("\n".join(names).encode()).hexdigest()
    about = {"recipe": asdict(recipe), "recordings": len(names), "hash": digest}
    return json.dumps(about, indent=1) + "\n"


def _row(variant: Variant, runs: list[Run]) -> AblationRow:
    scores, drives = pooled_scores(
        [
            [
                result
                for job in run.jobs
                if (result := run.folder.record(episode_name(job))) is not None
            ]
            for run in runs
        ]
    )
    speed = speed_of([timing for run in runs for timing in _timings(run)])
    return AblationRow(
        variant.ablation,
        variant.name,
        variant.training,
        scores,
        drives,
        speed.inference_ms,
        variant.paper,
    )


def _timings(run: Run) -> list[Timing]:
    return read_timings(run.folder, map(episode_name, run.jobs))


def _facts(request: AblationRequest, runs: dict[str, list[Run]]) -> dict[str, str]:
    """Return what all variants have in common, for the reader."""
    base, drives = request.base, request.drives
    all_runs = [run for some in runs.values() for run in some]
    processors = speed_of([timing for run in all_runs for timing in _timings(run)]).processors
    routes = len({job.route.id for job in all_runs[0].jobs})
    return {
        "base": f"PlanT {base.config.size}, {base.settings.epochs} epochs",
        "data": f"{len(_recordings(request.data, base.share))} episodes",
        "driven": f"{routes} routes of {drives.suite}, {drives.repetitions} repetitions, "
        f"{drives.density} traffic",
        "seeds of training": str(request.seeds),
        "IT": f"median of a forward pass, one thread of {'; '.join(processors) or 'unknown'}",
    }
