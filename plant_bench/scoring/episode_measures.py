"""The measures of one episode as its record holds them; `scoring.episode_metrics` is their table.

Derived from scenes alone, when the episode is over, so that rescoring comes to the same numbers.
"""

from collections.abc import Mapping
from typing import Annotated

from pydantic import ConfigDict, Field, RootModel, field_validator

from plant_bench.scoring.episode_metrics import EPISODE_METRICS
from plant_bench.scoring.trajectory import Trajectory

DIGITS = 4  # of a measure in a record
LARGEST_COUNT = 2**53  # what a float holds exactly

Value = Annotated[int, Field(ge=-LARGEST_COUNT, le=LARGEST_COUNT)] | float | None
Number = int | float


class Measures(RootModel[Mapping[str, Value]]):
    """Measures of one episode by name, in the order of `EPISODE_METRICS`.

    None where there was nothing to measure, and where the record is older than the metric; only
    the latter is not `in` it.
    """

    model_config = ConfigDict(frozen=True, allow_inf_nan=False)

    @field_validator("root")
    @classmethod
    def _of_the_table(cls, values: Mapping[str, Value]) -> Mapping[str, Value]:
        unknown = [name for name in values if name not in EPISODE_METRICS]
        if unknown:
            message = (
                f"unknown measures: {', '.join(unknown)}; expected {', '.join(EPISODE_METRICS)}"
            )
            raise ValueError(message)
        return {name: _typed(name, values[name]) for name in EPISODE_METRICS if name in values}

    def __getitem__(self, name: str) -> Number | None:
        """Return a measure.

        Raises:
            KeyError: There is no such metric.
        """
        if name not in EPISODE_METRICS:
            raise KeyError(name)
        return self.root.get(name)

    def __contains__(self, name: object) -> bool:
        return name in self.root

    def __hash__(self) -> int:
        return hash(tuple(self.root.items()))

    def up_to(self, version: int) -> "Measures":
        """Return what a record of that format holds of them."""
        return Measures(
            {
                name: item
                for name, item in self.root.items()
                if EPISODE_METRICS[name].since <= version
            }
        )


def measure(trajectory: Trajectory) -> Measures:
    """Measure an episode of at least one tick."""
    found = {name: metric.of(trajectory) for name, metric in EPISODE_METRICS.items()}
    return Measures(
        {name: value if value is None else round(value, DIGITS) for name, value in found.items()}
    )


def _typed(name: str, value: Number | None) -> Number | None:
    """Return a count as a whole number, any other measure as a float.

    Raises:
        ValueError: A count is not whole.
    """
    if value is None:
        return None
    if not EPISODE_METRICS[name].whole:
        return float(value)
    if value != int(value):
        message = f"{name} is {value}: expected a whole number"
        raise ValueError(message)
    return int(value)
