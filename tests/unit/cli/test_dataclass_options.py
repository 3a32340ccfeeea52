"""Options of commands are fields of dataclasses: names, types, ranges, defaults and help."""

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal

import pytest

from plant_bench.agents.plant.training_options import PlanTOptions
from plant_bench.cli.dataclass_options import REQUIRED, build_dataclass, option_fields
from plant_bench.errors import InputError
from plant_bench.training.training_run import TrainingRun


@dataclass(frozen=True)
class Inner:
    """Inner.

    Attributes:
        deep: How deep,
            in metres.
        bits: Of a weight.
    """

    deep: float = field(default=1.0, metadata={"min": 0.0, "option": "depth"})
    bits: Literal[8, 32] = 8


@dataclass(frozen=True)
class Outer:
    """Outer.

    Attributes:
        data: Folders.
        inner: More.
        pair: Two numbers.

    More words.
    """

    data: tuple[Path, ...]
    inner: Inner = field(default_factory=lambda: Inner(deep=2.0))
    pair: tuple[float, float] = (0.9, 0.95)
    hidden: dict[str, int] = field(default_factory=dict, metadata={"option": None})


def test_dataclass_fields_become_options() -> None:
    found = {item.name: item for item in option_fields(Outer)}
    assert list(found) == ["data", "depth", "bits", "pair"]
    assert found["data"].default is REQUIRED
    assert found["depth"].default == 2.0  # of the outer one's inner one
    assert found["depth"].help == "How deep, in metres."
    assert found["pair"].help == "Two numbers."
    assert (found["depth"].low, found["depth"].high) == (0.0, None)
    assert found["bits"].value("32") == 32
    assert found["data"].value([Path("a")]) == (Path("a"),)


def test_option_values_are_converted_to_the_field_types() -> None:
    made = build_dataclass(Outer, {("data",): (Path("a"),), ("inner", "bits"): 32})
    assert made == Outer((Path("a"),), Inner(2.0, 32))
    again = build_dataclass(Outer, {("inner", "deep"): 3.0}, made)
    assert again == Outer((Path("a"),), Inner(3.0, 32))


def test_unsupported_field_type_raises_input_error() -> None:
    @dataclass(frozen=True)
    class Odd:
        table: Any = None

    @dataclass(frozen=True)
    class Twice:
        depth: int = 1
        inner: Inner = field(default_factory=Inner)

    with pytest.raises(InputError, match=r"Odd.table has type .*: expected a number"):
        option_fields(Odd)
    with pytest.raises(InputError, match="Duplicate options: depth"):
        option_fields(Twice)


def test_every_plant_option_has_a_help_text_and_a_stable_name() -> None:
    found = option_fields(
        TrainingRun, inside={"options": PlanTOptions}, without=frozenset({"learner"})
    )
    assert all(item.help for item in found)
    names = {item.name for item in found}
    assert names >= {
        "data", "out", "share", "size", "epochs", "drop_after", "batch", "rate", "auxiliary",
        "overshoot_weight", "seed", "stationary_fraction", "held_out", "reach", "horizon",
        "segments", "vulnerable", "stop_line", "conflicts", "motion", "view", "rear", "speeds",
        "speed_input", "speed_dropout", "limit_input", "targets", "start", "full_precision",
        "validate_every", "patience", "validate_suite", "validate_routes", "hazards", "onnx",
        "weights_bits", "accelerator", "devices", "threads", "workers", "work", "overwrite",
    }  # fmt: skip
