"""Collisions: counted, narrowly not counted, counted once, and which side caused them."""

import dataclasses
import math

import pytest

from plant_bench.scoring.infractions import InfractionKind
from plant_bench.world.scene import ActorKind

TOUCH = 2.45 + 2.0  # m between the centres when the ego's bumper meets that of a 4 m car
BESIDE = 1.065 + 1.0  # m between the centres when the ego's flank meets that of a 2 m wide car
KINDS = {
    ActorKind.CAR: "collision_vehicle",
    ActorKind.VAN: "collision_vehicle",
    ActorKind.TRUCK: "collision_vehicle",
    ActorKind.BUS: "collision_vehicle",
    ActorKind.MOTORCYCLE: "collision_vehicle",
    ActorKind.BICYCLE: "collision_vehicle",
    ActorKind.PEDESTRIAN: "collision_pedestrian",
    ActorKind.STATIC: "collision_static",
}


@pytest.mark.parametrize("kind", list(ActorKind))
def test_collision_is_counted_when_the_boxes_overlap(stage, kind):
    other = stage.other(50.0, kind=kind, id=7)
    stage.drive(50.0 - TOUCH + 0.01, others=[other])
    (infraction,) = stage.verdict().infractions
    assert infraction.kind == KINDS[kind]
    assert (infraction.actor, infraction.actor_kind) == (7, kind)
    assert infraction.time == pytest.approx(stage.scenes[-1].time)
    assert infraction.x == pytest.approx(50.0 - TOUCH + 0.01)


@pytest.mark.parametrize("kind", list(ActorKind))
def test_stopping_short_of_an_obstacle_is_no_collision(stage, kind):
    stage.drive(50.0 - TOUCH - 0.01, others=[stage.other(50.0, kind=kind)])
    assert stage.kinds() == []


@pytest.mark.parametrize(("gap", "expected"), [(0.01, []), (-0.01, ["collision_vehicle"])])
def test_passing_close_beside_an_obstacle_is_no_collision(stage, gap, expected):
    stage.drive(100.0, others=[stage.other(50.0, -BESIDE - gap)])
    assert stage.kinds() == expected


def test_rotated_box_is_tested_with_its_orientation(stage):
    away = 2.45 + 1.0 + 0.05  # the other stands crosswise: half its width, not its length
    stage.drive(50.0 - away, others=[stage.other(50.0, yaw=math.pi / 2)])
    assert stage.kinds() == []


@pytest.mark.parametrize("kind", [ActorKind.CAR, ActorKind.PEDESTRIAN, ActorKind.STATIC])
def test_continuous_contact_counts_once(stage, kind):
    other = stage.other(48.0, kind=kind)
    stage.drive(50.0 - TOUCH, others=[other]).stand(400, others=[other])
    assert stage.kinds() == [KINDS[kind]]


def test_vehicle_pushed_along_counts_once(stage):
    def pushed(tick):
        return [stage.other(stage.x + 4.0, speed=5.0)]

    stage.drive(20.0).drive(80.0, speed=5.0, others=pushed)
    assert stage.kinds() == ["collision_vehicle"]


def test_same_static_object_counts_again_after_3_m(stage):
    wall = stage.other(60.0, -1.5, kind=ActorKind.STATIC, extent=(10.0, 1.0))
    stage.drive(52.6, others=[wall])
    stage.drive(55.5, others=[wall])
    assert stage.kinds() == ["collision_static"]
    stage.drive(56.2, others=[wall])
    assert stage.kinds() == ["collision_static", "collision_static"]


def test_second_actor_at_the_same_place_does_not_count(stage):
    both = [stage.other(50.0, 0.5, id=1), stage.other(50.0, -0.5, id=2)]
    stage.drive(46.0, others=both)
    assert stage.kinds() == ["collision_vehicle"]


def test_second_actor_3_m_ahead_counts(stage):
    stage.drive(46.0, others=[stage.other(50.0, id=1)])
    stage.drive(48.9, others=[stage.other(53.0, id=2)])
    assert stage.kinds() == ["collision_vehicle"]
    stage.drive(49.2, others=[stage.other(53.0, id=2)])
    assert stage.kinds() == ["collision_vehicle", "collision_vehicle"]


def test_same_place_counts_again_after_the_ego_was_5_m_away(stage):
    stage.drive(46.0, others=[stage.other(50.0, id=1)])
    stage.drive(41.1, yaw=0.0).drive(46.0, others=[stage.other(50.0, id=2)])
    assert stage.kinds() == ["collision_vehicle"]
    stage.drive(40.5, yaw=0.0).drive(46.0, others=[stage.other(50.0, id=3)])
    assert stage.kinds() == ["collision_vehicle", "collision_vehicle"]


@pytest.mark.parametrize(
    ("ticks_apart", "expected"),
    [(99, ["collision_vehicle"]), (100, ["collision_vehicle", "collision_vehicle"])],
)
def test_same_actor_counts_again_after_5_s_without_contact(stage, ticks_apart, expected):
    """100 ticks without contact put the next one 101 ticks, 5.05 s, after the last."""
    stage.drive(45.7, others=[stage.other(50.0)])
    first = stage.scenes[-1].tick
    stage.drive(56.0, y=3.5)
    stage.stand(first + ticks_apart - stage.scenes[-1].tick, y=3.5)
    stage.stand(1, others=[stage.other(60.0)])
    assert stage.kinds()[: len(expected)] == expected
    assert stage.kinds().count("collision_vehicle") == len(expected)


def cause(stage):
    (infraction,) = [
        item
        for item in stage.verdict().infractions
        if item.kind is not InfractionKind.OUTSIDE_LANES
    ]
    return infraction.cause


def test_rear_end_collision_by_the_ego_is_caused_by_the_ego(stage):
    stage.drive(46.0, others=[stage.other(50.0, speed=9.0)])
    assert cause(stage) == "ego"


def test_head_on_collision_with_a_faster_car_is_caused_by_the_ego(stage):
    stage.drive(46.0, others=[stage.other(50.0, yaw=math.pi, speed=20.0)])
    assert cause(stage) == "ego"


def test_collision_with_a_stationary_ego_is_caused_by_the_car(stage):
    stage.drive(46.0).stand(1, others=[stage.other(50.0, yaw=math.pi, speed=5.0)])
    assert cause(stage) == "other"


def test_rear_end_collision_by_a_car_is_caused_by_the_car(stage):
    stage.drive(46.0).drive(46.2, speed=4.0, others=[stage.other(42.0, speed=9.0)])
    assert cause(stage) == "other"


def test_side_collision_by_a_car_is_caused_by_the_car(stage):
    crossing = stage.other(46.0, 2.9, yaw=-math.pi / 2, speed=8.0)
    stage.drive(46.0).drive(46.5, others=[crossing])
    assert cause(stage) == "other"


def test_swerving_into_the_car_beside_is_caused_by_the_ego(stage):
    stage.drive(46.0).drive(46.5, yaw=0.2, others=[stage.other(48.5, 2.4, speed=10.0)])
    assert cause(stage) == "ego"


def test_car_swerving_into_the_ego_is_the_cause(stage):
    stage.drive(46.0).drive(46.5, others=[stage.other(44.5, 2.3, yaw=-0.2, speed=10.0)])
    assert cause(stage) == "other"


def test_hitting_a_pedestrian_stepping_out_is_caused_by_the_ego(stage):
    walker = stage.other(50.0, 1.2, yaw=-math.pi / 2, speed=1.4, kind=ActorKind.PEDESTRIAN)
    walker = dataclasses.replace(walker, extent=(0.5, 0.5))
    stage.drive(47.0).drive(47.5, others=[walker])
    assert cause(stage) == "ego"


def test_pedestrian_walking_into_the_ego_is_the_cause(stage):
    walker = stage.other(46.0, 1.2, yaw=-math.pi / 2, speed=1.4, kind=ActorKind.PEDESTRIAN)
    stage.drive(46.0).drive(
        46.2, speed=4.0, others=[dataclasses.replace(walker, extent=(0.5, 0.5))]
    )
    assert cause(stage) == "other"
