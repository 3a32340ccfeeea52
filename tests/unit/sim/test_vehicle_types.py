"""The traffic's vehicles: real sizes, and SUMO is told of the same ones."""

from xml.etree import ElementTree

import pytest

from plant_bench.sim.vehicle_types import TYPES_FILE, VEHICLE_TYPES, types_xml
from plant_bench.world.scene import EGO_EXTENT, ActorKind


def test_the_file_sumo_reads_is_the_table() -> None:
    assert TYPES_FILE.read_text(encoding="utf-8") == types_xml(), (
        "Write it again: python -m plant_bench.sim.vehicle_types"
    )


def test_sumo_is_told_the_same_sizes_and_top_speeds() -> None:
    read = {item.attrib["id"]: item.attrib for item in ElementTree.parse(TYPES_FILE).iter("vType")}
    for row in VEHICLE_TYPES:
        told = read[row.name]
        assert (float(told["length"]), float(told["width"])) == (row.length, row.width)
        assert float(told.get("maxSpeed", "inf")) == row.top_speed
    assert (float(read["ego"]["length"]), float(read["ego"]["width"])) == EGO_EXTENT


def test_what_hazards_put_out_is_there() -> None:
    read = {item.attrib["id"] for item in ElementTree.parse(TYPES_FILE).iter("vType")}
    assert read >= {"ego", "walker", "rider", "car_medium", "van"}


def test_the_shares_of_each_kind_sum_to_one() -> None:
    shares: dict[ActorKind, float] = {}
    for row in VEHICLE_TYPES:
        shares[row.kind] = shares.get(row.kind, 0.0) + row.share
    assert set(shares) == set(ActorKind) - {ActorKind.PEDESTRIAN, ActorKind.STATIC}
    assert all(share == pytest.approx(1.0) for share in shares.values())


def test_each_kind_has_drivers_of_three_tempers() -> None:
    headways = {item.attrib["id"]: item.get("tau") for item in _types()}
    for body in ("car_small", "van", "truck", "bus", "motorcycle", "bicycle"):
        assert len({headways[body + style] for style in ("_calm", "", "_hurried")}) == 3


def test_no_temper_departs_from_the_rules() -> None:
    """None runs lights, and none keeps less headway than a driver needs to decide anew."""
    for item in _types():
        assert "jmIgnoreFoeProb" not in item.attrib
        assert "jmDriveAfterRedTime" not in item.attrib
        assert float(item.get("tau", "1")) >= 0.8


def _types() -> list[ElementTree.Element]:
    return list(ElementTree.parse(TYPES_FILE).iter("vType"))
