"""The choice of episodes, and the messages if there are none."""

from pathlib import Path

import pytest

from plant_bench.errors import InputError
from plant_bench.reports.episode_selection import episodes_of
from plant_bench.runner.run.folder import RunFolder
from tests.unit.reports.why.moments_by_hand import record


@pytest.fixture
def folder(tmp_path: Path) -> RunFolder:
    run = RunFolder(tmp_path)
    run.create()
    for route, repetition in (("town01-0", 1), ("town01-0", 0), ("town02-3", 0)):
        result = record(route=route, repetition=repetition)
        run.save(f"{route}_r{repetition}_c0ffee", result, None)
    return run


def test_episodes_of_a_route_are_sorted_by_repetition(folder: RunFolder):
    found = episodes_of(folder, "town01-0", None)

    assert [(name, item.repetition) for name, item in found] == [
        ("town01-0_r0_c0ffee", 0), ("town01-0_r1_c0ffee", 1),
    ]  # fmt: skip
    assert [item.repetition for _, item in episodes_of(folder, "0", 1)] == [1]


@pytest.mark.parametrize(
    ("route", "repetition", "words"),
    [
        ("twon02-3", None, "Did you mean town02-3?"),
        ("town02-3", 4, "no episode of town02-3, repetition 4: its repetitions are 0"),
        ("0,1", None, "selects 2 routes: expected one"),
    ],
)
def test_missing_route_is_named(folder: RunFolder, route: str, repetition: int, words: str):
    with pytest.raises(InputError, match=words.replace("?", r"\?")):
        episodes_of(folder, route, repetition)
