"""Imported maps keep what can be driven, and netconvert's faults are worked around."""

from pathlib import Path

import numpy as np
import pytest

from plant_bench.errors import InputError
from plant_bench.towns.importing.map_conversion import convert_source
from plant_bench.towns.importing.map_source import read_source
from plant_bench.towns.importing.net_edits import net_offset
from plant_bench.towns.importing.network_repair import RepairedNetwork, repair_network
from tests.unit.towns.importing.map_files import osm_grid, ring, touching_junctions


def write(tmp_path: Path, name: str, text: str) -> Path:
    path = tmp_path / name
    path.write_text(text, encoding="utf-8")
    return path


def repaired(tmp_path: Path, name: str, text: str) -> RepairedNetwork:
    source = read_source(write(tmp_path, name, text))
    return repair_network(source, "made", guess_signals=False, say=lambda _: None)


def outcome(network: RepairedNetwork) -> dict[str, float]:
    return {finding.what: finding.lane_metres for finding in network.findings}


def test_grid_keeps_all_streets_but_its_dead_ends(tmp_path):
    network = repaired(tmp_path, "grid.osm", osm_grid(3, stubs=True))
    assert network.town.lane_km == pytest.approx(4.6, abs=0.1)  # 12 streets, two lanes each way
    assert outcome(network)["dead ends"] == pytest.approx(2290.0, abs=50.0)
    assert "connections too tight to drive" not in outcome(network)


def test_corners_that_are_too_tight_are_widened(tmp_path):
    network = repaired(tmp_path, "grid.osm", osm_grid(3, stubs=False))
    assert network.town.lane_km == pytest.approx(4.9, abs=0.1)
    assert not [finding for finding in network.findings if finding.lane_metres]


def test_ring_road_keeps_both_directions(tmp_path):
    network = repaired(tmp_path, "ring.xodr", ring())
    assert network.town.lane_km == pytest.approx(1.508, abs=0.01)


def test_header_offset_does_not_move_the_map(tmp_path):
    header = '<offset x="1000" y="2000" z="0" hdg="0"/>'
    moved = repaired(tmp_path, "moved.xodr", ring(header=header))
    plain = repaired(tmp_path, "plain.xodr", ring())
    assert net_offset(moved.net) == net_offset(plain.net) == (0.0, 0.0)
    for name, lane in plain.town.lanes.items():
        np.testing.assert_allclose(moved.town.lanes[name].points, lane.points, atol=0.01)


def test_dangling_reference_is_ignored_and_reported(tmp_path):
    junction = (
        '<junction id="7" name=""><connection id="0" incomingRoad="99" connectingRoad="1" '
        'contactPoint="start"><laneLink from="-1" to="-1"/></connection></junction>'
    )
    network = repaired(tmp_path, "dangling.xodr", ring(junctions=junction))
    assert network.town.lane_km == pytest.approx(1.508, abs=0.01)
    (finding,) = (item for item in network.findings if item.what.startswith("references"))
    assert "incoming road '99' is not known" in finding.done


def test_map_whose_internal_shapes_crash_netconvert_is_converted_without_them(tmp_path):
    source = read_source(write(tmp_path, "touching.xodr", touching_junctions()))
    converted = convert_source(source, guess_signals=False)
    assert [problem for problem, _ in converted.workarounds] == [
        "shapes of lanes inside junctions that crash netconvert"
    ]
    with pytest.raises(InputError, match="of 210 m of roads only 0 m are part of a loop"):
        repair_network(source, "made", guess_signals=False, say=lambda _: None)


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (
            b"\0\0\0\x0d\x0a\x09OSMHeader\x18\x07",
            "in PBF format: convert it to XML with `osmium cat",
        ),
        (
            b'<osm><relation id="7"><tag k="type" v="lanelet"/></relation></osm>',
            "is a Lanelet2 map, which cannot be imported: convert it to OpenDRIVE",
        ),
    ],
)
def test_map_of_another_kind_is_named_for_what_it_is(tmp_path, content, words):
    path = tmp_path / "map.osm"
    path.write_bytes(content)
    with pytest.raises(InputError, match=words):
        read_source(path)
