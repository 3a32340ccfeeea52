"""Measures the wall time of an episode by part, and the latency of the planner's decisions."""

import time
from typing import Annotated, Any

import numpy as np
from pydantic import BaseModel, ConfigDict, Field

from plant_bench.inference_timing import listen_to_passes
from plant_bench.runner.run.provenance import processor_name
from plant_bench.world.scene import TICK

Amount = Annotated[float, Field(ge=0.0, le=1e12)]  # so that sums of them are finite


class Timing(BaseModel):
    """Measured times of an episode; no score depends on them.

    Attributes:
        wall_s: Wall time of the whole episode, seconds.
        start_up_s: Wall time until the first tick, seconds.
        simulation_s: Wall time in SUMO and the ego's model, seconds.
        privileged_s: Wall time for privileged facts, seconds.
        agent_s: Wall time in the planner, seconds.
        referee_s: Wall time in the referee, seconds.
        recording_s: Wall time for writing the recording, seconds.
        simulated_s: Simulated time, seconds.
        ticks: Number of ticks.
        latency_p50_ms: Median time of one decision, milliseconds.
        latency_p95_ms: 95th percentile of the same.
        latency_p99_ms: 99th percentile of the same.
        late_share: Fraction of decisions that took longer than a tick.
        inference_ms: Median time of one forward pass (IT), milliseconds; None if not reported.
        inference_tokens: Median number of tokens of a forward pass; None if not reported.
        processor: Name of the processor.
        log: Name of the file in `logs/` with the output of the worker; empty if unknown.
    """

    model_config = ConfigDict(frozen=True)

    wall_s: Amount
    start_up_s: Amount
    simulation_s: Amount
    privileged_s: Amount
    agent_s: Amount
    referee_s: Amount
    recording_s: Amount
    simulated_s: Amount
    ticks: int = Field(ge=0, lt=2**31)
    latency_p50_ms: Amount
    latency_p95_ms: Amount
    latency_p99_ms: Amount
    late_share: Amount
    inference_ms: Amount | None = None
    inference_tokens: Amount | None = None
    processor: str = ""
    log: str = ""


class Stopwatch:
    """Sums the wall time spent in each part of an episode; mutable."""

    def __init__(self) -> None:
        self.begin = self._last = time.perf_counter()
        self.spent: dict[str, float] = dict.fromkeys(
            ("start_up", "simulation", "privileged", "agent", "referee", "recording"), 0.0
        )
        self.decisions: list[float] = []
        self.passes = listen_to_passes()

    def lap(self, part: str) -> None:
        """Add the time since the last lap to a part."""
        now = time.perf_counter()
        duration = now - self._last
        self._last = now
        self.spent[part] += duration
        if part == "agent":
            self.decisions.append(duration)

    def timing(self, simulated: float, ticks: int) -> Timing:
        """Return the timing of an episode; `simulated` is its simulated time in seconds."""
        p50, p95, p99 = np.percentile(self.decisions or [0.0], (50, 95, 99)).tolist()
        late = sum(decision > TICK for decision in self.decisions)
        spent: dict[str, Any] = {f"{part}_s": spent for part, spent in self.spent.items()}
        return Timing(
            wall_s=time.perf_counter() - self.begin,
            **spent,
            simulated_s=simulated,
            ticks=ticks,
            latency_p50_ms=1000.0 * p50,
            latency_p95_ms=1000.0 * p95,
            latency_p99_ms=1000.0 * p99,
            late_share=late / max(len(self.decisions), 1),
            inference_ms=_median([1000.0 * item.seconds for item in self.passes]),
            inference_tokens=_median([float(item.tokens) for item in self.passes]),
            processor=processor_name(),
        )


def _median(values: list[float]) -> float | None:
    return float(np.median(values)) if values else None
