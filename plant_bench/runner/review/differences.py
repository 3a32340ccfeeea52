"""Compares an episode's record with the record of its resimulation."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from plant_bench.errors import InputError
from plant_bench.scoring.results import EpisodeResult


@dataclass(frozen=True)
class Difference:
    """The first field in which a record and its resimulation differ; written as JSON.

    Attributes:
        field: Path of the field, for example "infractions[0].time".
        told: Value in the record.
        again: Value in the resimulation.
    """

    field: str
    told: str
    again: str


@dataclass(frozen=True)
class EpisodeCheck:
    """The result of resimulating one episode; written as JSON.

    Attributes:
        name: Name of the episode's files.
        town: Name of the town.
        difference: The first difference; None if both records have the same bytes.
    """

    name: str
    town: str
    difference: Difference | None


def first_difference(recorded: EpisodeResult, again: EpisodeResult) -> Difference | None:
    """Return the first field in which two records differ, in the format version of the first."""
    again = again.as_format(recorded.format)
    if recorded.to_json() == again.to_json():
        return None
    one, other = (_flat(item.model_dump(mode="json")) for item in (recorded, again))
    for field in {**other, **one}:
        if one.get(field) != other.get(field) or type(one.get(field)) is not type(other.get(field)):
            return Difference(field, _shown(one, field), _shown(other, field))
    message = "The records' JSON texts differ although all fields are equal."
    raise InputError(message)


def _flat(value: Any, name: str = "") -> dict[str, Any]:
    """Return the leaves of a nested value by their paths."""
    if isinstance(value, dict):
        parts = [(f"{name}.{key}" if name else str(key), item) for key, item in value.items()]
    elif isinstance(value, list):
        parts = [(f"{name}[{index}]", item) for index, item in enumerate(value)]
    else:
        return {name: value}
    return {path: leaf for part, item in parts for path, leaf in _flat(item, part).items()}


def _shown(fields: Mapping[str, Any], name: str) -> str:
    return str(fields[name]) if name in fields else "nothing"
