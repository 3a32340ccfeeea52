"""Imported maps keep what can be driven, and netconvert's faults are worked around."""

import math
from pathlib import Path
from subprocess import CompletedProcess

import numpy as np
import pytest

from plant_bench.errors import InputError
from plant_bench.towns.drivable import PathDrive
from plant_bench.towns.importing import map_conversion, network_repair
from plant_bench.towns.importing.carla_routes import read_carla_routes
from plant_bench.towns.importing.map_conversion import convert_source
from plant_bench.towns.importing.map_source import MapKind, MapSource, read_source
from plant_bench.towns.importing.net_edits import net_offset
from plant_bench.towns.importing.network_repair import (
    BEND_SPREADS,
    RepairedNetwork,
    repair_network,
)
from plant_bench.towns.importing.route_import import TownFound, match_routes
from tests.unit.towns.importing.map_files import osm_grid, ring, sumo_grid, touching_junctions


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


def test_large_grid_keeps_all_streets_but_its_dead_ends(tmp_path):
    network = repaired(tmp_path, "grid.osm", osm_grid(7, stubs=True))
    assert network.town.lane_km == pytest.approx(32.2, rel=0.03)  # 84 streets, two lanes each way
    lost = outcome(network)
    assert lost["dead ends"] == pytest.approx(28 * 4 * 47.7, rel=0.03)
    assert sum(lost.values()) == lost["dead ends"]


@pytest.mark.parametrize(("size", "step", "km"), [(3, 150.0, 3.244), (2, 200.0, 1.475)])
def test_sumo_network_without_dead_ends_is_kept_whole(tmp_path, size, step, km):
    network = repaired(tmp_path, "grid.net.xml", sumo_grid(tmp_path, size, step))
    assert len(network.town.edges) == 4 * size * (size - 1)
    assert network.town.lane_km == pytest.approx(km, abs=0.03)
    assert not any(outcome(network).values())


def scripted(monkeypatch, faults):
    """Let paths have given faults: for each round, (kind of fault, edges)."""
    rounds = iter(faults)

    def drive_all(town):
        edges = sorted(town.edges)
        bent, gaps = next(rounds, (set(), set()))
        lanes = [lane.id for edge in edges for lane in town.edges[edge] if edge in bent]
        found = [PathDrive(f"{lane}@0", 100.0, 0.0, 5.0) for lane in lanes]
        links = [link for link in town.links if town.lanes[link.source].edge in gaps]
        return found + [PathDrive(f"{k.source}->{k.target}", 100.0, 3.0, 0.0) for k in links]

    monkeypatch.setattr(network_repair, "drive_all", drive_all)


def test_each_road_is_smoothed_from_the_weakest_blur(tmp_path, monkeypatch):
    scripted(monkeypatch, [({"00-10"}, set()), ({"10-00", "11-01"}, set())])
    spreads = []

    def with_round_bends(net, by):
        spreads.append(by)
        return net

    monkeypatch.setattr(network_repair, "with_round_bends", with_round_bends)
    repaired(tmp_path, "grid.net.xml", sumo_grid(tmp_path, 2, 200.0))
    weak, stronger, _ = BEND_SPREADS
    assert spreads == [
        {"00-10": weak, "10-00": weak},
        {"00-10": stronger, "10-00": stronger, "01-11": weak, "11-01": weak},
    ]


def test_roads_behind_a_removed_path_are_reported_with_the_true_reason(tmp_path, monkeypatch):
    scripted(monkeypatch, [(set(), {"00-10"})])
    network = repaired(tmp_path, "grid.net.xml", sumo_grid(tmp_path, 3, 150.0))
    lost = outcome(network)
    assert lost["disconnected lanes"] == 0.0
    assert lost["roads cut off by a removed path"] == pytest.approx(279.0, abs=10.0)  # 2 edges
    assert "dead ends" not in lost
    assert not {"00-10", "01-00"} & set(network.town.edges)


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
    (tmp_path / "routes.xml").write_text(route_round_the_ring(), encoding="utf-8")
    for network in (plain, moved):
        folder = tmp_path / str(id(network)) / "made"
        folder.mkdir(parents=True)
        (folder / "town.json").write_text(network.town.to_json(), encoding="utf-8")
        (folder / "town.net.xml").write_text(network.net, encoding="utf-8")
        towns = {"Ring": TownFound("made", folder, must_copy=False)}
        routes = read_carla_routes(tmp_path / "routes.xml")
        (match,) = match_routes(routes, towns, 1.8, lambda _: None)
        assert match.reason == ""
        assert match.worst == pytest.approx(0.01, abs=0.01)


def route_round_the_ring():
    """Return CARLA's route of 12 points on the outer lane of the ring, anticlockwise."""
    points = [
        f'<waypoint x="{121.75 * math.cos(turn):.3f}" y="{-121.75 * math.sin(turn):.3f}" z="0" '
        f'yaw="{-math.degrees(turn) - 90.0:.3f}"/>'
        for turn in np.linspace(-1.2, 2.1, 12).tolist()
    ]
    return f'<routes><route id="0" town="Ring">{"".join(points)}</route></routes>'


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


def test_crash_of_netconvert_is_named_with_its_error_once(monkeypatch):
    error = "Error: Trying to add PositionVectors of different lengths\n"
    said = f"Warning: geoReference format '; ' currently not supported\n{error}{error}"
    monkeypatch.setattr(map_conversion, "_run", lambda *_: CompletedProcess([], -11, "", said))
    source = MapSource("map.xodr", MapKind.OPENDRIVE, b"<OpenDRIVE/>", {})
    with pytest.raises(InputError) as refused:
        convert_source(source, guess_signals=False)
    assert str(refused.value) == (
        "netconvert crashed on map.xodr: Trying to add PositionVectors of different lengths; "
        "geoReference format '; ' currently not supported. Repair the map in its editor, or in "
        "netedit."
    )


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
