"""Benchmark: steps per second of the Gymnasium environment, in one process and in two.

    python benchmarks/environment.py [--steps 1000]

A step is 0.1 s in dense traffic. The ego is stationary, so no episode ends. The cost of a reset is
printed separately: it simulates 15 s of traffic, which is worth some hundred steps. `ms` is
processor time per step, which depends least on other load; `x real` is simulated over wall time.
"""

import argparse
import resource
import time

import gymnasium
import numpy as np

import plant_bench.gym  # noqa: F401 - registers the environment
from plant_bench.features.raster import ROACH
from plant_bench.gym.encoders import Encoder, RasterEncoder
from plant_bench.world.scene import TICK

FRAME_SKIP = 2
STATIONARY_PLAN = np.zeros((4, 2), np.float32)  # a plan
RESETS = 10
WARM_UP = 20  # steps
_ENDED = resource.RUSAGE_CHILDREN


def cost_of_a_step(observation: str | Encoder, processes: int, steps: int) -> tuple[float, float]:
    """Return wall time and processor time per step, seconds, over all processes."""
    spent, busy = zip(*(_drive(observation, processes, count) for count in (0, steps)), strict=True)
    done = processes * steps
    return (spent[1] - spent[0]) / done, (busy[1] - busy[0]) / done


def _drive(observation: str | Encoder, processes: int, steps: int) -> tuple[float, float]:
    """Return the wall time and processor time of environments from start to end, seconds."""
    begin, busy = time.perf_counter(), _processor_time()
    envs = gymnasium.make_vec(
        "PlantBench-v0",
        num_envs=processes,
        vectorization_mode="sync" if processes == 1 else "async",
        observation=observation,
        action="plan",
        frame_skip=FRAME_SKIP,
        disable_env_checker=True,
    )
    actions = np.repeat(STATIONARY_PLAN[None], processes, axis=0)
    envs.reset(seed=1)
    for _ in range(WARM_UP + steps):
        envs.step(actions)
    envs.close()
    return time.perf_counter() - begin, _processor_time() - busy


def cost_of_a_reset() -> float:
    """Return the processor time of a reset, seconds."""
    env = gymnasium.make("PlantBench-v0", town="town03")
    env.reset(seed=1)
    busy = _processor_time()
    for _ in range(RESETS):
        env.reset()
    spent = _processor_time() - busy
    env.close()
    return spent / RESETS


def _processor_time() -> float:
    """Return the processor time of this process and its ended children, seconds."""
    own, ended = (resource.getrusage(who) for who in (resource.RUSAGE_SELF, _ENDED))
    return own.ru_utime + own.ru_stime + ended.ru_utime + ended.ru_stime


def main() -> None:
    """Print a row for each observation."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--steps", type=int, default=1000, help="steps of each process")
    steps = parser.parse_args().steps
    print(f"a reset: {1e3 * cost_of_a_reset():.0f} ms of processor time")
    kinds = {"tokens": "tokens", "objects": "objects", "raster": "raster"}
    print("observation      processes   steps/s   x real     ms")
    for name, kind in {**kinds, "raster, Roach's": RasterEncoder(ROACH)}.items():
        for processes in (1, 2):
            wall, busy = cost_of_a_step(kind, processes, steps)
            real = FRAME_SKIP * TICK / wall
            print(f"{name:16} {processes:9} {1 / wall:9.0f} {real:8.1f} {1e3 * busy:6.2f}")


if __name__ == "__main__":
    main()
