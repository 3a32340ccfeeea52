"""What `plant-bench ablate` shows, and the table that it writes once all variants have driven.

OUT/ablations.md, ablations.csv   beside what `plant_bench.training.ablation_run` makes
"""

from pathlib import Path

import typer

from plant_bench.api.score import Driving
from plant_bench.cli.options import EXIT_INTERRUPTED
from plant_bench.cli.run_progress import drive_missing, say_crashes
from plant_bench.cli.training_progress import learn_visibly
from plant_bench.reports.ablation_report import (
    AblationRow,
    ablation_csv,
    ablation_markdown,
    pooled_scores,
)
from plant_bench.runner.episode.jobs import episode_name
from plant_bench.runner.episode.timing import Timing
from plant_bench.runner.run.folder import RunFolder
from plant_bench.runner.run.score_run import Run, ScoreRequest
from plant_bench.runner.run.speed import read_timings, speed_of
from plant_bench.training.ablation_run import (
    AblationRequest,
    Helpers,
    Runs,
    recordings_of,
    run_ablations,
)
from plant_bench.training.ablation_variants import Variant, variants_of

TABLE, CSV = "ablations.md", "ablations.csv"


def ablate(request: AblationRequest) -> int:
    """Train and score every variant, and write the table.

    Returns:
        The exit code, as `plant-bench score`.

    Raises:
        PlantBenchError: A training or a run cannot be started or cannot go on.
    """

    def drive(asked: ScoreRequest, out: Path) -> Run | None:
        driving = Driving(
            workers=request.machine.workers, overwrite=request.overwrite, recordings=False
        )
        return drive_missing(asked, out, driving)

    runs = run_ablations(request, Helpers(learn_visibly, drive, _tell))
    if runs is None:
        return EXIT_INTERRUPTED
    folder = RunFolder(request.out)
    variants = variants_of(request.names, request.base)
    rows = [_row(variant, runs[variant.training]) for variant in variants]
    folder.write(TABLE, ablation_markdown(rows, _facts(request, runs)))
    folder.write(CSV, ablation_csv(rows))
    typer.echo((request.out / TABLE).read_text(encoding="utf-8"))
    typer.echo(f"Table: {request.out / TABLE}")
    return max(say_crashes(run) for some in runs.values() for run in some)


def _tell(text: str) -> None:
    typer.echo(text, err=True)


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


def _facts(request: AblationRequest, runs: Runs) -> dict[str, str]:
    """Return what all variants have in common, for the reader."""
    base, drives = request.base, request.drives
    all_runs = [run for some in runs.values() for run in some]
    processors = speed_of([timing for run in all_runs for timing in _timings(run)]).processors
    routes = len({job.route.id for job in all_runs[0].jobs})
    return {
        "base": f"{base.student.learner().title}, {base.settings.epochs} epochs",
        "data": f"{len(recordings_of(request.data, base.share))} episodes",
        "driven": f"{routes} routes of {drives.suite}, {drives.repetitions} repetitions, "
        f"{drives.density} traffic",
        "seeds of training": str(request.seeds),
        "IT": f"median of a forward pass, one thread of {'; '.join(processors) or 'unknown'}",
    }
