"""Vehicle types: realistic sizes, the same in SUMO as in the table."""

from xml.etree import ElementTree

import pytest

from plant_bench.sim.vehicle_types import TYPES_FILE, VEHICLE_TYPES, types_xml
from plant_bench.world.scene import EGO_EXTENT, ActorKind


def test_sumo_types_file_equals_the_table() -> None:
    assert TYPES_FILE.read_text(encoding="utf-8") == types_xml(), (
        "Write it again: python -m plant_bench.sim.vehicle_types"
    )


def test_sumo_types_have_the_sizes_and_top_speeds_of_the_table() -> None:
    read = {item.attrib["id"]: item.attrib for item in ElementTree.parse(TYPES_FILE).iter("vType")}
    for row in VEHICLE_TYPES:
        told = read[row.name]
        assert (float(told["length"]), float(told["width"])) == (row.length, row.width)
        assert float(told.get("maxSpeed", "inf")) == row.top_speed
    assert (float(read["ego"]["length"]), float(read["ego"]["width"])) == EGO_EXTENT


def test_types_used_by_hazards_exist() -> None:
    read = {item.attrib["id"] for item in ElementTree.parse(TYPES_FILE).iter("vType")}
    assert read >= {"ego", "walker", "rider", "car_medium", "van"}


def test_the_shares_of_each_kind_sum_to_one() -> None:
    shares: dict[ActorKind, float] = {}
    for row in VEHICLE_TYPES:
        shares[row.kind] = shares.get(row.kind, 0.0) + row.share
    assert set(shares) == set(ActorKind) - {ActorKind.PEDESTRIAN, ActorKind.STATIC}
    assert all(share == pytest.approx(1.0) for share in shares.values())


def test_each_vehicle_kind_has_three_driver_types() -> None:
    headways = {item.attrib["id"]: item.get("tau") for item in _types()}
    for body in ("car_small", "van", "truck", "bus", "motorcycle", "bicycle"):
        assert len({headways[body + style] for style in ("_calm", "", "_hurried")}) == 3


def test_driver_types_keep_the_traffic_rules() -> None:
    """No driver type runs red lights or has a headway below one decision interval."""
    for item in _types():
        assert "jmIgnoreFoeProb" not in item.attrib
        assert "jmDriveAfterRedTime" not in item.attrib
        assert float(item.get("tau", "1")) >= 0.8


def _types() -> list[ElementTree.Element]:
    return list(ElementTree.parse(TYPES_FILE).iter("vType"))
