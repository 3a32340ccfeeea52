"""Towns are found in the package, beside a suite, and where PLANT_BENCH_TOWNS says."""

import pytest

from plant_bench.data_files import TOWNS_VARIABLE, bring_towns_of, networks_dir, town_dir
from plant_bench.errors import InputError


@pytest.fixture
def suite(tmp_path, monkeypatch):
    """A suite's folder, in `tmp_path` with the town `mine` beside it."""
    monkeypatch.setenv(TOWNS_VARIABLE, "")
    (tmp_path / "towns" / "mine").mkdir(parents=True)
    (tmp_path / "towns" / "mine" / "town.json").write_text("{}", encoding="utf-8")
    (tmp_path / "routes").mkdir()
    return tmp_path / "routes"


def test_a_town_beside_a_suite_is_found_once_the_suite_is_read(suite):
    with pytest.raises(InputError):
        town_dir("mine")

    bring_towns_of(suite)

    assert town_dir("mine") == suite.parent / "towns" / "mine"


def test_a_town_inside_a_suite_comes_before_one_beside_it(suite):
    inside = suite / "towns" / "mine"
    inside.mkdir(parents=True)
    (inside / "town.json").write_text("{}", encoding="utf-8")

    bring_towns_of(suite)

    assert town_dir("mine") == inside


def test_no_suite_replaces_a_town_of_the_benchmark(suite):
    other = suite.parent / "towns" / "town01"
    other.mkdir()
    (other / "town.json").write_text("{}", encoding="utf-8")

    bring_towns_of(suite)

    assert town_dir("town01") == networks_dir() / "town01"


def test_reading_a_suite_twice_lists_its_towns_once(suite, monkeypatch):
    bring_towns_of(suite)
    bring_towns_of(suite)

    import os

    assert os.environ[TOWNS_VARIABLE] == str(suite.parent / "towns")


@pytest.mark.parametrize("name", ["x" * 300, "地" * 100, "../town01", "a/b", ""])
def test_what_can_be_no_towns_name_is_refused(name):
    with pytest.raises(InputError, match="is no town's name") as error:
        town_dir(name)

    assert len(str(error.value)) < 200
