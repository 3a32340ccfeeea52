"""Runs `plant-bench ablate` and writes its table of results once all variants have been scored.

OUT/ablations.md, ablations.csv   beside the output of `plant_bench.training.ablation_run`
"""

from pathlib import Path

import typer

from plant_bench.api.score import ExecutionSettings
from plant_bench.cli.options import EXIT_INTERRUPTED, print_note
from plant_bench.cli.run_progress import drive_missing, print_failures
from plant_bench.cli.training_progress import train_with_progress
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
    AblationCallbacks,
    AblationRequest,
    Runs,
    recordings_in_all,
    run_ablations,
)
from plant_bench.training.ablation_variants import Variant, variants_of

TABLE, CSV = "ablations.md", "ablations.csv"


def ablate(request: AblationRequest) -> int:
    """Train and score every variant, and write the table.

    Returns:
        The exit code, as for `plant-bench score`.

    Raises:
        PlantBenchError: A training or a run cannot start or continue.
    """

    def drive(score_request: ScoreRequest, out: Path) -> Run | None:
        settings = ExecutionSettings(
            workers=request.machine.workers, overwrite=request.overwrite, recordings=False
        )
        return drive_missing(score_request, out, settings)

    runs = run_ablations(request, AblationCallbacks(train_with_progress, drive, print_note))
    if runs is None:
        return EXIT_INTERRUPTED
    folder = RunFolder(request.out)
    variants = variants_of(request.names, request.base)
    rows = [_row(variant, runs[variant.training]) for variant in variants]
    folder.write(TABLE, ablation_markdown(rows, _facts(request, runs)))
    folder.write(CSV, ablation_csv(rows))
    typer.echo((request.out / TABLE).read_text(encoding="utf-8"))
    typer.echo(f"Table: {request.out / TABLE}")
    return max(print_failures(run) for group in runs.values() for run in group)


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
    """Return the settings that all variants share, by their heading in the table."""
    base, drives = request.base, request.drives
    all_runs = [run for group in runs.values() for run in group]
    processors = speed_of([timing for run in all_runs for timing in _timings(run)]).processors
    routes = len({job.route.id for job in all_runs[0].jobs})
    return {
        "base": f"{base.learner.build().title}, {base.settings.epochs} epochs",
        "data": f"{len(recordings_in_all(request.data, base.share))} episodes",
        "driven": f"{routes} routes of {drives.suite}, {drives.repetitions} repetitions, "
        f"{drives.density} traffic",
        "training seeds": str(request.seeds),
        "IT": f"median time of a forward pass, one thread of {'; '.join(processors) or 'unknown'}",
    }
