"""Undrivable routes are refused before anything runs."""

import json

import pytest

from plant_bench.errors import InputError
from plant_bench.runner.run.score_run import ScoreRequest, open_run
from plant_bench.world.route import load_suite


def broken(path, change):
    route = load_suite("longest6")[0].to_payload()
    change(route)
    path.write_text(json.dumps({"format": 1, "routes": [route]}))
    return str(path)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda route: route["edges"].append("nowhere"), "edges nowhere not in town01"),
        (lambda route: route["lanes"].append(["nowhere_0", 0.0, 1.0]), "lanes nowhere_0"),
        (lambda route: route["passages"][0].update(signal="nowhere"), "signals nowhere"),
        (lambda route: route.update(town="town99"), "There is no town 'town99'"),
        (lambda route: route.update(id="../x"), "ids in"),
        (lambda route: route["points"].pop(), "one value a point|Type-check error"),
        (lambda route: route["points"][5].pop(), "Invalid route"),
        (lambda route: route["hazards"].append({"kind": "meteor"}), "Invalid route"),
        (lambda route: route.update(speed_limits=[0.0] * len(route["points"])), "positive"),
    ],
    ids=["edge", "lane", "signal", "town", "id", "count", "shape", "hazard", "speed"],
)
def test_a_route_that_does_not_fit_its_town_is_refused(change, message, tmp_path):
    suite = broken(tmp_path / "routes.json", change)
    with pytest.raises(InputError, match=message):
        open_run(ScoreRequest("cruise", suite), tmp_path / "run")
    assert not (tmp_path / "run").exists()


def test_two_routes_with_one_name_are_refused(tmp_path):
    route = load_suite("longest6")[0].to_payload()
    path = tmp_path / "routes.json"
    path.write_text(json.dumps({"format": 1, "routes": [route, route]}))
    with pytest.raises(InputError, match="must be unique"):
        load_suite(str(path))
