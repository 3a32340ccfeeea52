"""Fixtures for episodes that several modules drive."""

from collections.abc import Callable

import pytest

from plant_bench.world.route import Route
from tests.shortened import first_metres


@pytest.fixture(scope="session")
def beginning() -> Callable[[int], Route]:
    """The first metres of a route, under another name."""

    def first(metres: int) -> Route:
        return first_metres(metres, f"town03-1-{metres}")

    return first
