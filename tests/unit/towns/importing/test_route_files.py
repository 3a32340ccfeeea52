"""CARLA's route files: read, matched to towns, and reported if they do not match."""

import csv
import math
import re
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from plant_bench.cli import app
from plant_bench.data_files import TOWNS_VARIABLE, networks_dir
from plant_bench.errors import InputError
from plant_bench.towns.importing import carla_routes, matching
from plant_bench.towns.importing.carla_routes import CarlaRoute, read_carla_routes
from plant_bench.towns.importing.carla_sources import carla_routes as sources_of
from plant_bench.towns.importing.lane_graph import LaneGraph
from plant_bench.towns.importing.route_import import TownFound, match_routes, metres_beyond
from plant_bench.world.route import load_suite
from plant_bench.world.town import Town
from tests.builders import make_lane
from tests.unit.towns.importing.carla_files import as_carla

TOWN02 = TownFound("town02", networks_dir() / "town02", must_copy=False)


def town_routes(name):
    return [route for route in load_suite("longest6") if route.town == name]


def read(tmp_path: Path, text: str):
    path = tmp_path / "routes.xml"
    path.write_text(text, encoding="utf-8")
    return read_carla_routes(path)


def matched(tmp_path, text, town=TOWN02, limit=1.5):
    return match_routes(read(tmp_path, text), {"Town02": town}, limit, lambda _: None)


def test_both_carla_formats_become_right_handed(tmp_path):
    one = '<route id="7" town="Town01"><waypoint x="1" y="2" z="3" yaw="90"/>' * 1
    one += '<waypoint x="5" y="-6" z="0" yaw="0"/></route>'
    two = '<route id="8" town="Town02"><waypoints><position x="1" y="2" z="3"/>'
    two += '<position x="2" y="2" z="3"/></waypoints>'
    two += '<scenarios><scenario><trigger_point x="9" y="9"/></scenario></scenarios></route>'

    first, second = read(tmp_path, f"<routes>{one}{two}</routes>")

    assert (first.id, first.town) == ("7", "Town01")
    np.testing.assert_allclose(first.points, [[1, -2, 3], [5, 6, 0]])
    np.testing.assert_allclose(first.headings, [-math.pi / 2, 0])
    np.testing.assert_allclose(second.points, [[1, -2, 3], [2, -2, 3]])
    assert np.isnan(second.headings).all()


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("<routes></routes>", "has no routes"),
        ("<net/>", "begins with <net>"),
        ("<routes><route id='1'><waypoint x='1' y='2'/></route></routes>", "two or more"),
        ("<routes><route id='1'><waypoint x='nan' y='2'/></route></routes>", "must be numbers"),
        ("<routes><route id='1'><waypoint y='2'/></route></routes>", "must be numbers"),
        ("<routes><route id='1'><waypoint x='1e9' y='2'/></route></routes>", "must be numbers"),
        ("<routes><route id='../'/></routes>", "no id"),
        ("<!DOCTYPE a><routes/>", "document type"),
    ],
)
def test_an_unusable_route_file_is_refused_with_one_line(text, words, tmp_path):
    with pytest.raises(InputError, match=words) as error:
        read(tmp_path, text)

    assert "\n" not in str(error.value)


@pytest.mark.parametrize("version", [1, 2])
def test_matched_routes_equal_the_originals(version, tmp_path):
    ours = town_routes("town02")

    for route, match in zip(ours, matched(tmp_path, as_carla(ours, version=version)), strict=True):
        assert match.route is not None, match.reason
        assert match.worst < 0.3
        lanes = [span.lane for span in match.route.lanes]
        assert [span.lane for span in route.lanes][: len(lanes) - 1] == lanes[:-1]
        assert match.route.length == pytest.approx(route.length, abs=5.0)
        assert len(match.route.passages) >= len(route.passages) - 1


def test_all_longest6_routes_match_their_own_towns(tmp_path):
    routes = load_suite("longest6")
    names = {route.town for route in routes}
    towns = {
        f"Town{name[-2:]}": TownFound(name, networks_dir() / name, must_copy=False)
        for name in names
    }

    matches = match_routes(read(tmp_path, as_carla(routes)), towns, 1.5, lambda _: None)

    assert len(matches) == 36
    assert [match.reason for match in matches] == [""] * 36
    assert max(match.worst for match in matches) < 1.0
    assert all(match.route is not None for match in matches)


def test_unmatched_point_names_route_point_and_reason(tmp_path):
    text = as_carla(town_routes("town02")[:1]).replace("</route>", "")
    text = text.replace("</routes>", "<waypoint x='900' y='-900' yaw='0'/></route></routes>")

    (match,) = matched(tmp_path, text)

    assert match.route is None
    assert "the nearest lane is" in match.reason
    assert match.point == len(match.source.points) - 1
    assert "x 900.0, y -900.0" in str(match.row)


def test_distance_of_an_off_lane_point_is_measured(tmp_path):
    text = as_carla(town_routes("town02")[:1])
    first = read(tmp_path, text)[0].points[0]
    away = text.replace(f'x="{first[0]:.2f}"', f'x="{first[0] + 1.2:.2f}"', 1)
    away = away.replace(f'y="{-first[1]:.2f}"', f'y="{-first[1] + 1.2:.2f}"', 1)

    (match,) = matched(tmp_path, away, limit=0.5)

    assert match.route is None
    assert "m from the lanes; try --limit-distance" in match.reason
    assert 0.5 < match.worst < 1.8
    assert match.point == 0


def test_route_against_the_traffic_does_not_match(tmp_path):
    route = read(tmp_path, as_carla(town_routes("town02")[:1]))[0]
    points = [
        f'<waypoint x="{x:.2f}" y="{-y:.2f}" yaw="{180 - math.degrees(h):.1f}"/>'
        for (x, y, _), h in zip(route.points[::-1], route.headings[::-1], strict=True)
    ]
    text = f'<routes><route id="1" town="Town02">{"".join(points)}</route></routes>'

    (match,) = matched(tmp_path, text, limit=0.5)

    assert match.route is None
    assert match.reason


@pytest.mark.parametrize(("height", "lane"), [(0.0, "below_0"), (7.0, "above_0")])
def test_stacked_roads_are_matched_by_height(height, lane):
    levels = {"below_0": road("below", 0.0), "above_0": road("above", 7.0)}
    ways = LaneGraph(Town("levels", levels, (), {}, {}))
    points = np.array([[10.0, 0.0, height], [50.0, 0.0, height + 0.3], [90.0, 0.0, height + 0.6]])

    places = matching.match(ways, CarlaRoute("1", "levels", points, np.zeros(3)), 1.5)

    assert [place.lane for place in places] == [lane] * 3


def road(edge, z):
    return make_lane(f"{edge}_0", [(0.0, 0.0, z), (100.0, 0.0, z)])


def test_import_routes_writes_the_suite_and_names_unmatched_routes(tmp_path):
    text = as_carla(town_routes("town02")[:2])
    text = text.replace('id="1" town="Town02"', 'id="1" town="Town09"')
    (tmp_path / "file.xml").write_text(text, encoding="utf-8")
    out = tmp_path / "suite"
    command = ["import-routes", str(tmp_path / "file.xml"), "--out", str(out)]

    done = CliRunner().invoke(app, [*command, "--town-map", "Town02=town02"])

    assert done.exit_code == 1
    assert "no --town-map for" in done.output
    assert "1 of 2 routes match within" in done.output
    (route,) = load_suite(str(out))
    assert route.id == "town02-0"
    assert route.hazards
    with (out / "matching.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert [row["outcome"][:9] for row in rows] == ["matched", "unmatched"]
    assert [row["length"] for row in rows] == [f"{route.length:.0f} m", "-"]
    theirs = [polyline_length(item) for item in read_carla_routes(tmp_path / "file.xml")]
    assert [row["CARLA's length"] for row in rows] == [f"{length:.0f} m" for length in theirs]


def polyline_length(route):
    return sum(math.dist(a[:2], b[:2]) for a, b in pairwise(route.points))


def test_nothing_is_written_if_no_route_matches(tmp_path):
    text = as_carla(town_routes("town02")[:1]).replace("Town02", "Town09")
    (tmp_path / "file.xml").write_text(text, encoding="utf-8")
    command = ["import-routes", str(tmp_path / "file.xml"), "--out", str(tmp_path / "suite")]

    done = CliRunner().invoke(app, [*command, "--town-map", "Town01=town01"])

    assert done.exit_code == 1
    assert sorted(path.name for path in tmp_path.iterdir()) == ["file.xml"]


@pytest.mark.parametrize("pair", ["Town02", "=", "Town02=", "Town02=nowhere"])
def test_invalid_town_map_option_is_refused(pair, tmp_path):
    (tmp_path / "file.xml").write_text(as_carla(town_routes("town02")[:1]), encoding="utf-8")
    command = ["import-routes", str(tmp_path / "file.xml"), "--out", str(tmp_path / "suite")]

    done = CliRunner().invoke(app, [*command, "--town-map", pair])

    assert isinstance(done.exception, InputError)


@pytest.fixture
def theirs(tmp_path, monkeypatch):
    """Copy a town to another folder, under another name; return the folder."""
    monkeypatch.setenv(TOWNS_VARIABLE, "")
    folder = tmp_path / "elsewhere" / "theirs"
    folder.mkdir(parents=True)
    text = (TOWN02.folder / "town.json").read_text(encoding="utf-8")
    (folder / "town.json").write_text(text.replace('"name":"town02"', '"name":"theirs"', 1))
    (folder / "town.net.xml").write_bytes((TOWN02.folder / "town.net.xml").read_bytes())
    return folder


def import_routes(tmp_path, text, *more):
    (tmp_path / "file.xml").write_text(text, encoding="utf-8")
    command = ["import-routes", str(tmp_path / "file.xml"), "--out", str(tmp_path / "suite")]
    return CliRunner().invoke(app, [*command, "--no-hazards", *more])


def test_one_town_can_stand_for_two_carla_towns(theirs, tmp_path):
    text = as_carla(town_routes("town02")[:2]).replace('id="1" town="Town02"', 'id="1" town="T2"')

    done = import_routes(tmp_path, text, "--town-map", f"Town02={theirs} T2={theirs}")

    assert done.exit_code == 0, done.output
    assert [route.id for route in load_suite(str(tmp_path / "suite"))] == ["theirs-0", "theirs-1"]
    assert (tmp_path / "suite" / "towns" / "theirs" / "town.json").is_file()


def test_routes_with_duplicate_names_are_refused(theirs, tmp_path):
    text = as_carla(town_routes("town02")[:2]).replace('id="1" town="Town02"', 'id="0" town="T2"')

    done = import_routes(tmp_path, text, "--town-map", f"Town02={theirs} T2={theirs}")

    assert "Two routes have the name theirs-0" in str(done.exception)
    assert not (tmp_path / "suite").exists()


def test_town_hidden_by_another_of_its_name_is_refused(theirs, tmp_path):
    hidden = theirs.rename(theirs.with_name("town02"))

    done = import_routes(
        tmp_path, as_carla(town_routes("town02")[:1]), "--town-map", f"Town02={hidden}"
    )

    assert "Two towns are named 'town02'" in str(done.exception)


def test_overwrite_removes_routes_of_towns_no_longer_given(theirs, tmp_path):
    text = as_carla(town_routes("town02")[:1])
    import_routes(tmp_path, text, "--town-map", f"Town02={theirs}")
    (tmp_path / "suite" / "notes.json").write_text("mine")

    done = import_routes(tmp_path, text, "--town-map", "Town02=town02", "--overwrite")

    assert done.exit_code == 0, done.output
    suite = sorted(path.name for path in (tmp_path / "suite").glob("*.json"))
    assert suite == ["notes.json", "town02.json"]


@pytest.mark.parametrize("name", ["town.json", "town.net.xml"])
def test_damaged_town_is_refused_with_one_line(name, theirs, tmp_path):
    (theirs / name).write_bytes(b"\xff<")

    done = import_routes(
        tmp_path, as_carla(town_routes("town02")[:1]), "--town-map", f"Town02={theirs}"
    )

    assert isinstance(done.exception, InputError)
    assert "\n" not in str(done.exception)


def test_too_many_points_to_match_are_refused(tmp_path, monkeypatch):
    monkeypatch.setattr(carla_routes, "MAX_POINTS_IN_FILE", 5)
    points = "<waypoint x='1' y='2'/>" * 2
    routes = "".join(f"<route id='{number}' town='a'>{points}</route>" for number in range(3))

    with pytest.raises(InputError, match="more than 5 points: split it"):
        read(tmp_path, f"<routes>{routes}</routes>")


def test_an_imported_suite_keeps_carlas_ids_and_towns(tmp_path):
    text = (
        as_carla(town_routes("town02")[:2]).replace('id="0"', 'id="17"').replace('id="1"', 'id="4"')
    )
    (tmp_path / "file.xml").write_text(text, encoding="utf-8")
    out = tmp_path / "suite"
    command = ["import-routes", str(tmp_path / "file.xml"), "--out", str(out)]
    assert CliRunner().invoke(app, [*command, "--town-map", "Town02=town02"]).exit_code == 0
    assert sources_of(str(out)) == {"town02-17": ("17", "Town02"), "town02-4": ("4", "Town02")}
    assert sources_of("longest6") == {}


def point_on(lane, at):
    """Return a waypoint of CARLA at an arc length of a lane."""
    x, y = (float(np.interp(at, lane.along, column)) for column in lane.points[:, :2].T)
    near_x, near_y = (
        float(np.interp(at + 0.5, lane.along, column)) for column in lane.points[:, :2].T
    )
    back_x, back_y = (
        float(np.interp(at - 0.5, lane.along, column)) for column in lane.points[:, :2].T
    )
    heading = -math.degrees(math.atan2(near_y - back_y, near_x - back_x))
    return f'<waypoint x="{x:.3f}" y="{-y:.3f}" z="0" yaw="{heading:.2f}"/>'


def parallel_links(town):
    """Return lanes before and after a junction: the right one before, the left one after."""
    for link in town.links:
        source, target = town.lanes[link.source], town.lanes[link.target]
        both_have_left = source.left is not None and target.left is not None
        if link.turn != "straight" or not both_have_left or min(source.length, target.length) < 80:
            continue
        if any(other.target == target.left for other in town.links_from.get(source.left, ())):
            return source, town.lanes[target.left]
    raise AssertionError("the town has no such junction")


@pytest.mark.parametrize("left_first", [False, True])
def test_lane_change_through_a_junction_passes_all_points(tmp_path, left_first):
    town = Town.from_json((networks_dir() / "town05" / "town.json").read_text())
    source, target = parallel_links(town)
    if left_first:
        source, target = town.lanes[str(source.left)], town.lanes[str(target.right)]
    points = [
        point_on(source, source.length - 60.0),
        point_on(source, source.length - 4.0),
        point_on(target, 4.0),
        point_on(target, 70.0),
    ]
    text = f'<routes><route id="0" town="Town05">{"".join(points)}</route></routes>'
    found = TownFound("town05", networks_dir() / "town05", must_copy=False)
    (match,) = match_routes(read(tmp_path, text), {"Town05": found}, 1.8, lambda _: None)
    assert match.worst < 0.4
    assert match.route is not None
    assert [change.direction for change in match.route.lane_changes] == [
        "right" if left_first else "left"
    ]
    assert np.abs(np.diff(match.route.headings)).max() < 0.15  # no kink


def test_points_8_m_from_their_lane_match_within_a_larger_limit(tmp_path):
    folder = tmp_path / "straight"
    folder.mkdir()
    lanes = {"a_0": make_lane("a_0", [(0.0, 0.0), (200.0, 0.0)])}
    (folder / "town.json").write_text(Town("straight", lanes, (), {}, {}).to_json())
    (folder / "town.net.xml").write_text("<net/>")
    town = TownFound("straight", folder, must_copy=False)
    waypoints = "".join(f'<waypoint x="{x}" y="8"/>' for x in (40, 100, 160))
    text = f'<routes><route id="0" town="Town02">{waypoints}</route></routes>'
    (near,) = matched(tmp_path, text, town, limit=20.0)
    assert near.worst == pytest.approx(8.0, abs=0.01)
    assert near.route is not None
    assert near.route.length == pytest.approx(120.0, abs=0.1)
    (refused,) = matched(tmp_path, text, town, limit=1.8)
    assert refused.reason == "the nearest lane is 8.0 m away; try --limit-distance 9"
    assert matched(tmp_path, text, town, limit=9.0)[0].route is not None


def test_point_of_another_map_is_named_as_such(tmp_path):
    text = as_carla(town_routes("town02")[:1])
    far = re.sub(r'y="(-?[\d.]+)"', lambda m: f'y="{float(m[1]) - 2200.0:.2f}"', text)
    (match,) = matched(tmp_path, far, limit=20.0)
    assert re.fullmatch(r"the nearest lane is \d{4} m away: is it the right map\?", match.reason)


def test_goal_beyond_carlas_last_point_inside_a_junction_is_told(tmp_path):
    town = Town.from_json((TOWN02.folder / "town.json").read_text())
    source, inside = next(
        (town.lanes[link.source], town.lanes[link.via[0]])
        for link in town.links
        if link.turn == "straight" and len(link.via) == 1 and town.lanes[link.source].length > 80
    )
    places = [(source, source.length - 70.0), (source, source.length - 20.0)]
    points = "".join(point_on(*place) for place in [*places, (inside, 0.5 * inside.length)])
    text = f'<routes><route id="0" town="Town02">{points}</route></routes>'
    (match,) = matched(tmp_path, text)
    assert match.beyond == pytest.approx(0.5 * inside.length + 6.0, abs=0.2)  # 6 m of the next lane
    assert match.route is not None
    goal = f"the goal is {match.beyond:.1f} m beyond CARLA's last point"
    assert match.row[-1] == f"matched; {goal}"
    assert match.row[-3] == f"{match.route.length:.0f} m"


def test_route_that_passes_its_goal_twice_ends_beyond_the_second_pass():
    turned = np.arange(0.0, 73.0) / 10.0  # one metre per point on a circle of 10 m, 10 m too far
    line = 10.0 * np.stack((np.cos(turned), np.sin(turned)), axis=1)
    assert metres_beyond(line, np.array([10.1, 0.0])) == pytest.approx(72 - 20 * math.pi, abs=0.05)
    assert metres_beyond(line[:50], 1.2 * line[49]) == pytest.approx(0.0, abs=0.01)


def as_roach(text):
    """Return a route file in the form of carla-roach: no town, points in <ego_vehicle>."""
    text = re.sub(r' town="\w+">', '><ego_vehicle id="hero">', text)
    return text.replace("</route>", "</ego_vehicle></route>")


def test_routes_of_carla_roach_are_matched_to_the_town_named_for_them(tmp_path):
    text = as_carla(town_routes("town02")[:1])
    done = import_routes(tmp_path, as_roach(text), "--town-map", "=town02")
    assert done.exit_code == 0, done.output
    (route,) = load_suite(str(tmp_path / "suite"))
    (same,) = matched(tmp_path, text)
    assert same.route is not None
    assert route.length == pytest.approx(same.route.length, abs=0.1)
    (unmatched,) = matched(tmp_path, as_roach(text))
    assert unmatched.reason == "it names no town: use --town-map =TOWN"
