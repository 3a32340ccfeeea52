"""What `plant-bench verify` does: checks, draws a sample, simulates it again, tells."""

import re
import secrets
from dataclasses import dataclass
from pathlib import Path

import typer
from rich.progress import TaskProgressColumn

from plant_bench.agents.loading.checksum import agent_checksum
from plant_bench.agents.loading.spec import AGENTS
from plant_bench.cli.bars import progress_bars
from plant_bench.errors import InputError
from plant_bench.reports.verification import Verification, print_submission, print_verification
from plant_bench.runner.review.submission import read_submission
from plant_bench.runner.review.verification import AGENT, CONTROLS, sample_of, verify_episodes
from plant_bench.runner.run.provenance import Provenance
from plant_bench.runner.workers.isolation import Isolation, isolated
from plant_bench.whole_files import write_whole_text

_SEEDS = 2**31


@dataclass(frozen=True)
class VerifyRequest:
    """What is asked.

    Attributes:
        run: The run's folder.
        sample: A share as in "10%", or a number.
        seed: Of the sample; None for a new one.
        workers: Processes.
        agent: Who drives, None for the run's own if it is one of ours.
        controls: Whether the recorded controls are executed instead.
        isolation: Keeps the agent that is named in a process of its own.
    """

    run: Path
    sample: str
    seed: int | None
    workers: int
    agent: str | None
    controls: bool
    isolation: Isolation | None = None

    def size(self, records: int) -> int:
        """Return how many of so many episodes are wanted, one at least.

        Raises:
            InputError: The sample is no number and no share.
        """
        found = re.fullmatch(r"(\d{1,9}(?:\.\d{1,9})?)(%?)", self.sample.strip())
        if found is None or (not found[2] and "." in found[1]):
            message = f"--sample {self.sample}: a share such as 10% or a number is wanted."
            raise InputError(message)
        wanted = round(records * float(found[1]) / 100.0) if found[2] else int(found[1])
        return min(max(wanted, 1), records)


def verify(
    request: VerifyRequest,
    *,
    suite: str | None,
    routes: str | None,
    repetitions: int | None,
    out: Path | None,
) -> bool:
    """Verify a run and say what was found; return whether it is confirmed.

    Args:
        request: What is asked.
        suite: As `read_submission`.
        routes: As `read_submission`, its `selection`.
        repetitions: As `read_submission`.
        out: A JSON file to write.

    Raises:
        InputError: It cannot be checked.
        SimulationError: Worker processes do not start.
    """
    request.size(1)  # a mistyped sample is told before anything is read
    run = read_submission(request.run, suite=suite, selection=routes, repetitions=repetitions)
    print_submission(run)
    seed = secrets.randbelow(_SEEDS) if request.seed is None else request.seed
    with isolated(request.isolation):  # its checksum is asked here
        agent = _driver(request, run.provenance)
    checked = []
    if run.records:
        names = sample_of(run.records, request.size(len(run.records)), seed)
        with progress_bars(18, TaskProgressColumn()) as bars:
            task = bars.add_task(f"{len(names)} episodes", total=1.0)
            checked = verify_episodes(
                run,
                names,
                agent=agent,
                workers=request.workers,
                on_share=lambda share: bars.update(task, completed=share),
                isolation=request.isolation,
            )
    found = Verification(run, checked, CONTROLS if agent is None else AGENT, seed)
    print_verification(found)
    if out is not None:
        write_whole_text(out, found.to_json())
    return found.confirmed


def _driver(request: VerifyRequest, told: Provenance) -> str | None:
    """Return who drives again, None for the recorded controls.

    Raises:
        InputError: The agent that was named is another one than the run's.
    """
    if request.controls and request.agent is not None:
        message = "--controls and --agent exclude each other: who is to drive?"
        raise InputError(message)
    if request.controls:
        return None
    if request.agent is not None:
        if (here := agent_checksum(request.agent)) != told.agent_checksum:
            message = (
                f"'{request.agent}' is not the agent of this run (checksum {here[:12]}, the run's "
                f"is {told.agent_checksum[:12]}). Without --agent, or with --controls, the "
                "recorded controls are executed."
            )
            raise InputError(message)
        return request.agent
    if told.agent in AGENTS and agent_checksum(told.agent) == told.agent_checksum:
        return told.agent
    why = "is another version here" if told.agent in AGENTS else "is not plant-bench's own"
    typer.echo(
        f"The agent {why}: the recorded controls are executed. They show that the scores follow "
        "from the driving, not who drove (--agent does)."
    )
    return None
