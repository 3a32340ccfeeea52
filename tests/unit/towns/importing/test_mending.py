"""Networks that netconvert makes of broken maps."""

from dataclasses import replace
from pathlib import Path
from subprocess import CompletedProcess

import numpy as np
import pytest

from plant_bench.errors import InputError
from plant_bench.towns.importing import map_conversion as converting
from plant_bench.towns.importing import network_repair, town_making
from plant_bench.towns.importing.map_conversion import Converted
from plant_bench.towns.importing.map_source import MapKind, MapSource
from plant_bench.towns.importing.network_repair import RepairedNetwork
from plant_bench.towns.importing.suite_making import RouteRequest
from plant_bench.world.town import load_town

SOURCE = MapSource("map.xml", MapKind.SUMO, b"<net/>", {})
UNESCAPED = '<net><tlLogic id="a" programID="<unknown>"/></net>'  # so netconvert writes it


@pytest.mark.parametrize("net", [UNESCAPED, "", "<net><edge><lane/></edge></net>"])
def test_unreadable_network_is_refused(monkeypatch, net):
    monkeypatch.setattr(network_repair, "convert_source", lambda *_, **__: Converted(net, ()))

    with pytest.raises(InputError, match="a network of map.xml that cannot be read"):
        network_repair.repair_network(SOURCE, "test", guess_signals=False, say=lambda _: None)


def test_map_that_exceeds_the_memory_limit_is_refused(monkeypatch):
    said = "terminate called: std::bad_alloc\n"
    monkeypatch.setattr(converting, "_run", lambda *_: CompletedProcess([], -6, "", said))

    with pytest.raises(InputError, match="needs more than 4 GB for map.xml: cut out"):
        converting.convert_source(SOURCE, guess_signals=False)


def test_town_that_fails_to_reload_is_refused(monkeypatch):
    town = load_town("town02")
    name, lane = next(iter(town.lanes.items()))
    high = replace(lane, points=lane.points + np.array([0.0, 0.0, 1e300]))
    town = replace(town, lanes={**town.lanes, name: high})
    made = RepairedNetwork("<net/>", town, [])
    for function, result in {
        "read_source": SOURCE,
        "repair_network": made,
        "sumo_errors": [],
        "ends_of_edges": {},
        "check": [],
        "make_routes": [],
    }.items():
        monkeypatch.setattr(town_making, function, lambda *_, result=result, **__: result)

    with pytest.raises(InputError, match="map.xml makes a town that cannot be used"):
        town_making.make_imported_town(
            Path("map.xml"), "test", RouteRequest(), guess_signals=False, say=lambda _: None
        )
