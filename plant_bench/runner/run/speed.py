"""Speed of a run and decision times of its planner, aggregated from the timing files."""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from statistics import median

from pydantic import TypeAdapter

from plant_bench.runner.episode.timing import Timing
from plant_bench.runner.run.folder import RunFolder
from plant_bench.untrusted_files import read_text


@dataclass(frozen=True)
class Speed:
    """The speed of some episodes together.

    Attributes:
        episodes: Number of episodes.
        simulated_s: Simulated time, seconds.
        wall_s: Wall time summed over the workers, seconds.
        shares: Fractions of the wall time: simulation, planner, referee and rest.
        p50_ms: Time of one decision: mean of the episodes' medians, weighted by ticks.
        p95_ms: The same for the 95th percentiles.
        p99_ms: The same for the 99th percentiles.
        late_share: Fraction of decisions that took longer than a tick.
        inference_ms: IT, time of one forward pass: median of the episodes' medians.
        inference_tokens: Tokens of a forward pass: median of the episodes' medians.
        processors: Processors on which this was measured.
    """

    episodes: int
    simulated_s: float
    wall_s: float
    shares: dict[str, float]
    p50_ms: float
    p95_ms: float
    p99_ms: float
    late_share: float
    inference_ms: float
    inference_tokens: float
    processors: tuple[str, ...]


def read_timings(folder: RunFolder, names: Iterable[str]) -> list[Timing]:
    """Return the timings of the named episodes; those without a readable one are skipped."""
    found = []
    for name in names:
        path = folder.path / "timing" / f"{name}.json"
        try:
            found.append(Timing.model_validate_json(read_text(path)))
        except (OSError, ValueError):
            continue
    return found


def speed_of(timings: Sequence[Timing]) -> Speed:
    """Aggregate timings."""
    ticks = sum(timing.ticks for timing in timings)
    wall = math.fsum(timing.wall_s for timing in timings)

    def mean(name: str) -> float:
        whole = sum(getattr(timing, name) * timing.ticks for timing in timings)
        return whole / ticks if ticks else math.nan

    def middle(name: str) -> float:
        values = [value for timing in timings if (value := getattr(timing, name)) is not None]
        return median(values) if values else math.nan

    spent = {
        "simulation": math.fsum(timing.simulation_s + timing.privileged_s for timing in timings),
        "planner": math.fsum(timing.agent_s for timing in timings),
        "referee": math.fsum(timing.referee_s for timing in timings),
    }
    spent["rest"] = wall - sum(spent.values())
    return Speed(
        episodes=len(timings),
        simulated_s=math.fsum(timing.simulated_s for timing in timings),
        wall_s=wall,
        shares={name: seconds / wall if wall else math.nan for name, seconds in spent.items()},
        p50_ms=mean("latency_p50_ms"),
        p95_ms=mean("latency_p95_ms"),
        p99_ms=mean("latency_p99_ms"),
        late_share=mean("late_share"),
        inference_ms=middle("inference_ms"),
        inference_tokens=middle("inference_tokens"),
        processors=tuple(sorted({timing.processor for timing in timings} - {""})),
    )


def write_speed(folder: RunFolder, names: Iterable[str]) -> Speed:
    """Aggregate the timings of the named episodes and write `speed.json`.

    Raises:
        InputError: It cannot be written.
    """
    speed = speed_of(read_timings(folder, names))
    folder.write("speed.json", TypeAdapter(Speed).dump_json(speed, indent=1).decode() + "\n")
    return speed
