"""`plant-bench verify`."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from plant_bench.atomic_files import write_whole_text
from plant_bench.cli.options import (
    CORES,
    IsolateOption,
    MemoryLimitOption,
    StartUpLimitOption,
    TickLimitOption,
)
from plant_bench.cli.progress import ending_at_ctrl_c, progress_bars
from plant_bench.errors import InputError

if TYPE_CHECKING:
    from plant_bench.api.verify import VerifyRequest
    from plant_bench.reports.verification_report import Verification


def verify_run(
    run: Annotated[Path, typer.Argument(help="A folder that `plant-bench score` wrote, anywhere.")],
    sample: Annotated[
        str, typer.Option(help="Episodes to simulate again: a share as in 10%, or a number.")
    ] = "10%",
    all_of_them: Annotated[bool, typer.Option("--all", help="Simulate all again.")] = False,
    seed: Annotated[
        int | None, typer.Option(help="Draws the sample; a new one each time without it.", min=0)
    ] = None,
    workers: Annotated[int, typer.Option(help="Processes.", min=1)] = CORES,
    agent: Annotated[
        str | None,
        typer.Option(help="Who drives again, as for `score`; its code is run: trust it first."),
    ] = None,
    controls: Annotated[
        bool, typer.Option("--controls", help="Execute the recorded controls instead of the agent.")
    ] = False,
    suite: Annotated[
        str | None, typer.Option(help="The routes you trust, where the run's are its own.")
    ] = None,
    routes: Annotated[
        str | None, typer.Option(help="Which routes it should have driven; all without it.")
    ] = None,
    repetitions: Annotated[
        int | None, typer.Option(help="And how often; as the run says without it.", min=1)
    ] = None,
    json: Annotated[Path | None, typer.Option(help="Write what was found for machines.")] = None,
    isolate: IsolateOption = False,
    tick_limit: TickLimitOption = None,
    start_up_limit: StartUpLimitOption = None,
    memory_limit: MemoryLimitOption = None,
) -> None:
    """Confirm a run's scores: simulate a sample of its episodes again, and check all the rest.

    Records, names, checksums and the summary are checked for all episodes; a sample, over all
    towns, is simulated again: by the agent where it is one of plant-bench's own of the same
    checksum or is named with --agent, else by the recorded controls. Nothing in RUN is executed
    or written to. An agent's code is run only if it is plant-bench's or you name it. Exit code 0:
    confirmed, 1: something differs, 2: it cannot be checked.

    For instance:

        plant-bench verify reports/plant-longest6

        plant-bench verify submitted --sample 20 --json verdict.json

        plant-bench verify submitted --agent their_agent.py:Agent --isolate --all
    """
    from plant_bench.api.execution import isolation_for
    from plant_bench.api.verify import VerifyRequest

    if isolate and agent is None:
        message = "--isolate keeps the planner apart that --agent names: give --agent, too."
        raise InputError(message)
    isolation = isolation_for(
        agent or "",
        isolate=isolate,
        limits={"tick": tick_limit, "start_up": start_up_limit, "memory": memory_limit},
    )
    request = VerifyRequest(
        run,
        "100%" if all_of_them else sample,
        seed,
        workers,
        agent,
        controls=controls,
        isolation=isolation,
    )
    with ending_at_ctrl_c():
        found = _verify(request, suite=suite, routes=routes, repetitions=repetitions)
        if json is not None:
            write_whole_text(json, found.to_json())
    raise typer.Exit(0 if found.confirmed else 1)


def _verify(
    request: "VerifyRequest", *, suite: str | None, routes: str | None, repetitions: int | None
) -> "Verification":
    """Verify a run, and print what is found as it is found."""
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
        task = bars.add_task(f"{len(sample[0])} episodes", total=1.0)
        found = verify.simulate_sample(
            request, run, driver, sample, lambda share: bars.update(task, completed=share)
        )
    print_verification(found)
    return found
