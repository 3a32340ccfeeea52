"""The hazard table is complete: its parts exist, and the documentation agrees."""

import copy
import inspect
import pickle
import random
import re
from dataclasses import replace
from pathlib import Path

import pytest

from plant_bench.errors import InputError
from plant_bench.sim.hazards.behaviour import HazardBehaviour, parameter_of
from plant_bench.sim.hazards.director import Director
from plant_bench.sim.hazards.hazard_world import HazardWorld
from plant_bench.towns.hazard_places import possible_places
from plant_bench.world.hazard import Hazard, HazardKind
from plant_bench.world.hazard_table import HAZARDS, load_part
from plant_bench.world.route import load_suite
from plant_bench.world.town import load_town

PARTS = ("behaviour", "where", "fits", "numbers")
NAMED = [(kind, part) for kind, row in HAZARDS.items() for part in PARTS if getattr(row, part)]
PAGE = Path(__file__).parents[3] / "docs" / "reference" / "protocol.md"


def test_hazard_kinds_are_identified_by_name() -> None:
    assert list(HAZARDS) == list(HazardKind)
    for kind, row in HAZARDS.items():
        assert (kind.value, str(kind), kind.row) == (kind.name.lower(), kind.value, row)
        assert HazardKind(kind.value) is kind
        assert pickle.loads(pickle.dumps(kind)) is copy.deepcopy(kind) is kind


@pytest.mark.parametrize(("kind", "part"), NAMED, ids=[f"{kind}-{part}" for kind, part in NAMED])
def test_parts_named_in_a_hazard_row_exist(kind: HazardKind, part: str) -> None:
    assert callable(load_part(kind, part))


def test_hazard_scripts_satisfy_the_protocol() -> None:
    for kind in HAZARDS:
        script: type[HazardBehaviour] = load_part(kind, "behaviour")
        assert inspect.isclass(script)
        expected = list(inspect.signature(HazardBehaviour.step).parameters)
        assert list(inspect.signature(script.step).parameters) == expected
        made = list(inspect.signature(script).parameters)
        assert made == ["hazard", "world", "draw"], kind


@pytest.mark.parametrize("part", PARTS)
@pytest.mark.parametrize("name", ["plant_bench.sim.no_such:Thing", "plant_bench.sim:no_such", "x"])
def test_missing_part_is_refused_by_kind_column_and_name(part, name, monkeypatch) -> None:
    kind = HazardKind.CUT_IN
    monkeypatch.setitem(HAZARDS, kind, replace(HAZARDS[kind], **{part: name}))
    with pytest.raises(InputError) as refused:
        load_part(kind, part)
    for told in ("'cut_in'", f"no {part}", f"'{name}'", "world/hazard_table.py"):
        assert told in str(refused.value)


def test_a_missing_script_is_refused_before_the_episode(monkeypatch) -> None:
    kind = HazardKind.QUEUE_TAIL
    row = replace(HAZARDS[kind], behaviour="plant_bench.sim.hazards.queue_tail:Gone")
    monkeypatch.setitem(HAZARDS, kind, row)
    stage = object.__new__(HazardWorld)
    with pytest.raises(InputError, match="queue_tail"):
        Director(stage, (Hazard(kind, 100.0, 0.0, 1),), 0)


def test_a_missing_finder_is_refused(monkeypatch) -> None:
    kind = HazardKind.MERGE_PRESSURE
    row = replace(HAZARDS[kind], where="plant_bench.towns.hazard_places:gone")
    monkeypatch.setitem(HAZARDS, kind, row)
    route = load_suite("longest6")[0]
    with pytest.raises(InputError, match="'merge_pressure' has no where"):
        possible_places(load_town(route.town), route)


def test_two_hazard_kinds_can_share_places(monkeypatch) -> None:
    """Each kerb hazard may use all kerb places; other kinds keep theirs, in order."""
    route = load_suite("longest6")[0]
    town = load_town(route.town)
    before = possible_places(town, route)
    kind, other = HazardKind.MERGE_PRESSURE, HazardKind.CROSSING
    row = replace(HAZARDS[kind], where=HAZARDS[other].where, arm=HAZARDS[other].arm)
    monkeypatch.setitem(HAZARDS, kind, row)
    after = possible_places(town, route)
    shared = [replace(place, kind=kind) for place in before if place.kind is other]
    assert [place for place in after if place.kind is kind] == shared
    assert len(shared) > 10
    rest = [place for place in before if place.kind is not kind]
    assert [place for place in after if place.kind is not kind] == rest


def test_missing_hazard_parameter_is_drawn_from_its_range() -> None:
    written = Hazard(HazardKind.BLOCKED_LANE, 100.0, 0.0, 1, {"wait": 3.0})
    bare = replace(written, parameters={})
    draw = random.Random(1)
    drawn = [parameter_of(bare, "wait", draw) for _ in range(200)]
    low, high = HAZARDS[written.kind].ranges["wait"]
    assert low <= min(drawn) < low + 1.0
    assert high - 1.0 < max(drawn) <= high
    one, other = random.Random(2), random.Random(2)
    assert parameter_of(written, "wait", one) == 3.0
    parameter_of(bare, "wait", other)
    assert one.random() == other.random(), "a written number leaves the other draws alone"


def test_protocol_documentation_has_the_same_hazard_rows() -> None:
    text = PAGE.read_text(encoding="utf-8").partition("| kind | CARLA | where |")[2]
    lines = text.partition("\n\n")[0].splitlines()[2:]
    cells = [[cell.strip() for cell in line.strip("|").split("|")] for line in lines]
    assert len(cells) == len(HAZARDS)
    for (kind, row), (name, carla, _, drawn) in zip(HAZARDS.items(), cells, strict=True):
        letters = re.sub("[^a-z]", "", name.replace("merge under", "merge"))
        assert letters == kind.replace("_", "")
        assert carla == str(row.carla or "-")
        for low, high in row.ranges.values():
            shown = f"{low:g} to {high:g}"
            assert shown in drawn, kind
