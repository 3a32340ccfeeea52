import numpy as np
import pytest

from plant_bench.errors import InputError
from plant_bench.towns.street_plan import Edge, Node, StreetPlan
from plant_bench.towns.turns import connect_junction

ENDS = {"e": (100.0, 0.0), "n": (0.0, 100.0), "w": (-100.0, 0.0), "s": (0.0, -100.0)}


def junction(**lanes):
    """Two-way arms of a junction at (0, 0), lanes each way by arm."""
    plan = StreetPlan()
    plan.add_node(Node("c", 0.0, 0.0))
    for arm, count in lanes.items():
        x, y = ENDS[arm]
        plan.add_node(Node(arm, x, y))
        out = np.array([[0.0, 0.0], [x, y]])
        plan.add_edge(Edge(f"c-{arm}", "c", arm, count, 13.88, out, "street"))
        plan.add_edge(Edge(f"{arm}-c", arm, "c", count, 13.88, out[::-1], "street"))
    connect_junction(plan, "c")
    return plan


def turns_of(plan, arm):
    return {(c.start_lane, c.end, c.end_lane) for c in plan.connections if c.start == f"{arm}-c"}


def test_the_leftmost_of_two_lanes_turns_left_only():
    plan = junction(e=2, n=2, w=2, s=2)
    assert turns_of(plan, "s") >= {(0, "c-e", 0), (0, "c-n", 0), (1, "c-w", 1)}
    assert {end for lane, end, _ in turns_of(plan, "s") if lane == 1} == {"c-w"}


def test_single_lane_connects_to_all_but_the_u_turn():
    plan = junction(e=1, n=1, w=1, s=1)
    assert {end for _, end, _ in turns_of(plan, "s")} == {"c-e", "c-n", "c-w"}


@pytest.mark.parametrize(
    "lanes",
    [
        {"e": 2, "n": 2, "w": 2, "s": 2},
        {"e": 3, "n": 2, "w": 3, "s": 2},
        {"e": 1, "n": 2, "w": 1, "s": 2},
        {"e": 2, "w": 2, "s": 2},
        {"e": 1, "w": 1, "s": 2},
        {"e": 3, "w": 3, "s": 2},
        {"e": 1, "w": 1, "s": 1},
    ],
)
def test_every_lane_has_a_successor_and_a_predecessor(lanes):
    plan = junction(**lanes)
    for arm, count in lanes.items():
        assert {lane for lane, _, _ in turns_of(plan, arm)} == set(range(count))
        entered = {c.end_lane for c in plan.connections if c.end == f"c-{arm}"}
        assert entered == set(range(count))


def test_two_edges_with_one_name_are_refused():
    plan = junction(e=1, w=1, s=1)
    with pytest.raises(InputError, match="c-e"):
        plan.add_edge(plan.edges["c-e"])


def test_lane_indices_count_the_sidewalk_first(tmp_path):
    plan = StreetPlan()
    for name, x in (("a", 0.0), ("b", 50.0), ("c", 100.0)):
        plan.add_node(Node(name, x, 0.0))
    line = np.array([[0.0, 0.0], [50.0, 0.0]])
    plan.add_edge(Edge("ab", "a", "b", 1, 13.88, line, "street", sidewalk=True))
    plan.add_edge(Edge("bc", "b", "c", 1, 13.88, line + [50.0, 0.0], "street"))
    plan.connect("ab", "bc", [(0, 0)])
    plan.write(tmp_path)
    text = (tmp_path / "plan.con.xml").read_text()
    assert 'fromLane="1" toLane="0"' in text
