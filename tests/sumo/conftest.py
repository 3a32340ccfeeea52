"""What tests of several modules drive."""

from collections.abc import Callable
from dataclasses import replace

import pytest

from plant_bench.world.route import Route, load_suite


@pytest.fixture(scope="session")
def beginning() -> Callable[[int], Route]:
    """The first metres of a route with a name of its own."""
    whole = next(route for route in load_suite("longest6") if route.id == "town03-1")

    def first(metres: int) -> Route:
        return replace(
            whole,
            id=f"town03-1-{metres}",
            points=whole.points[: metres + 1],
            elevations=whole.elevations[: metres + 1],
            speed_limits=whole.speed_limits[: metres + 1],
            passages=tuple(passage for passage in whole.passages if passage.exit < metres),
            hazards=tuple(hazard for hazard in whole.hazards if hazard.at < metres),
        )

    return first
