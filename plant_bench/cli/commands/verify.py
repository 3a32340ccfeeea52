"""`plant-bench verify`: checks a run, scores its recordings and simulates a sample again."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from plant_bench.api.numbers import HIGHEST_SEED, MOST_PROCESSES
from plant_bench.atomic_files import write_whole_text
from plant_bench.cli.number_options import number_option
from plant_bench.cli.options import (
    CORES,
    MOST_REPETITIONS,
    IsolateOption,
    MemoryLimitOption,
    StartUpLimitOption,
    TickLimitOption,
)
from plant_bench.cli.progress import exit_on_ctrl_c, progress_bars
from plant_bench.errors import InputError

if TYPE_CHECKING:
    from plant_bench.api.verify import VerifyRequest
    from plant_bench.reports.verification_report import Verification


def verify_run(
    run: Annotated[Path, typer.Argument(help="Folder of the run, from this or another machine.")],
    sample: Annotated[
        str | None,
        typer.Option(
            help="Episodes to simulate again: a percentage or a number of at least 1. Default: 10%."
        ),
    ] = None,
    all_episodes: Annotated[
        bool, typer.Option("--all", help="Simulate all episodes again.")
    ] = False,
    seed: Annotated[
        int | None,
        number_option("Seed of the sample. Default: a new one each time.", 0, HIGHEST_SEED),
    ] = None,
    workers: Annotated[int, number_option("Number of processes.", 1, MOST_PROCESSES)] = CORES,
    agent: Annotated[
        str | None,
        typer.Option(
            help="Planner that drives the sample, as for `score`. Its code is executed, so name "
            "only one that you trust."
        ),
    ] = None,
    controls: Annotated[
        bool, typer.Option("--controls", help="Execute the recorded controls instead of the agent.")
    ] = False,
    suite: Annotated[
        str | None,
        typer.Option(
            help="Suite from a source that you trust; required if the run's suite is not built in."
        ),
    ] = None,
    routes: Annotated[
        str | None, typer.Option(help="Routes that the run must contain. Default: all.")
    ] = None,
    repetitions: Annotated[
        int | None,
        number_option(
            "Repetitions per route that the run must contain. Default: as many as it has.",
            1,
            MOST_REPETITIONS,
        ),
    ] = None,
    json: Annotated[Path | None, typer.Option(help="Write the findings to this JSON file.")] = None,
    isolate: IsolateOption = False,
    tick_limit: TickLimitOption = None,
    start_up_limit: StartUpLimitOption = None,
    memory_limit: MemoryLimitOption = None,
) -> None:
    """Verify a run's scores: check all its files, and simulate a sample of its episodes again.

    Records, names, checksums and summary are checked for all episodes, and every recording is
    scored again without the simulator. A sample from all towns is simulated again: with the agent
    if it is built in and has the same checksum, or is named with --agent; otherwise with the
    recorded controls. Nothing in RUN is executed or changed. Exit codes: 0 confirmed, 1 a
    difference, 2 the run cannot be checked.

    Example commands:

        plant-bench verify reports/plant-longest6

        plant-bench verify submitted --sample 20 --json verdict.json

        plant-bench verify submitted --agent their_agent.py:Agent --isolate --all
    """
    from plant_bench.api.execution import isolation_for
    from plant_bench.api.verify import VerifyRequest

    if isolate and agent is None:
        message = "--isolate requires --agent: it isolates the planner named there."
        raise InputError(message)
    if all_episodes and sample is not None:
        message = "--all and --sample exclude each other: leave out one of them."
        raise InputError(message)
    isolation = isolation_for(
        agent or "",
        isolate=isolate,
        limits={"tick": tick_limit, "start_up": start_up_limit, "memory": memory_limit},
    )
    request = VerifyRequest(
        run,
        "100%" if all_episodes else sample or "10%",
        seed,
        workers,
        agent,
        controls=controls,
        isolation=isolation,
    )
    with exit_on_ctrl_c():
        verification = _verify(request, suite=suite, routes=routes, repetitions=repetitions)
        if json is not None:
            write_whole_text(json, verification.to_json())
    raise typer.Exit(0 if verification.confirmed else 1)


def _verify(
    request: "VerifyRequest", *, suite: str | None, routes: str | None, repetitions: int | None
) -> "Verification":
    """Verify a run and print the findings step by step."""
    from rich.progress import TaskProgressColumn

    from plant_bench.api import verify
    from plant_bench.reports.verification_report import print_submission, print_verification

    run = verify.read_run(request, suite=suite, routes=routes, repetitions=repetitions)
    print_submission(run)
    driver = verify.choose_driver(request, run.provenance)
    if driver.note:
        typer.echo(driver.note)
    sample = verify.choose_sample(request, run)
    with progress_bars(18, TaskProgressColumn()) as bars:
        task = bars.add_task("episodes", total=1.0)
        verification = verify.simulate_sample(
            request, run, driver, sample, lambda share: bars.update(task, completed=share)
        )
    print_verification(verification)
    return verification
