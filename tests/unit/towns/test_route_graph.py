"""Edges of a town as seen by routes: exits, U-turns, start and end places."""

from itertools import pairwise

import numpy as np

from plant_bench.towns.route_graph import StreetGraph
from plant_bench.towns.route_paths import random_path
from plant_bench.world.town import Junction, Link, Town, load_town
from tests.builders import make_lane


def make_town(speed):
    """A road of two lanes whose right one leaves for a ramp and whose left one goes on."""
    bend = [(np.sin(a) * 8.0 + 400.0, 8.0 - 8.0 * np.cos(a)) for a in np.linspace(0.0, np.pi, 20)]
    lanes = [
        make_lane("road_0", [(0, 0), (200, 0)], speed_limit=speed),
        make_lane("road_1", [(0, 3.5), (200, 3.5)], speed_limit=speed),
        make_lane("ramp_0", [(200, 0), (300, -50)], speed_limit=22.0),
        make_lane("main_0", [(200, 3.5), (400, 3.5)], speed_limit=22.0),
        make_lane("back_0", bend, speed_limit=22.0),
    ]
    links = (
        Link("road_0", "ramp_0", (), "fork", "right", "major"),
        Link("road_1", "main_0", (), "fork", "straight", "major"),
        Link("main_0", "back_0", (), "end", "straight", "major"),
    )
    junctions = {name: Junction(name, "joint", 0.0, 0.0, 3, ()) for name in ("fork", "end")}
    return Town("hand_made", {item.id: item for item in lanes}, links, junctions, {})


def test_exits_leave_fast_roads_on_the_right():
    graph = StreetGraph(make_town(22.0))
    assert graph.is_exit("road", "ramp")
    assert not graph.is_exit("road", "main")
    assert not StreetGraph(make_town(13.89)).is_exit("road", "ramp")
    assert graph.starts == ("main",)


def test_u_turns_are_short_edges_that_turn_back():
    graph = StreetGraph(make_town(22.0))
    assert graph.u_turns == {"back"}
    assert graph.landmarks == ("ramp", "back")
    assert graph.is_joint("fork")
    assert not graph.is_crossing("fork")


def test_paths_are_linked_and_use_no_edge_twice():
    graph = StreetGraph(load_town("town02"))
    rng = np.random.default_rng(5)
    paths = [path for _ in range(40) if (path := random_path(graph, rng)) is not None]
    assert len(paths) > 20
    for path in paths:
        assert len(set(path)) == len(path)
        assert path[0] in graph.starts
        assert path[-1] in graph.ends
        assert all(b in graph.onward[a] for a, b in pairwise(path))
