"""Verifying a run: check its records, draw a sample, simulate it again."""

import re
import secrets
from dataclasses import dataclass
from pathlib import Path

from plant_bench.agents.loading.checksum import agent_checksum
from plant_bench.agents.loading.planner_spec import AGENTS
from plant_bench.errors import InputError
from plant_bench.reports.verification_report import Verification
from plant_bench.runner.review.submission import Submission, read_submission
from plant_bench.runner.review.verification import (
    AGENT,
    CONTROLS,
    OnShare,
    sample_of,
    verify_episodes,
)
from plant_bench.runner.run.provenance import Provenance
from plant_bench.runner.workers.isolation import Isolation, loader_of

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


@dataclass(frozen=True)
class Driver:
    """Who drives again.

    Attributes:
        agent: The planner; None for the recorded controls.
        note: Why it is the controls, where nobody asked for them.
    """

    agent: str | None
    note: str = ""


def read_run(
    request: VerifyRequest, *, suite: str | None, routes: str | None, repetitions: int | None
) -> Submission:
    """Check all of a run that needs no simulator.

    Args:
        request: What is asked.
        suite: As `read_submission`.
        routes: As `read_submission`, its `selection`.
        repetitions: As `read_submission`.

    Raises:
        InputError: It cannot be checked.
    """
    request.size(1)  # a mistyped sample is told before anything is read
    return read_submission(request.run, suite=suite, selection=routes, repetitions=repetitions)


def choose_driver(request: VerifyRequest, told: Provenance) -> Driver:
    """Return who drives a run again.

    Raises:
        InputError: The agent that was named is another one than the run's.
    """
    if request.controls and request.agent is not None:
        message = "--controls and --agent exclude each other: who is to drive?"
        raise InputError(message)
    if request.controls:
        return Driver(None)
    if request.agent is not None:
        if (
            here := agent_checksum(request.agent, loader_of(request.isolation))
        ) != told.agent_checksum:
            message = (
                f"'{request.agent}' is not the agent of this run (checksum {here[:12]}, the run's "
                f"is {told.agent_checksum[:12]}). Without --agent, or with --controls, the "
                "recorded controls are executed."
            )
            raise InputError(message)
        return Driver(request.agent)
    if told.agent in AGENTS and agent_checksum(told.agent) == told.agent_checksum:
        return Driver(told.agent)
    why = "is another version here" if told.agent in AGENTS else "is not plant-bench's own"
    return Driver(
        None,
        f"The agent {why}: the recorded controls are executed. They show that the scores follow "
        "from the driving, not who drove (--agent does).",
    )


def choose_sample(request: VerifyRequest, run: Submission) -> tuple[list[str], int]:
    """Return the names of the episodes that are simulated again, and the seed that drew them."""
    seed = secrets.randbelow(_SEEDS) if request.seed is None else request.seed
    if not run.records:
        return [], seed
    return sample_of(run.records, request.size(len(run.records)), seed), seed


def simulate_sample(
    request: VerifyRequest,
    run: Submission,
    driver: Driver,
    sample: tuple[list[str], int],
    on_share: OnShare,
) -> Verification:
    """Simulate a sample of a run again, and return all that was found.

    Raises:
        InputError: An episode cannot be driven here.
        SimulationError: Worker processes do not start.
    """
    names, seed = sample
    checked = verify_episodes(
        run,
        names,
        agent=driver.agent,
        workers=request.workers,
        on_share=on_share,
        isolation=request.isolation,
    )
    return Verification(run, checked, CONTROLS if driver.agent is None else AGENT, seed)
