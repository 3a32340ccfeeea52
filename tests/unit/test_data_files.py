"""Towns are found in the package, beside a suite, and in PLANT_BENCH_TOWNS."""

import json
import os
from dataclasses import replace

import pytest

from plant_bench.data_files import TOWNS_VARIABLE, networks_dir, town_dir
from plant_bench.errors import InputError
from plant_bench.world.route import ROUTE_FORMAT, load_suite


@pytest.fixture
def suite(tmp_path, monkeypatch):
    """A suite's folder, in `tmp_path` with the town `mine` beside it."""
    monkeypatch.setenv(TOWNS_VARIABLE, "")
    (tmp_path / "towns" / "mine").mkdir(parents=True)
    (tmp_path / "towns" / "mine" / "town.json").write_text("{}", encoding="utf-8")
    payload = load_suite("longest6")[0].to_payload() | {"town": "mine"}
    (tmp_path / "routes").mkdir()
    text = json.dumps({"format": ROUTE_FORMAT, "routes": [payload]})
    (tmp_path / "routes" / "mine.json").write_text(text, encoding="utf-8")
    return tmp_path / "routes"


def test_town_beside_a_suite_is_found_only_by_its_routes(suite):
    before = dict(os.environ)
    (route,) = load_suite(str(suite))

    assert route.town_dir == suite.parent / "towns" / "mine"
    assert route.plan.town_dir == route.town_dir
    assert dict(os.environ) == before
    with pytest.raises(InputError):
        town_dir("mine")


def test_town_inside_a_suite_takes_precedence_over_one_beside_it(suite):
    inside = suite / "towns" / "mine"
    inside.mkdir(parents=True)
    (inside / "town.json").write_text("{}", encoding="utf-8")

    (route,) = load_suite(str(suite))

    assert route.town_dir == inside


def test_suite_cannot_replace_a_benchmark_town(suite):
    other = suite.parent / "towns" / "town01"
    other.mkdir()
    (other / "town.json").write_text("{}", encoding="utf-8")

    (route,) = load_suite(str(suite))

    assert replace(route, town="town01").town_dir == networks_dir() / "town01"


def test_route_checksum_ignores_the_location_of_the_town(suite):
    (route,) = load_suite(str(suite))

    assert route.town_folders
    assert replace(route, town_folders=()).checksum == route.checksum


def test_towns_of_the_environment_variable_are_found_by_name(suite, monkeypatch):
    monkeypatch.setenv(TOWNS_VARIABLE, str(suite.parent / "towns"))

    assert town_dir("mine") == suite.parent / "towns" / "mine"


@pytest.mark.parametrize("name", ["x" * 300, "地" * 100, "../town01", "a/b", ""])
def test_invalid_town_names_are_refused(name):
    with pytest.raises(InputError, match="is not a valid town name") as error:
        town_dir(name)

    assert len(str(error.value)) < 200
