"""Traffic densities by name; importable without loading SUMO."""

from plant_bench.errors import InputError

DENSITIES = {"empty": 0.0, "light": 4.0, "medium": 8.0, "dense": 20.0}  # vehicles per lane-km


def density_of(name: str) -> float:
    """Return a density in vehicles per lane-km.

    Raises:
        InputError: There is no density of this name.
    """
    if name not in DENSITIES:
        message = f"There is no density '{name}'. Densities: {', '.join(DENSITIES)}."
        raise InputError(message)
    return DENSITIES[name]
