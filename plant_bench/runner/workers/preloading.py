"""Preloads modules in worker processes while their parent still prepares the run."""

from collections.abc import Callable
from functools import partial
from importlib import import_module


def preloader(agent: str, *, isolate: bool) -> Callable[[], None]:
    """Return a picklable function that preloads modules; this process imports nothing.

    Args:
        agent: The planner that the worker will drive, as the user named it.
        isolate: Whether the planner runs in a separate process, so that workers never load it.
    """
    return partial(_preload, "" if isolate else agent)


def _preload(agent: str) -> None:
    """Import the episode loop, and the planner if it is built in."""
    import plant_bench.runner.episode.loop
    import plant_bench.runner.run.episode_queue  # noqa: F401  the first task needs both
    from plant_bench.agents.loading.planner_spec import AGENTS, PlannerSpec
    from plant_bench.agents.loading.registry import load_agent

    if agent in AGENTS:
        load_agent(agent)  # also imports its libraries; with an argument, it could run user code
    elif agent.partition("@")[0] in AGENTS:
        import_module(PlannerSpec.parse(agent).module)
