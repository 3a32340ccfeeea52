"""`plant-bench new-agent`: writes a starter project for a planner."""

from pathlib import Path
from typing import Annotated

import typer

from plant_bench.api.planner_project import Kind, write_project


def new_agent(
    name: Annotated[str, typer.Argument(help="Name of the package, e.g. my_planner.")],
    out: Annotated[Path, typer.Option(help="Parent folder of the project.")] = Path(),
    kind: Annotated[
        Kind, typer.Option(help="A rule-based planner, or one with a torch network.")
    ] = Kind.RULES,
) -> None:
    """Write a small project with a working planner, its test and its README.

    Example commands:

        plant-bench new-agent my_planner

        plant-bench score --agent my_planner/my_planner/agent.py:MyPlanner --routes 0

    The planner can be scored from its file, or by its name after `pip install -e my_planner`.
    """
    project = write_project(name, out, kind)
    typer.echo(f"Wrote {project.folder}: {len(project.files)} files. To score the planner:")
    typer.echo(f"  plant-bench score --agent {project.spec} --routes 0 --repetitions 1")
    typer.echo(f"To use it by name: pip install -e {project.folder}, then --agent {name}.")
