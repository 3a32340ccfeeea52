"""The measures of one episode, as stored in its record; `scoring.episode_metrics` defines them.

They are computed from the scenes alone at the end of the episode, so that rescoring a recording
gives the same numbers.
"""

from collections.abc import Mapping
from typing import Annotated

from pydantic import ConfigDict, Field, RootModel, field_validator

from plant_bench.scoring.episode_metrics import EPISODE_METRICS
from plant_bench.scoring.trajectory import Trajectory

DIGITS = 4  # decimals of a measure in a record
LARGEST_COUNT = 2**53  # integers up to this are exact as a float

Value = Annotated[int, Field(ge=-LARGEST_COUNT, le=LARGEST_COUNT)] | float | None
Number = int | float


class Measures(RootModel[Mapping[str, Value]]):
    """Measures of one episode by name, in the order of `EPISODE_METRICS`.

    A measure is None if there was nothing to measure, or if the record is older than the metric;
    in the latter case, `name in measures` is False.
    """

    model_config = ConfigDict(frozen=True, allow_inf_nan=False)

    @field_validator("root")
    @classmethod
    def _known_and_typed(cls, values: Mapping[str, Value]) -> Mapping[str, Value]:
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
        """Return those that a record of this format version has."""
        return Measures(
            {
                name: item
                for name, item in self.root.items()
                if EPISODE_METRICS[name].since <= version
            }
        )


def measure(trajectory: Trajectory) -> Measures:
    """Return the measures of an episode of at least one tick."""
    values = {name: metric.compute(trajectory) for name, metric in EPISODE_METRICS.items()}
    return Measures(
        {name: value if value is None else round(value, DIGITS) for name, value in values.items()}
    )


def _typed(name: str, value: Number | None) -> Number | None:
    """Return a count as an integer, any other measure as a float.

    Raises:
        ValueError: A count is not a whole number.
    """
    if value is None:
        return None
    if not EPISODE_METRICS[name].is_count:
        return float(value)
    if value != int(value):
        message = f"{name} is {value}: expected a whole number"
        raise ValueError(message)
    return int(value)
