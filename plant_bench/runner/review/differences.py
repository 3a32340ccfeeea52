"""Compares a record with the result of simulating its episode again."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from plant_bench.errors import InputError
from plant_bench.scoring.results import EpisodeResult


@dataclass(frozen=True)
class Difference:
    """The first field in which a record is not what simulating again gives.

    Attributes:
        field: For instance "infractions[0].time".
        told: By the record.
        again: Now.
    """

    field: str
    told: str
    again: str


@dataclass(frozen=True)
class Checked:
    """An episode that was simulated again.

    Attributes:
        name: Of its files.
        town: Where.
        difference: None where the record is equal, byte for byte.
    """

    name: str
    town: str
    difference: Difference | None


def first_difference(told: EpisodeResult, again: EpisodeResult) -> Difference | None:
    """Return the first field in which two records differ, in the order of the first's format."""
    again = again.as_format(told.format)
    if told.to_json() == again.to_json():
        return None
    one, other = (_flat(item.model_dump(mode="json")) for item in (told, again))
    for field in {**other, **one}:
        if one.get(field) != other.get(field) or type(one.get(field)) is not type(other.get(field)):
            return Difference(field, _shown(one, field), _shown(other, field))
    message = "Two records have different texts and equal fields."
    raise InputError(message)


def _flat(value: Any, name: str = "") -> dict[str, Any]:
    """Return the leaves of nested values by their paths."""
    if isinstance(value, dict):
        parts = [(f"{name}.{key}" if name else str(key), item) for key, item in value.items()]
    elif isinstance(value, list):
        parts = [(f"{name}[{place}]", item) for place, item in enumerate(value)]
    else:
        return {name: value}
    return {path: leaf for part, item in parts for path, leaf in _flat(item, part).items()}


def _shown(fields: Mapping[str, Any], name: str) -> str:
    return str(fields[name]) if name in fields else "nothing"
