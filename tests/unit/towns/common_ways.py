"""Overlap of routes with those of the benchmark."""

from plant_bench.towns.route_choice import driven_on, share
from plant_bench.towns.training_routes import benchmark_routes
from plant_bench.world.route import Route


def common_share(route: Route) -> float:
    """Return the greatest share of length that a route has in common with a benchmark route."""
    driven = driven_on(route)
    others = (driven_on(other) for other in benchmark_routes() if other.town == route.town)
    return max((share(driven, other) for other in others), default=0.0)
