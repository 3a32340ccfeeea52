"""Only `Actors` knows which ids are parked; modules above the world do not compare ids."""

import ast
from itertools import pairwise
from pathlib import Path

import pytest

import plant_bench
from plant_bench.world import actor_ids as actor_numbers
from plant_bench.world.actor_ids import EGO, PARKED, PEDESTRIANS, SUMO_PROXIES, TRAFFIC, is_parked
from plant_bench.world.scene import Actors
from tests.builders import make_actors

PACKAGE = Path(plant_bench.__file__).parent
OWNERS = ("world", "sim")  # the packages that assign ids
BLOCKS = (range(EGO, EGO + 1), TRAFFIC, PEDESTRIANS, SUMO_PROXIES, PARKED)


def numbered(*numbers: int) -> Actors:
    return make_actors([(0.0, 0.0)] * len(numbers), ids=numbers)


def test_id_ranges_are_contiguous():
    assert all(one.stop == other.start for one, other in pairwise(BLOCKS))


def test_parked_and_traffic_are_told_by_id():
    actors = numbered(1, 499_999, 500_000, 699_999, 999_999, 1_000_000, 2**40)
    assert actors.parked.tolist() == [False] * 5 + [True] * 2
    assert actors.in_traffic.tolist() == [True] * 2 + [False] * 5
    assert [is_parked(number) for number in actors.ids.tolist()] == actors.parked.tolist()
    assert Actors.none().parked.shape == (0,)


def compares_ids(node: ast.AST) -> bool:
    """Return whether a comparison orders actor ids against a constant."""
    if not isinstance(node, ast.Compare):
        return False
    ordered = any(isinstance(op, ast.Lt | ast.LtE | ast.Gt | ast.GtE) for op in node.ops)
    sides = [node.left, *node.comparators]
    ids = any(isinstance(side, ast.Attribute) and side.attr == "ids" for side in sides)
    return ordered and ids and any(isinstance(side, ast.Constant | ast.Name) for side in sides)


@pytest.mark.parametrize(
    ("text", "found"),
    [("a.ids >= FIRST", True), ("500_000 > a.ids", True), ("a.ids == 5", False), ("x > 3", False)],
)
def test_comparisons_of_ids_are_detected(text: str, found: bool):
    assert compares_ids(ast.parse(text, mode="eval").body) is found


def test_only_world_and_sim_use_the_id_ranges():
    blocks = {name for name, value in vars(actor_numbers).items() if isinstance(value, range)}
    firsts = {PEDESTRIANS.start, SUMO_PROXIES.start}  # a million is many things
    for path in sorted(PACKAGE.rglob("*.py")):
        if path.relative_to(PACKAGE).parts[0] in OWNERS:
            continue
        nodes = list(ast.walk(ast.parse(path.read_text(encoding="utf-8"))))
        imported = {
            name.name
            for node in nodes
            if isinstance(node, ast.ImportFrom) and node.module == actor_numbers.__name__
            for name in node.names
        }
        assert not blocks & imported, path
        assert not any(compares_ids(node) for node in nodes), path
        copied = {node.value for node in nodes if isinstance(node, ast.Constant)} & (
            firsts - {10**6}
        )
        assert not copied, path
