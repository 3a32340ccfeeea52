"""`plant-bench agents`."""

import typer

from plant_bench.errors import InputError


def list_agents() -> None:
    """List the planners that come with plant-bench and those of installed packages.

    Your own planner needs no registration: give `--agent path/to/file.py:Class` or
    `--agent package.module:Class` to `plant-bench score`. A package that declares the entry point
    `plant_bench.agents`, as `plant-bench new-agent` writes it, is found by its name.
    """
    from plant_bench.agents.loading.installed import installed_planners
    from plant_bench.agents.loading.planner_spec import AGENTS
    from plant_bench.agents.loading.registry import describe_agent

    installed = installed_planners()
    width = max(len(name) for name in [*AGENTS, *installed])
    indent = " " * width
    for name in [*AGENTS, *(name for name in installed if name not in AGENTS)]:
        source = f"\n{indent}  from {installed[name].distribution}" if name not in AGENTS else ""
        try:
            about, inputs = describe_agent(name)
            told = f"is given: {', '.join(sorted(inputs)) or 'nothing but its own state'}"
        except InputError as error:
            about, told = "(cannot be used)", str(error)
        typer.echo(f"{name:<{width}}  {about}\n{indent}  {told}{source}")
    for name in installed:
        if name in AGENTS:
            typer.echo(
                f"'{name}' of {installed[name].distribution} is hidden by plant-bench's own "
                f"planner of that name: give --agent {installed[name].target}.",
                err=True,
            )
