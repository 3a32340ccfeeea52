"""`plant-bench agents`."""

import typer


def list_agents() -> None:
    """List the planners that come with plant-bench, and what each is given.

    Your own planner needs no registration: give `--agent path/to/file.py:Class` or
    `--agent package.module:Class` to `plant-bench score`.
    """
    from plant_bench.agents.registry import AGENTS, describe_agent, load_agent

    width = max(len(name) for name in AGENTS)
    for name in AGENTS:
        about = describe_agent(name)
        given = ", ".join(sorted(load_agent(name).inputs)) or "nothing but its own state"
        typer.echo(f"{name:<{width}}  {about}\n{'':<{width}}  is given: {given}")
