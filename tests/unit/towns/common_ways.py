"""Overlap of routes with those of the benchmark."""

from plant_bench.towns.route_choice import distance_by_edge, overlap_share
from plant_bench.towns.training_routes import benchmark_routes
from plant_bench.world.route import Route


def common_share(route: Route) -> float:
    """Return the largest overlap share of a route with a benchmark route."""
    driven = distance_by_edge(route)
    others = (distance_by_edge(other) for other in benchmark_routes() if other.town == route.town)
    return max((overlap_share(driven, other) for other in others), default=0.0)
