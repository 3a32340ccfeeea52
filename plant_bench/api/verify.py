"""Verifies a run: checks its records and simulates a random sample of episodes again."""

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
    """Arguments of a verification.

    Attributes:
        run: Folder of the run.
        sample: Size of the sample: a percentage as in "10%", or a number of episodes.
        seed: Seed of the sample; None for a random one.
        workers: Number of processes.
        agent: The planner that drives the sample; None for the run's own if it is built in.
        controls: Whether the recorded controls are executed instead of a planner.
        isolation: How `agent` is isolated; None if the workers load it themselves.
    """

    run: Path
    sample: str
    seed: int | None
    workers: int
    agent: str | None
    controls: bool
    isolation: Isolation | None = None

    def size(self, records: int) -> int:
        """Return the number of episodes in the sample, at least one.

        Args:
            records: Number of episodes in the run.

        Raises:
            InputError: `sample` is neither a number nor a percentage.
        """
        match = re.fullmatch(r"(\d{1,9}(?:\.\d{1,9})?)(%?)", self.sample.strip())
        if match is None or (not match[2] and "." in match[1]) or not float(match[1]):
            message = (
                f"--sample: expected a percentage such as 10% or a number of episodes from 1, got "
                f"{self.sample}."
            )
            raise InputError(message)
        size = round(records * float(match[1]) / 100.0) if match[2] else int(match[1])
        return min(max(size, 1), records)


@dataclass(frozen=True)
class Driver:
    """What drives the ego vehicle when episodes are simulated again.

    Attributes:
        agent: The planner; None for the recorded controls.
        note: Why the recorded controls are executed although they were not requested.
    """

    agent: str | None
    note: str = ""


def check_options(request: VerifyRequest) -> None:
    """Check the options of a verification that need no run.

    Raises:
        InputError: The sample is neither a number nor a percentage, or two options exclude each
            other.
    """
    request.size(1)
    if request.controls and request.agent is not None:
        message = "--controls and --agent exclude each other: leave out one of them."
        raise InputError(message)


def read_run(
    request: VerifyRequest, *, suite: str | None, routes: str | None, repetitions: int | None
) -> Submission:
    """Read a run and make all checks that need no simulator.

    Args:
        request: Arguments of the verification.
        suite: See `read_submission`.
        routes: `selection` of `read_submission`.
        repetitions: See `read_submission`.

    Raises:
        InputError: The run cannot be checked.
    """
    check_options(request)
    return read_submission(request.run, suite=suite, selection=routes, repetitions=repetitions)


def choose_driver(request: VerifyRequest, provenance: Provenance) -> Driver:
    """Return what drives the ego vehicle when episodes are simulated again.

    Raises:
        InputError: The requested planner is not the one of the run.
    """
    if request.controls:
        return Driver(None)
    if request.agent is not None:
        checksum = agent_checksum(request.agent, loader_of(request.isolation))
        if checksum != provenance.agent_checksum:
            message = (
                f"'{request.agent}' is not the agent of this run: expected checksum "
                f"{provenance.agent_checksum[:12]}, got {checksum[:12]}. Without --agent, or with "
                "--controls, the recorded controls are executed."
            )
            raise InputError(message)
        return Driver(request.agent)
    if provenance.agent in AGENTS and agent_checksum(provenance.agent) == provenance.agent_checksum:
        return Driver(provenance.agent)
    why = "has another version here" if provenance.agent in AGENTS else "is not built in"
    return Driver(
        None,
        f"The agent {why}, so the recorded controls are executed. They prove that the scores "
        "follow from the driving, not which planner drove; use --agent to check that, too.",
    )


def choose_sample(request: VerifyRequest, run: Submission) -> tuple[list[str], int]:
    """Return the names of the sampled episodes and the seed of the sample."""
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
    """Score all recordings again, and simulate a sample; return the result of the verification.

    Raises:
        InputError: An episode cannot be driven on this machine.
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
    way = CONTROLS if driver.agent is None else AGENT
    return Verification(run, checked.simulated, way, seed, checked.rescored)
