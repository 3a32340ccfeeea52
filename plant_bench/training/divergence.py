"""The errors of a training whose loss is not finite."""

from plant_bench.errors import PlantBenchError


class TrainingError(PlantBenchError):
    """Raised when a training cannot go on, although its input is valid."""


class DivergedError(TrainingError):
    """Raised when a loss or its gradient is not finite; the weights are those before that step."""
