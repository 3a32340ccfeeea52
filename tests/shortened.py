"""Short routes, for quick episodes."""

from dataclasses import replace

from plant_bench.world.route import Route, load_suite


def first_metres(metres: int, name: str) -> Route:
    """Return the first metres of a route, under another name."""
    whole = next(route for route in load_suite("longest6") if route.id == "town03-1")
    return replace(
        whole,
        id=name,
        points=whole.points[: metres + 1],
        elevations=whole.elevations[: metres + 1],
        speed_limits=whole.speed_limits[: metres + 1],
        passages=tuple(passage for passage in whole.passages if passage.exit < metres),
        hazards=tuple(hazard for hazard in whole.hazards if hazard.at < metres),
    )
