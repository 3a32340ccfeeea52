"""Towns from small maps: what is repaired, what is reported, and that they can be driven."""

import json
import math
import os
import subprocess
from pathlib import Path

import numpy as np
import pytest
import sumo
from typer.testing import CliRunner

from plant_bench.agent import Control
from plant_bench.cli import app
from plant_bench.data_files import TOWNS_VARIABLE, networks_dir
from plant_bench.errors import InputError
from plant_bench.sim.simulation import Simulation
from plant_bench.sim.sumo_library import libsumo
from plant_bench.sim.vehicle_types import CAR
from plant_bench.towns.importing import levels, suite_making
from plant_bench.towns.importing.carla_routes import read_carla_routes
from plant_bench.towns.importing.map_checks import check
from plant_bench.towns.importing.map_source import read_source
from plant_bench.towns.importing.net_edits import ends_of_edges
from plant_bench.towns.importing.network_repair import repair_network
from plant_bench.towns.importing.route_import import TownFound, match_routes
from plant_bench.towns.importing.suite_making import RouteRequest, make_routes
from plant_bench.towns.town_checks import find_unreachable
from plant_bench.world.route import Scenario, load_suite
from plant_bench.world.town import Town
from tests.unit.towns.importing.carla_files import as_carla

pytestmark = pytest.mark.sumo


@pytest.fixture(autouse=True)
def _fewer_drafts(monkeypatch):
    """Draft few routes: which ones are found is not tested here."""
    monkeypatch.setattr(suite_making, "DRAWS", 80)


PLACES = (
    "0,0 -80,0 -150,25 -190,80 -190,130 -160,175 -100,195 360,195 420,175 450,130 450,80 410,25"
)
OUTSIDE = f"{PLACES} 340,0 260,0"  # round the grid and across it
BACK = " ".join(reversed(OUTSIDE.split()))
TOWN02 = networks_dir() / "town02" / "town.net.xml"


def netconvert(folder, *options):
    program = Path(sumo.SUMO_HOME) / "bin" / "netconvert"
    environment = {**os.environ, "SUMO_HOME": sumo.SUMO_HOME}
    subprocess.run(
        [program, *options], cwd=folder, env=environment, check=True, capture_output=True
    )


def grid_net(folder, extra_nodes="", extra_edges="", *options):
    """A network of 3 x 3 junctions, two lanes each way, with additional nodes and edges."""
    places = [(i, j) for i in range(3) for j in range(3)]
    nodes = [f'<node id="n{i}{j}" x="{i * 130}" y="{j * 130}" type="priority"/>' for i, j in places]
    edges = []
    for i, j in places:
        for k, m in ((i + 1, j), (i, j + 1)):
            if (k, m) in places:
                edges += [(f"n{i}{j}", f"n{k}{m}"), (f"n{k}{m}", f"n{i}{j}")]
    lines = [f'<edge id="{a}{b}" from="{a}" to="{b}" numLanes="2" speed="13.9"/>' for a, b in edges]
    (folder / "n.xml").write_text(f"<nodes>{''.join(nodes)}{extra_nodes}</nodes>")
    (folder / "e.xml").write_text(f"<edges>{''.join(lines)}{extra_edges}</edges>")
    options = options or ("--no-warnings", "true")
    netconvert(folder, "-n", "n.xml", "-e", "e.xml", "-o", "map.net.xml", *options)
    return folder / "map.net.xml"


def mended(path):
    source = read_source(path)
    done = repair_network(source, "test", guess_signals=False, say=lambda _: None)
    findings = [*done.findings, *check(done.town, source, ends_of_edges(done.net))]
    return done.town, {(item.what, item.outcome): item for item in findings}


def test_unusable_parts_of_a_map_are_removed_and_reported(tmp_path):
    nodes = (
        '<node id="end" x="-90" y="0"/><node id="far" x="900" y="0"/><node id="off" x="999" y="0"/>'
    )
    edges = """<edge id="spur" from="n00" to="end" numLanes="1"/>
        <edge id="back" from="end" to="n00" numLanes="1"/>
        <edge id="island" from="far" to="off" numLanes="1"/>
        <edge id="rails" from="n00" to="n11" numLanes="1" allow="rail"/>
        <edge id="path" from="n11" to="n22" numLanes="1" allow="pedestrian bicycle"/>
        <edge id="thin" from="n01" to="n12" numLanes="1" width="1.6"/>"""

    town, found = mended(grid_net(tmp_path, nodes, edges))

    assert find_unreachable(town) == []
    gone = {"spur", "back", "island", "rails", "path", "thin"}
    assert not gone & set(town.edges)
    assert found["turnarounds", "repaired"].count > 8
    assert "spur" in found["dead ends", "repaired"].examples
    assert found["narrow lanes", "repaired"].examples == ("thin_0",)
    assert found["ways for pedestrians, bicycles or trains only", "repaired"].count == 2
    assert found["big junctions without signals", "reported"].examples[0].startswith("n11 ")


def test_road_crossing_without_a_junction_becomes_a_bridge(tmp_path):
    edges = f"""<edge id="over" from="n00" to="n20" numLanes="1" speed="13.9" shape="{OUTSIDE}"/>
        <edge id="back" from="n20" to="n00" numLanes="1" speed="13.9" shape="{BACK}"/>"""

    town, found = mended(grid_net(tmp_path, "", edges))

    assert set(found["roads that cross at the same height", "repaired"].examples) == {
        "over",
        "back",
    }
    assert ("roads that cross at the same height", "reported") not in found
    lane = town.edges["over"][0]
    assert lane.points[:, 2].max() > 5.0
    assert abs(lane.points[[0, -1], 2]).max() < 0.1
    grade = np.abs(np.diff(lane.points[:, 2])) / np.maximum(np.diff(lane.along), 0.1)
    assert grade.max() < 0.2


def test_crossings_too_short_for_a_bridge_are_reported(tmp_path, monkeypatch):
    monkeypatch.setattr(levels, "RAMP_SPACE", 120.0)
    edges = '<edge id="x" from="n00" to="n11" numLanes="1"/>'
    edges += '<edge id="y" from="n10" to="n01" numLanes="1"/>'

    _, found = mended(grid_net(tmp_path, "", edges))

    finding = found["roads that cross at the same height", "reported"]
    assert finding.examples == ("x and y",)
    assert ("roads that cross at the same height", "repaired") not in found


def test_slip_road_is_kept_and_drivable(tmp_path):
    nodes = '<node id="s" x="130" y="75"/><node id="t" x="185" y="130"/>'
    edges = """<edge id="slip" from="s" to="t" numLanes="1" speed="8"
        shape="130,75 136,92 146,108 163,122 185,130"/>"""
    grid_net(tmp_path, nodes, edges)
    text = (tmp_path / "e.xml").read_text()
    for one, middle, other in (("n10", "s", "n11"), ("n11", "t", "n21")):  # it leaves, it joins
        end = f'to="{other}" numLanes="2" speed="13.9"/>'
        halves = f'to="{middle}" numLanes="2" speed="13.9"/><edge id="{middle}{other}"'
        whole = f'<edge id="{one}{other}" from="{one}" {end}'
        assert whole in text
        text = text.replace(
            whole, f'<edge id="{one}{middle}" from="{one}" {halves} from="{middle}" {end}'
        )
    (tmp_path / "e.xml").write_text(text)
    netconvert(tmp_path, "-n", "n.xml", "-e", "e.xml", "-o", "map.net.xml")

    town, found = mended(tmp_path / "map.net.xml")

    assert find_unreachable(town) == []
    assert "slip" in town.edges
    ways = {(link.source, link.target) for link in town.links}
    assert any(source.startswith("n10s_") and to == "slip_0" for source, to in ways)
    assert any(source == "slip_0" and to.startswith("tn21_") for source, to in ways)
    assert "dead ends" not in {what for what, _ in found}


def test_traffic_lights_are_guessed_on_request(tmp_path):
    source = read_source(grid_net(tmp_path))

    plain = repair_network(source, "test", guess_signals=False, say=lambda _: None).town
    town = repair_network(source, "test", guess_signals=True, say=lambda _: None).town

    assert not plain.signals
    assert "n11" in town.signals


def test_overlapping_opposite_lanes_are_reported(tmp_path):
    edges = f"""<edge id="a" from="n00" to="n20" spreadType="center" shape="{OUTSIDE}"/>
        <edge id="b" from="n20" to="n00" spreadType="center" shape="{BACK}"/>"""

    _, found = mended(grid_net(tmp_path, "", edges))

    assert ("lanes of opposite directions that overlap", "reported") in found


def test_missing_junction_lanes_are_created(tmp_path):
    town, found = mended(grid_net(tmp_path, "", "", "--no-internal-links", "true"))

    assert ("no lanes inside junctions", "repaired") in found
    assert all(link.via for link in town.links)


def test_routes_match_their_town_after_an_opendrive_round_trip(tmp_path):
    netconvert(tmp_path, "-s", str(TOWN02), "--opendrive-output", "map.xodr")
    command = ["import", str(tmp_path / "map.xodr"), "--name", "carla02", "--no-hazards"]
    out = tmp_path / "carla"

    done = CliRunner().invoke(app, [*command, "--out", str(out), "--routes", "1"])

    assert done.exit_code == 0, done.output
    ours = [route for route in load_suite("longest6") if route.town == "town02"]
    (tmp_path / "routes.xml").write_text(as_carla(ours), encoding="utf-8")
    town = TownFound("carla02", out / "towns" / "carla02", must_copy=False)
    routes = read_carla_routes(tmp_path / "routes.xml")
    matches = match_routes(routes, {"Town02": town}, 1.5, lambda _: None)
    assert [match.reason for match in matches] == [""] * 6
    assert max(match.worst for match in matches) < 0.5


def test_handwritten_opendrive_ring_road_is_imported(tmp_path):
    roads = [quarter_ring(number) for number in range(4)]
    text = f'<OpenDRIVE><header revMajor="1" revMinor="4"/>{"".join(roads)}</OpenDRIVE>'
    (tmp_path / "ring.xodr").write_text(text)

    town, _ = mended(tmp_path / "ring.xodr")

    assert len(find_unreachable(town)) == 4  # of 8: the two directions do not meet
    length = sum(lanes[0].length for lanes in town.edges.values())
    assert length == pytest.approx(2 * math.pi * (78.25 + 81.75), rel=0.05)


def quarter_ring(number):
    """A quarter of a circle of 80 m radius, driven to the left, one lane each way."""
    start, length = number * math.pi / 2, 40 * math.pi
    x, y, name = 80 * math.cos(start), 80 * math.sin(start), number + 1
    lane = '<lane id="{0}" type="driving"><link><predecessor id="{0}"/><successor id="{0}"/></link>'
    lane += '<width sOffset="0" a="3.5" b="0" c="0" d="0"/></lane>'
    return f"""<road id="{name}" length="{length}" junction="-1">
      <link><predecessor elementType="road" elementId="{(number + 3) % 4 + 1}" contactPoint="end"/>
      <successor elementType="road" elementId="{(number + 1) % 4 + 1}" contactPoint="start"/></link>
      <planView><geometry s="0" x="{x}" y="{y}" hdg="{start + math.pi / 2}" length="{length}">
      <arc curvature="0.0125"/></geometry></planView>
      <lanes><laneSection s="0"><left>{lane.format(1)}</left><center><lane id="0" type="none"/>
      </center><right>{lane.format(-1)}</right></laneSection></lanes></road>"""


OSM_PLACES = {(i, j): 1 + 4 * i + j for i in range(4) for j in range(4)}
OSM_FURTHER = {101: (-60, 60), 102: (60, 195), 103: (340, 195), 104: (460, 60), 105: (195, -60)}


def write_osm(path):
    """A town of 4 x 4 junctions, a tunnel below it, a path, rails and a street that ends."""
    nodes = {number: (i * 130, j * 130) for (i, j), number in OSM_PLACES.items()} | OSM_FURTHER
    ways = []
    for (i, j), number in OSM_PLACES.items():
        for place in ((i + 1, j), (i, j + 1)):
            if place in OSM_PLACES:
                kind = "secondary" if j == 1 and place[1] == 1 else "residential"
                ways.append(((number, OSM_PLACES[place]), {"highway": kind, "maxspeed": "50"}))
    ways += [
        ((1, 101, 102), {"highway": "tertiary", "maxspeed": "50"}),
        ((102, 103), {"highway": "tertiary", "tunnel": "yes", "layer": "-1", "maxspeed": "50"}),
        ((103, 104, 13), {"highway": "tertiary", "maxspeed": "50"}),
        ((5, 105), {"highway": "residential"}),
        ((2, 7), {"highway": "footway"}),
        ((3, 12), {"railway": "rail"}),
    ]
    lines = [
        f'<node id="{n}" lat="{49 + y / 111320:.7f}" lon="{8 + x / 73032:.7f}"/>'
        for n, (x, y) in nodes.items()
    ]
    for number, (ends, tags) in enumerate(ways):
        inside = "".join(f'<nd ref="{n}"/>' for n in ends)  # codespell:ignore nd
        inside += "".join(f'<tag k="{k}" v="{v}"/>' for k, v in tags.items())
        lines.append(f'<way id="{1000 + number}">{inside}</way>')
    path.write_text(f'<osm version="0.6">{"".join(lines)}</osm>', encoding="utf-8")


def test_imported_openstreetmap_town_can_be_scored(tmp_path, monkeypatch):
    monkeypatch.setenv(TOWNS_VARIABLE, "")
    monkeypatch.chdir(tmp_path)
    write_osm(tmp_path / "map.osm")
    command = ["import", "map.osm", "--name", "osm-town", "--routes", "1"]
    command += ["--min-length", "150", "--max-length", "250"]

    done = CliRunner().invoke(app, command)

    assert done.exit_code == 0, done.output
    report = json.loads((tmp_path / "osm-town/towns/osm-town/import.json").read_text())
    found = {item["what"]: item["count"] for item in report["findings"]}
    assert found["ways for pedestrians, bicycles or trains only"] == 2
    assert "dead ends" in found
    (length,) = [f"{route['length']:.0f} m" for route in report["routes"]]
    about = (tmp_path / "osm-town/towns/osm-town/import.md").read_text()
    assert f"| osm-town-0 | {length} | " in about
    town = Town.from_json((tmp_path / "osm-town/towns/osm-town/town.json").read_text())
    assert min(lane.points[:, 2].min() for lane in town.lanes.values()) < -4.0
    assert "roads that cross at the same height" not in found
    command = ["score", "--suite", "osm-town/routes", "--agent", "cruise", "--routes", "0"]
    done = CliRunner().invoke(app, [*command, "--repetitions", "1", "--workers", "1"])
    assert done.exit_code == 0, done.output
    (record,) = (tmp_path / "reports" / "cruise-osm-town" / "episodes").glob("*.json")
    assert json.loads(record.read_text())["town"] == "osm-town"


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("<net></net>", "netconvert"),
        ("<osm version='0.6'></osm>", "no road"),
        ("<OpenDRIVE><header revMajor='1' revMinor='4'/></OpenDRIVE>", "no road"),
        ("<net><edge id='a' from='b' to='c'><lane id='x'/></edge></net>", "netconvert|no road"),
    ],
)
def test_map_without_roads_is_refused_and_nothing_is_written(text, words, tmp_path):
    path = tmp_path / "a b;$(x) 地図.xml"
    path.write_text(text, encoding="utf-8")
    out = tmp_path / "out"

    done = CliRunner().invoke(app, ["import", str(path), "--name", "nothing", "--out", str(out)])

    assert isinstance(done.exception, InputError)
    assert done.exception.args[0].count("\n") == 0
    assert any(word in str(done.exception) for word in words.split("|"))
    assert sorted(item.name for item in tmp_path.iterdir()) == [path.name]


def test_map_without_a_closed_loop_is_refused(tmp_path):
    (tmp_path / "n.xml").write_text(
        '<nodes><node id="a" x="0" y="0"/><node id="b" x="900" y="0"/></nodes>'
    )
    (tmp_path / "e.xml").write_text('<edges><edge id="ab" from="a" to="b"/></edges>')
    netconvert(tmp_path, "-n", "n.xml", "-e", "e.xml", "-o", "map.net.xml")

    with pytest.raises(InputError, match="use a map on which cars can drive in circles"):
        mended(tmp_path / "map.net.xml")


def test_map_that_is_too_large_is_refused(tmp_path):
    text = '<node id="n22" x="90000" y="260"'
    path = grid_net(tmp_path)
    wide = (tmp_path / "n.xml").read_text().replace('<node id="n22" x="260" y="260"', text)
    (tmp_path / "n.xml").write_text(wide)
    netconvert(tmp_path, "-n", "n.xml", "-e", "e.xml", "-o", "map.net.xml")

    with pytest.raises(InputError, match="90 km wide"):
        mended(path)


def test_existing_town_is_replaced_only_with_overwrite(tmp_path):
    out = tmp_path / "out"
    (out / "towns" / "again").mkdir(parents=True)

    done = CliRunner().invoke(app, ["import", str(TOWN02), "--name", "again", "--out", str(out)])

    assert "use --overwrite" in str(done.exception)


def test_routes_longer_than_the_town_allows_are_refused(tmp_path):
    town, _ = mended(TOWN02)

    with pytest.raises(InputError, match="Lower --min-length"):
        make_routes(town, RouteRequest(count=1, shortest=20_000.0, longest=30_000.0))


def avenue(folder):
    """A 2 x 2 grid of long streets; at n10 from the west, lane 1 turns left and lane 0 goes on.

    Returns the network, and points in the middle of lane 1 and of the street north of n10.
    """
    nodes = "".join(
        f'<node id="n{i}{j}" x="{i * 450}" y="{j * 450}" type="priority"/>'
        for i in range(3)
        for j in range(2)
    )
    pairs = [(f"n{i}{j}", f"n{i + 1}{j}") for i in range(2) for j in range(2)]
    pairs += [(f"n{i}0", f"n{i}1") for i in range(3)]
    edges = "".join(
        f'<edge id="{a}{b}" from="{a}" to="{b}" numLanes="2" speed="13.9"/>'
        for one, other in pairs
        for a, b in ((one, other), (other, one))
    )
    turn = """<connection from="n00n10" to="n10n11" fromLane="1" toLane="1"/>
        <connection from="n00n10" to="n10n20" fromLane="0" toLane="0"/>"""
    (folder / "n.xml").write_text(f"<nodes>{nodes}</nodes>")
    (folder / "e.xml").write_text(f"<edges>{edges}</edges>")
    (folder / "c.xml").write_text(f"<connections>{turn}</connections>")
    files = ("-n", "n.xml", "-e", "e.xml", "-x", "c.xml", "-o", "map.net.xml")
    netconvert(folder, *files, "--no-turnarounds", "true")
    beside = 1.6  # m from the street's middle line, in its left lane
    west = [(x, -beside) for x in (310.0, 360.0, 410.0)]
    north = [(450.0 + beside, y) for y in (60.0, 200.0, 300.0)]
    return folder / "map.net.xml", (*west, *north)


def test_vehicle_handed_back_on_a_turn_lane_turns_with_it(tmp_path, monkeypatch):
    """It came from the lane straight on, as after a cut-in; its own route goes straight on."""
    net, points = avenue(tmp_path)
    monkeypatch.setenv(TOWNS_VARIABLE, str(tmp_path / "m" / "towns"))
    command = ["import", str(net), "--name", "avenue", "--no-hazards", "--out", str(tmp_path / "m")]
    done = CliRunner().invoke(app, [*command, "--routes", "1", "--min-length", "300"])
    assert done.exit_code == 0, done.output
    waypoints = "".join(f'<waypoint x="{x}" y="{-y}" z="0"/>' for x, y in points)
    (tmp_path / "routes.xml").write_text(
        f'<routes><route id="0" town="Avenue">{waypoints}</route></routes>'
    )
    town = TownFound("avenue", tmp_path / "m" / "towns" / "avenue", must_copy=False)
    carla = read_carla_routes(tmp_path / "routes.xml")
    route = match_routes(carla, {"Avenue": town}, 1.5, lambda _: None)[0].route
    assert route is not None
    with Simulation(Scenario(route, 1, "empty", hazards=False)) as simulation:
        world = simulation._hazard_world
        street = simulation.town.edges["n00n10"]
        other = world.send(CAR, ("n00n10", "n10n20"), street[0], 320.0, 8.0)
        assert other is not None
        for _ in range(20):
            simulation.step(Control(0.0, 0.0))
        libsumo.vehicle.setLaneChangeMode(str(other), 0)  # as during the cut-in
        libsumo.vehicle.moveTo(str(other), "n00n10_1", 380.0)
        simulation.step(Control(0.0, 0.0))

        world.hand_back(other)

        while libsumo.vehicle.getRoadID(str(other)) not in ("n10n11", "n10n20"):
            simulation.step(Control(0.0, 0.0))
            assert simulation.scene.tick < 800
        assert libsumo.vehicle.getRoadID(str(other)) == "n10n11"
