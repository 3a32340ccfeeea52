"""The options of `plant-bench score` that keep a planner in a process of its own."""

from typing import TYPE_CHECKING, Annotated

import typer

from plant_bench.errors import InputError

if TYPE_CHECKING:
    from plant_bench.runner.workers.isolation import Isolation

IsolateOption = Annotated[
    bool,
    typer.Option(
        "--isolate",
        help="Run the planner in a process of its own, so that one that hangs, leaks or crashes "
        "costs its own episode. It is no security sandbox.",
    ),
]
TickLimitOption = Annotated[
    float | None, typer.Option(help="Seconds for one decision, with --isolate; 5 without it.")
]
StartUpLimitOption = Annotated[
    float | None,
    typer.Option(help="Seconds to start, and for each reset, with --isolate; 120 without it."),
]
MemoryLimitOption = Annotated[
    float | None,
    typer.Option(help="GB that all of the planner's processes may hold; 4 without it."),
]


def isolation_for(
    agent: str,
    *,
    isolate: bool,
    tick: float | None,
    start_up: float | None,
    memory: float | None,
) -> "Isolation | None":
    """Return how the planner is to be kept apart; None where it is loaded by the workers.

    Raises:
        InputError: A limit is given without `--isolate`, or the planner does not start.
    """
    from plant_bench.agents.loading.spec import Kind, PlannerSpec

    given = {"tick": tick, "start_up": start_up, "memory": memory}
    limits = {name: value for name, value in given.items() if value is not None}
    if not isolate and PlannerSpec.parse(agent).kind is not Kind.COMMAND:
        if limits:
            option = f"--{next(iter(limits)).replace('_', '-')}-limit"
            message = f"{option} limits a planner in a process of its own: give --isolate, too."
            raise InputError(message)
        return None
    from plant_bench.agents.remote.process import Limits
    from plant_bench.runner.workers.isolation import isolation_of

    return isolation_of(agent, Limits(**limits))
