"""plant-bench: a lightweight closed-loop benchmark for driving planners, on SUMO.

import plant_bench as pb

run = pb.score("plant", routes="0-5")
run.summary.driving_score
run.compare(pb.load_run("reports/expert-longest6"))

This module names the complete public API (docs/reference/python.md). The names are loaded on first
use, because every worker process imports this module. Other modules may change in any version.
"""

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from plant_bench.agent import Agent, Control, Input, Observation, Plan
    from plant_bench.agent_check import check_agent
    from plant_bench.api.collect import collect
    from plant_bench.api.driving import Step, drive
    from plant_bench.api.frames import frames
    from plant_bench.api.rfds import rfds
    from plant_bench.api.run import Run, load_run
    from plant_bench.api.score import score
    from plant_bench.api.train import train
    from plant_bench.errors import AgentError, InputError, PlantBenchError
    from plant_bench.world.route import Route, load_suite
    from plant_bench.world.scene import Scene

__version__ = "0.1.0"

__all__ = [
    "Agent",
    "AgentError",
    "Control",
    "Input",
    "InputError",
    "Observation",
    "Plan",
    "PlantBenchError",
    "Route",
    "Run",
    "Scene",
    "Step",
    "__version__",
    "check_agent",
    "collect",
    "drive",
    "frames",
    "load_run",
    "load_suite",
    "rfds",
    "score",
    "train",
]

_MODULES = {
    "Agent": "agent",
    "AgentError": "errors",
    "Control": "agent",
    "Input": "agent",
    "InputError": "errors",
    "Observation": "agent",
    "Plan": "agent",
    "PlantBenchError": "errors",
    "Route": "world.route",
    "Run": "api.run",
    "Scene": "world.scene",
    "Step": "api.driving",
    "check_agent": "agent_check",
    "collect": "api.collect",
    "drive": "api.driving",
    "frames": "api.frames",
    "load_run": "api.run",
    "load_suite": "world.route",
    "rfds": "api.rfds",
    "score": "api.score",
    "train": "api.train",
}


def __getattr__(name: str) -> object:
    """Load a public name when it is first used (PEP 562)."""
    if name not in _MODULES:
        message = f"module '{__name__}' has no attribute '{name}'"
        raise AttributeError(message)
    value = getattr(import_module(f"{__name__}.{_MODULES[name]}"), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    """Return the public names, including those that are not loaded yet."""
    return sorted({*globals(), *__all__})
