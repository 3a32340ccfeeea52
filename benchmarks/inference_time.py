"""Benchmark: PlanT's inference time (batch 1, one thread) by size, engine and token count.

    python benchmarks/inference_time.py [--passes 200] [--sizes mini small medium] [--busy]

The networks have the inputs of the shipped one and untrained weights, which do not affect the time.
The cases of a size take turns, pass by pass, so that other load on the machine affects all of them
equally. Medians are printed as Markdown. `--busy` measures the thread's processor time instead of
wall time, for machines under load; on an idle machine both are the same.
"""

import argparse
import tempfile
import time
from dataclasses import replace
from itertools import product
from pathlib import Path
from statistics import median

import numpy as np
import torch

from plant_bench.agents.plant.agent import DEFAULT_WEIGHTS, Predictor
from plant_bench.agents.plant.config import (
    GRAPH_FILE,
    SIZES,
    GraphBits,
    SizeName,
    load_config,
)
from plant_bench.agents.plant.network import PlanTNetwork
from plant_bench.agents.plant.network_files import load_network, save_network
from plant_bench.agents.plant.onnx_export import export_graph
from plant_bench.agents.plant.onnx_network import GraphPredictor
from plant_bench.agents.plant.predictor import TorchPredictor
from plant_bench.data_files import models_dir
from plant_bench.features.network_inputs import SceneInput
from plant_bench.features.tokens import NO_ROW, TokenKind, Tokens
from plant_bench.inference_timing import listen_to_passes
from plant_bench.runner.run.provenance import processor_name

TOKENS = (12, 16, 24)
TORCH = "torch"
GRAPHS: dict[str, GraphBits] = {"ONNX Runtime": 32, "ONNX Runtime, 8 bits": 8}
TARGETS: dict[SizeName, float] = {"mini": 2.0, "small": 5.0, "medium": 10.8}  # ms
SHIPPED = load_config(models_dir() / DEFAULT_WEIGHTS)
WARM_UP = 10  # passes before the measurement


def predictors_of(size: SizeName) -> dict[str, Predictor]:
    """Return an untrained network of a size in each engine."""
    torch.manual_seed(0)
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        save_network(PlanTNetwork(replace(SHIPPED, size=size)), folder)
        found: dict[str, Predictor] = {TORCH: TorchPredictor(load_network(folder))}
        for engine, bits in GRAPHS.items():
            export_graph(folder, bits)
            found[engine] = GraphPredictor(folder / GRAPH_FILE)
        return found


def scene_of(tokens: int) -> SceneInput:
    """Return a scene of vehicles and two route segments."""
    rng = np.random.default_rng(tokens)
    kinds = np.full(tokens, TokenKind.VEHICLE, np.uint8)
    kinds[-2:] = TokenKind.ROUTE
    shape = (tokens, SHIPPED.tokens.attributes)
    attributes = rng.normal(scale=5.0, size=shape).astype(np.float32)
    places = np.full(tokens, NO_ROW, np.int64)
    return SceneInput(Tokens(attributes, kinds, places), 0.0, (15.0, -3.0), 6.0, 13.0)


def medians(size: SizeName, passes: int, *, busy: bool) -> dict[tuple[str, int], float]:
    """Return the median milliseconds of each engine and number of tokens."""
    predictors = predictors_of(size)
    scenes = {tokens: scene_of(tokens) for tokens in TOKENS}
    times: dict[tuple[str, int], list[float]] = {case: [] for case in product(predictors, TOKENS)}
    for turn in range(WARM_UP + passes):
        for (engine, tokens), found in times.items():
            passes_timed = listen_to_passes()
            begin = time.thread_time()
            predictors[engine].waypoints(scenes[tokens])
            spent = time.thread_time() - begin
            if turn >= WARM_UP:
                found.append(1000.0 * (spent if busy else passes_timed[0].seconds))
    return {case: median(found) for case, found in times.items()}


def main() -> None:
    """Print a row for each size and engine."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--passes", type=int, default=200, help="passes of each case")
    parser.add_argument("--sizes", nargs="+", choices=list(SIZES), default=list(SIZES))
    parser.add_argument("--busy", action="store_true", help="measure processor time")
    arguments = parser.parse_args()
    print(f"Median of {arguments.passes} passes in ms, one thread of {processor_name()}.\n")
    heads = [f"{tokens} tokens" for tokens in TOKENS]
    print(f"| size | engine | {' | '.join(heads)} | torch / engine | target |")
    print("|" + "---|" * (len(heads) + 4))
    for size in arguments.sizes:
        found = medians(size, arguments.passes, busy=arguments.busy)
        for engine in (TORCH, *GRAPHS):
            ratio = median(found[TORCH, tokens] / found[engine, tokens] for tokens in TOKENS)
            cells = " | ".join(f"{found[engine, tokens]:.2f}" for tokens in TOKENS)
            print(
                f"| {size} | {engine} | {cells} | {ratio:.2f} | {TARGETS[size]:.1f} |", flush=True
            )


if __name__ == "__main__":
    main()
