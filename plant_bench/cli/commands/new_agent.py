"""`plant-bench new-agent`."""

from pathlib import Path
from typing import Annotated

import typer

from plant_bench.api.planner_project import Kind, write_project


def new_agent(
    name: Annotated[str, typer.Argument(help="The package's name, as in my_planner.")],
    out: Annotated[Path, typer.Option(help="Where to make its folder.")] = Path(),
    kind: Annotated[Kind, typer.Option(help="Rules, or a network in torch.")] = Kind.RULES,
) -> None:
    """Write a small project with a planner that works, its test and its README.

    For instance:

        plant-bench new-agent my_planner

        plant-bench score --agent my_planner/my_planner/agent.py:MyPlanner --routes 0

    It can be scored as it lies there, or by its name after `pip install -e my_planner`.
    """
    project = write_project(name, out, kind)
    typer.echo(f"Wrote {project.folder}: {len(project.files)} files.")
    typer.echo(f"  plant-bench score --agent {project.spec} --routes 0 --repetitions 1")
    typer.echo(f"Or by its name: pip install -e {project.folder}, then --agent {name}.")
