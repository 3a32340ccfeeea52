import math

import numpy as np
import pytest

from plant_bench.geometry.polyline import (
    Cursor,
    arc_lengths,
    curvatures,
    distance_to,
    headings,
    resample,
    value_at,
)

CORNER = np.array([(0.0, 0.0), (3.0, 0.0), (3.0, 4.0)])


def circle(radius, spacing=1.0, share=0.5):
    angles = np.arange(0.0, share * 2 * math.pi, spacing / radius)
    return radius * np.stack((np.cos(angles), np.sin(angles)), axis=1)


def test_arc_lengths():
    assert arc_lengths(CORNER).tolist() == [0.0, 3.0, 7.0]


def test_headings_repeat_the_last():
    np.testing.assert_allclose(headings(CORNER), [0.0, math.pi / 2, math.pi / 2])


def test_headings_are_unwrapped():
    assert np.abs(np.diff(headings(circle(5.0, share=0.95)))).max() < 0.5


def test_resample_keeps_the_ends_and_divides_the_length():
    points = resample(CORNER, 1.5)
    np.testing.assert_allclose(points[[0, -1]], CORNER[[0, -1]])
    np.testing.assert_allclose(np.diff(arc_lengths(points)), 1.4, atol=0.45)


@pytest.mark.parametrize(("turn", "sign"), [(1.0, 1.0), (-1.0, -1.0)])
def test_curvature_of_a_circle_is_positive_to_the_left(turn, sign):
    points = circle(10.0) * (1.0, turn)
    np.testing.assert_allclose(curvatures(points), sign / 10.0, rtol=1e-2)


def test_curvature_of_two_points_is_zero():
    assert curvatures(CORNER[:2]).tolist() == [0.0, 0.0]


def test_distance_to_the_inside_and_beyond_the_ends():
    assert distance_to(CORNER, 1.0, 2.0) == pytest.approx(2.0)
    assert distance_to(CORNER, -3.0, 4.0) == pytest.approx(5.0)
    assert distance_to(CORNER, 3.0, 5.0) == pytest.approx(1.0)


def test_cursor_follows_and_tells_the_side():
    cursor = Cursor(CORNER)
    cursor.advance(1.0, 0.5)
    assert (cursor.progress, cursor.offset, cursor.heading) == (1.0, 0.5, 0.0)
    cursor.advance(3.5, 2.0)
    assert (cursor.progress, cursor.offset) == (5.0, -0.5)
    assert cursor.heading == pytest.approx(math.pi / 2)


def test_cursor_never_goes_back():
    cursor = Cursor(CORNER)
    cursor.advance(2.0, 0.0)
    cursor.advance(1.0, 0.0)
    assert cursor.progress == 2.0


def test_cursor_stops_at_the_end():
    cursor = Cursor(CORNER)
    cursor.advance(3.1, 9.0)
    assert cursor.progress == cursor.length == 7.0


def test_cursor_goes_no_farther_than_asked():
    line = np.stack((np.arange(50.0), np.zeros(50)), axis=1)
    cursor = Cursor(line)
    cursor.advance(40.0, 0.0, most=8)
    assert cursor.index <= 9


def test_cursor_is_placed_forward_and_back():
    cursor = Cursor(CORNER)
    for at, index in ((6.0, 1), (1.0, 0), (99.0, 1), (-1.0, 0)):
        cursor.place(at)
        assert cursor.index == index
        assert cursor.progress == min(max(at, 0.0), 7.0)


def test_a_value_at_one_place_is_numpy_s_bit_for_bit():
    rng = np.random.default_rng(0)
    for count in (1, 2, 3, 200):
        along = np.cumsum(rng.uniform(0.01, 3.0, count))
        values = rng.normal(0.0, 1000.0, count)
        for at in [*rng.uniform(-5.0, along[-1] + 5.0, 200).tolist(), *along.tolist()]:
            assert value_at(at, along.tolist(), values.tolist()) == np.interp(at, along, values)
