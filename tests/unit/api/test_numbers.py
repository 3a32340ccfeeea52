"""The functions of the package refuse the numbers that the commands refuse."""

import math

import pytest

import plant_bench as pb
from plant_bench.api.numbers import MOST_REPETITIONS
from plant_bench.scoring import results


@pytest.mark.parametrize(
    ("name", "value", "expected"),
    [
        ("repetitions", 10_001, "a whole number from 1 to 10000, got 10001"),
        ("repetitions", 0, "a whole number from 1 to 10000, got 0"),
        ("seed", -1, "a whole number from 0 to 2147483647, got -1"),
        ("workers", 0, "a whole number from 1 to 10000, got 0"),
    ],
)
def test_numbers_of_a_run_are_checked_before_it_starts(
    name, value, expected, tmp_path, monkeypatch
) -> None:
    monkeypatch.chdir(tmp_path)
    for function in (pb.score, pb.rfds):
        with pytest.raises(pb.InputError) as error:
            function("plant", **{name: value})
        assert str(error.value) == f"{name}: expected {expected}."
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("frames", 0), ("frames", 10**30), ("units", math.inf), ("units", math.nan), ("units", 0.0),
        ("seed", 2**31), ("perturb", math.nan), ("perturb", 1.01), ("workers", -1),
    ],
)  # fmt: skip
def test_numbers_of_a_collection_are_checked_before_it_starts(name, value, tmp_path) -> None:
    with pytest.raises(pb.InputError, match=f"^{name}: expected a (whole )?number from "):
        pb.collect(tmp_path / "data", **{name: value})
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(("name", "value"), [("repetition", 10_000), ("seed", -1)])
def test_numbers_of_an_episode_are_checked(name, value) -> None:
    with pytest.raises(pb.InputError, match=f"^{name}: expected a whole number from 0 to "):
        pb.drive("cruise", 0, **{name: value})


def test_limit_of_repetitions_is_that_of_records() -> None:
    assert MOST_REPETITIONS == results.MOST_REPETITIONS
