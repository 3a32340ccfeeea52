"""Short routes, for quick episodes."""

from dataclasses import replace

from plant_bench.world.route import Route
from tests.builders import suite_route


def first_metres(metres: int, name: str) -> Route:
    """Return the first metres of a route, under another name."""
    whole = suite_route("town03-1")
    return replace(
        whole,
        id=name,
        points=whole.points[: metres + 1],
        elevations=whole.elevations[: metres + 1],
        speed_limits=whole.speed_limits[: metres + 1],
        passages=tuple(passage for passage in whole.passages if passage.exit < metres),
        hazards=tuple(hazard for hazard in whole.hazards if hazard.at < metres),
    )
