"""Scripted episodes, selected by the route's id; workers import this module by name."""

import os
import time
from collections.abc import Callable
from pathlib import Path

from plant_bench.agent import Input
from plant_bench.agents.loading.registry import Loader
from plant_bench.errors import SimulationError
from plant_bench.runner.episode.jobs import Job
from plant_bench.runner.episode.outcome import Outcome
from plant_bench.runner.episode.timing import Timing
from plant_bench.scoring.infractions import Status
from plant_bench.scoring.results import EpisodeResult

TIMING = Timing(
    wall_s=2.0,
    start_up_s=0.5,
    simulation_s=0.5,
    privileged_s=0.0,
    agent_s=0.5,
    referee_s=0.25,
    recording_s=0.25,
    simulated_s=100.0,
    ticks=2000,
    latency_p50_ms=0.2,
    latency_p95_ms=0.4,
    latency_p99_ms=0.6,
    late_share=0.0,
)


def run_episode(
    job: Job, *, recording: Path | None, progress: Callable[[float], None], load: Loader
) -> Outcome:
    progress(0.5)
    with Path(os.environ["SCRIPT_LOG"]).open("a") as log:
        log.write(f"{job.route.id} r{job.repetition}\n")
    if job.route.id.startswith("dies"):
        os._exit(3)
    if job.route.id.startswith("fails"):
        raise SimulationError("the ego was lost")
    if job.route.id.startswith("slow"):
        time.sleep(60)
    if recording is not None:
        recording.write_bytes(b"ticks")
    completion = (job.seed % 1000) / 1000
    header = job.header(frozenset({Input.ROUTE}))
    result = EpisodeResult(
        **header.model_dump(),
        status=Status.TIMED_OUT,
        route_length=job.route.length,
        completion=completion,
        distance=completion * job.route.length,
        duration=100.0,
    )
    return Outcome(result, TIMING)
