"""`plant-bench agents`: lists the available planners."""

import typer

from plant_bench.errors import InputError


def list_agents() -> None:
    """List the built-in planners and those of installed packages, with their inputs.

    Your own planner needs no registration: use `plant-bench score --agent path/to/file.py:Class`
    or `--agent package.module:Class`. A planner of an installed package is available by name if
    the package declares the entry point `plant_bench.agents`, as projects of `plant-bench
    new-agent` do.
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
            description, inputs = describe_agent(name)
            details = f"inputs: {', '.join(sorted(inputs)) or 'the ego state only'}"
        except InputError as error:
            description, details = "(unusable)", str(error)
        typer.echo(f"{name:<{width}}  {description}\n{indent}  {details}{source}")
    for name in installed:
        if name in AGENTS:
            typer.echo(
                f"'{name}' of {installed[name].distribution} is hidden by the built-in planner of "
                f"that name: use --agent {installed[name].target}.",
                err=True,
            )
