"""Outside lanes: the share of the distance off all lanes or against the direction of one."""

import math

import pytest

EDGE = 3.5 / 2 + 1.3  # m from the lane's centre


def share(stage):
    found = [item for item in stage.verdict().infractions if item.kind == "outside_lanes"]
    return found[0].share if found else 0.0


def test_driving_off_the_lane_is_counted(stage):
    stage.drive(60.0).stand(1, y=-EDGE - 0.01).drive(80.0, y=-EDGE - 0.01)
    verdict = stage.verdict()
    aside = EDGE + 0.01  # the sideways jump is driven too
    assert verdict.distance == pytest.approx(80.0 + aside - 0.5)
    assert share(stage) == pytest.approx((20.0 + aside) / (79.5 + aside))
    assert verdict.infractions[0].factor == pytest.approx(1.0 - share(stage))


def test_driving_just_inside_the_lane_margin_is_not_counted(stage):
    stage.drive(60.0).drive(80.0, y=-EDGE + 0.01)
    assert stage.kinds() == []


def test_repeated_lane_departures_count_once(stage):
    for x in range(20, 140, 20):
        stage.drive(x - 10.0).drive(float(x), y=-4.0)
    assert stage.kinds() == ["outside_lanes"]
    assert stage.verdict().infractions[0].time == pytest.approx(stage.scenes[-1].time)


def test_calling_finish_twice_counts_once(stage):
    verdict = stage.drive(10.0).drive(20.0, y=-4.0).verdict()
    verdict.finish()
    assert [str(item.kind) for item in verdict.infractions] == ["outside_lanes"]


def test_driving_in_the_oncoming_lane_is_counted(stage):
    stage.drive(50.0).drive(60.0, y=3.5)
    assert stage.kinds() == ["outside_lanes"]


def test_driving_just_outside_the_oncoming_lane_is_not_counted(stage):
    stage.drive(50.0).drive(60.0, y=1.74)
    assert stage.kinds() == []
    assert stage.drive(70.0, y=1.76).kinds() == ["outside_lanes"]


@pytest.mark.parametrize(("degrees", "expected"), [(119.0, []), (121.0, ["outside_lanes"])])
def test_wrong_way_begins_at_120_degrees(stage, degrees, expected):
    stage.drive(50.0).drive(51.0, yaw=math.radians(degrees))
    assert stage.kinds() == expected


def test_direction_is_not_checked_inside_a_junction(stage):
    stage.drive(150.1).drive(169.9, y=3.5)
    assert stage.kinds() == []


def test_direction_is_not_checked_on_junction_lanes_outside_its_outline(stage):
    stage.drive(150.1).drive(169.9, y=5.8)
    assert stage.kinds() == []


def test_junction_outline_beyond_its_lanes_is_not_off_lane(stage):
    stage.drive(170.1).drive(171.9, y=3.5)
    assert stage.kinds() == []
    assert stage.drive(172.4, y=3.5).kinds() == ["outside_lanes"]


def test_lanes_on_another_level_do_not_count(stage):
    stage.drive(214.0).drive(216.0, y=-10.0)
    assert stage.kinds() == ["outside_lanes"]


def test_bridge_over_the_route_does_not_put_the_ego_off_lane(stage):
    stage.drive(240.0, y=1.2)
    assert stage.kinds() == []


def test_standing_off_the_lane_is_not_counted(stage):
    stage.stand(100, y=-5.0)
    assert stage.kinds() == []


def test_position_far_from_any_lane_is_off_lane(stage):
    stage.drive(50.0).drive(51.0, y=-20.0)
    assert stage.kinds() == ["outside_lanes"]


def test_off_lane_and_wrong_lane_distances_are_separate(stage):
    stage.drive(20.0).stand(1, y=-5.0).drive(30.0, y=-5.0).stand(1).drive(50.0)
    stage.stand(1, y=3.5).drive(65.0, y=3.5).stand(1).drive(100.0)
    verdict = stage.verdict()
    assert verdict.off_lane_distance == pytest.approx(5.0 + 10.0)
    assert verdict.wrong_lane_distance == pytest.approx(3.5 + 15.0)
    both = verdict.off_lane_distance + verdict.wrong_lane_distance
    assert verdict.outside_distance == pytest.approx(both)
    assert verdict.measures is not None
    assert verdict.measures["off_lane_distance"] == pytest.approx(15.0)
    assert verdict.measures["wrong_lane_distance"] == pytest.approx(18.5)
