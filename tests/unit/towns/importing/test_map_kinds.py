"""The benchmark of map kinds, without driving: enough of each map is kept."""

import importlib.util
from pathlib import Path

import pytest

from plant_bench.towns.importing.map_source import read_source
from plant_bench.towns.importing.network_repair import repair_network

SCRIPT = Path(__file__).parents[4] / "benchmarks" / "map_kinds.py"


@pytest.fixture(scope="module")
def map_kinds():
    spec = importlib.util.spec_from_file_location("map_kinds", SCRIPT)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.mark.parametrize("kind", ["grid 3, stubs", "small ring, two-way", "short edges"])
def test_what_can_be_driven_is_kept(kind, map_kinds, tmp_path):
    path = map_kinds.KINDS[kind](tmp_path)
    before = map_kinds.reachable_in_map(path)
    assert sum(before.values()) > 300.0
    source = read_source(path)
    town = repair_network(source, "kind", guess_signals=False, say=lambda _: None).town
    assert map_kinds.share_kept(before, town) >= map_kinds.ENOUGH
