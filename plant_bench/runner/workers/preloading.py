"""Preloads the modules of a worker while its parent still prepares the run."""

from collections.abc import Callable
from functools import partial
from importlib import import_module


def loading(agent: str, *, isolate: bool) -> Callable[[], None]:
    """Return what a process that stands by does; making it loads nothing here.

    Args:
        agent: The planner that it will drive, as the user gave it.
        isolate: Whether the planner lives in a process of its own, so that workers never load it.
    """
    return partial(_load, "" if isolate else agent)


def _load(agent: str) -> None:
    """Load the loop of an episode, and the planner if it is one of plant-bench's own."""
    import plant_bench.runner.episode.loop
    import plant_bench.runner.run.episode_queue  # noqa: F401  both for the first task, which names them
    from plant_bench.agents.loading.planner_spec import AGENTS, PlannerSpec
    from plant_bench.agents.loading.registry import load_agent

    if agent in AGENTS:
        load_agent(agent)  # once, for all that its kind loads; an argument may name others' code
    elif agent.partition("@")[0] in AGENTS:
        import_module(PlannerSpec.parse(agent).module)
