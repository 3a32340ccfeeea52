"""Termination: completed, blocked, timed out and deviated, at and just below each limit."""

import math

import pytest

from plant_bench.scoring.infractions import Status

BLOCKED_TICKS = 3600  # 180 s
TIMEOUT_TICKS = 4900  # int(0.8 * 300 + 5) = 245 s


def test_completed_past_99_percent_near_the_destination(stage):
    verdict = stage.drive(297.5).verdict()
    assert verdict.status is Status.COMPLETED
    assert verdict.completion == 1.0
    assert verdict.infractions == []


def test_not_completed_at_99_percent(stage):
    verdict = stage.drive(297.0).verdict()
    assert verdict.status is None
    assert verdict.completion == pytest.approx(0.99)


def test_not_completed_10_m_from_the_destination(stage):
    stage.drive(250.0).drive(290.0, y=10.0)
    stage.drive(300.0, y=10.0)
    assert stage.verdict().status is None
    assert stage.drive(301.0, y=9.0).verdict().status is Status.COMPLETED


def test_scenes_after_termination_are_ignored(stage):
    stage.drive(300.0)
    before = stage.verdict()
    stage.drive(340.0).stand(5000)
    after = stage.verdict()
    assert (after.status, after.distance, after.time) == (
        before.status,
        before.distance,
        before.time,
    )
    assert after.infractions == []


def test_blocked_after_180_s_of_standing(stage):
    stage.drive(50.0).stand(BLOCKED_TICKS + 1)
    verdict = stage.verdict()
    assert verdict.status is Status.BLOCKED
    assert stage.kinds() == ["blocked"]
    assert verdict.completion == pytest.approx(50.0 / 300.0)


def test_not_blocked_at_exactly_180_s(stage):
    stage.drive(50.0).stand(BLOCKED_TICKS)
    assert stage.verdict().status is None


def test_not_blocked_if_the_ego_moves_in_between(stage):
    stage.stand(BLOCKED_TICKS // 3).stand(1, speed=0.1).stand(BLOCKED_TICKS)
    assert stage.verdict().status is None
    assert stage.stand(1).verdict().status is Status.BLOCKED


def test_crawling_below_the_speed_limit_counts_as_standing(stage):
    stage.drive(1.0).drive(20.0, speed=0.099)
    assert stage.verdict().status is Status.BLOCKED


def test_episode_times_out(stage):
    stage.drive(140.0).drive(300.0, speed=0.5)
    verdict = stage.verdict()
    assert verdict.status is Status.TIMED_OUT
    assert verdict.time == pytest.approx(245.05)
    assert stage.kinds() == ["timeout"]


def test_not_timed_out_at_the_last_tick(stage):
    stage.drive(140.0).drive(300.0, speed=0.5)
    del stage.scenes[TIMEOUT_TICKS + 1 :]
    assert stage.scenes[-1].tick == TIMEOUT_TICKS
    assert stage.verdict().status is None


def test_deviated_at_30_m(stage):
    stage.drive(50.0).drive(51.0, y=-30.0)
    assert stage.verdict().status is Status.DEVIATED
    assert stage.stand(100, y=-40.0).kinds() == ["route_deviation", "outside_lanes"]


def test_not_deviated_just_below_30_m(stage):
    stage.drive(50.0).drive(52.0, y=-29.99)
    assert stage.verdict().status is None


def test_deviated_after_30_percent_of_the_route_beyond_15_m(stage):
    stage.drive(50.0).stand(1, y=-15.01).drive(124.0, y=-15.01)
    assert stage.verdict().status is None
    stage.drive(126.0, y=-15.01)
    assert stage.verdict().status is Status.DEVIATED


def test_not_deviated_at_15_m_over_any_distance(stage):
    stage.drive(50.0).drive(290.0, y=-14.99)
    assert stage.verdict().status is None


def test_turning_back_is_a_deviation(stage):
    stage.drive(100.0).drive(71.0, y=3.5)
    assert stage.verdict().status is None
    verdict = stage.drive(69.0, y=3.5).verdict()
    assert verdict.status is Status.DEVIATED
    assert verdict.progress == pytest.approx(100.0)


def test_driving_past_the_end_is_a_deviation(stage):
    stage.drive(250.0).drive(305.0, y=12.0, yaw=0.0)
    assert stage.verdict().status is None
    assert stage.drive(330.0, y=12.0).verdict().status is Status.DEVIATED


def test_completion_takes_precedence_over_a_timeout_in_the_same_tick(stage):
    stage.drive(297.0).stand(TIMEOUT_TICKS - len(stage.scenes) - 599, speed=1.0)
    stage.stand(TIMEOUT_TICKS + 1 - len(stage.scenes), speed=1.0)
    stage.drive(297.4)
    assert stage.scenes[-1].tick == TIMEOUT_TICKS + 1
    verdict = stage.verdict()
    assert verdict.status is Status.COMPLETED
    assert verdict.infractions == []


def test_progress_is_monotonic_and_offset_positive_to_the_left(stage):
    stage.drive(100.0).drive(90.0, y=0.7, yaw=math.pi)
    verdict = stage.verdict()
    assert verdict.progress == pytest.approx(100.0)
    assert verdict.offset == pytest.approx(0.7)
