import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from plant_bench.geometry.pose import wrap_angle
from plant_bench.towns.street_shapes import (
    Pose,
    arc_lengths,
    corner,
    curve_between,
    end_pose,
    fillet,
    offset,
    resample,
    start_pose,
    thin_out,
    tightest_radius,
)


def circle(radius, count=400):
    angles = np.linspace(0, 2 * np.pi, count)
    return radius * np.stack([np.cos(angles), np.sin(angles)], axis=1)


def test_quarter_turn_between_perpendicular_poses_is_nearly_an_arc():
    shape = curve_between(Pose(0.0, 0.0, 0.0), Pose(20.0, 20.0, np.pi / 2))
    away = np.hypot(*(shape - [0, 20]).T)
    assert np.abs(away - 20).max() < 0.05


def test_lateral_shift_is_a_smooth_s_curve():
    shape = curve_between(Pose(0.0, 0.0, 0.0), Pose(60.0, 5.0, 0.0))
    assert start_pose(shape).heading == pytest.approx(0, abs=0.02)
    assert end_pose(shape).heading == pytest.approx(0, abs=0.02)
    assert tightest_radius(shape) > 80


def test_a_fillet_keeps_its_radius_and_its_ends():
    shape = fillet([(0.0, 0.0), (100.0, 0.0), (100.0, 80.0)], 30.0)
    assert tuple(shape[0]) == (0, 0)
    assert tuple(shape[-1]) == (100, 80)
    assert tightest_radius(shape) == pytest.approx(30, rel=0.07)


def test_fillet_shrinks_if_the_legs_are_short():
    shape = fillet([(0.0, 0.0), (20.0, 0.0), (20.0, 20.0)], 30.0)
    assert 7 < tightest_radius(shape) < 11


def test_corner_is_straight_then_curved_then_straight():
    shape = corner(Pose(0.0, 0.0, 0.0), Pose(100.0, 80.0, np.pi / 2), 40.0)
    assert np.hypot(*(shape - [60, 0]).T).min() < 0.1
    assert tightest_radius(shape) == pytest.approx(40, rel=0.07)


@pytest.mark.parametrize(("left", "radius"), [(3.0, 17.0), (-3.0, 23.0)])
def test_an_offset_to_the_left_of_a_left_bend_is_tighter(left, radius):
    moved = offset(circle(20.0), left)
    assert np.hypot(*moved.T) == pytest.approx(radius, abs=0.02)


def test_an_offset_keeps_the_height():
    line = np.column_stack([circle(20.0), np.linspace(0, 7, 400)])
    assert np.array_equal(offset(line, 2.0)[:, 2], line[:, 2])


def test_radius_of_a_circle_is_recovered():
    assert tightest_radius(circle(12.0)) == pytest.approx(12, rel=0.02)


def test_thinning_drops_redundant_points_of_a_straight():
    straight = np.linspace([0.0, 0.0], [50.0, 10.0], 51)
    assert len(thin_out(straight)) == 2
    bend = np.concatenate([straight, [[50.0, 30.0]]])
    assert thin_out(bend).tolist() == [[0, 0], [50, 10], [50, 30]]


def test_thinning_keeps_the_top_of_a_slope():
    crest = np.array([[0.0, 0, 0], [10, 0, 1], [20, 0, 0]])
    assert len(thin_out(crest)) == 3


@given(
    x=st.floats(30, 300),
    y=st.floats(-80, 80),
    leave=st.floats(-0.5, 0.5),
    arrive=st.floats(-0.5, 0.5),
)
def test_curve_starts_and_ends_at_its_poses(x, y, leave, arrive):
    shape = curve_between(Pose(0.0, 0.0, leave), Pose(x, y, arrive))
    assert shape[0] == pytest.approx([0, 0])
    assert shape[-1] == pytest.approx([x, y])
    assert abs(wrap_angle(start_pose(shape).heading - leave)) < 0.15
    assert abs(wrap_angle(end_pose(shape).heading - arrive)) < 0.15


@given(length=st.floats(1, 500), spacing=st.floats(0.2, 5))
def test_resampling_keeps_length_and_ends(length, spacing):
    line = np.array([[0.0, 0.0], [length, 0.0]])
    fine = resample(line, spacing)
    assert arc_lengths(fine)[-1] == pytest.approx(length)
    assert np.diff(arc_lengths(fine)).max() <= spacing + 1e-9
