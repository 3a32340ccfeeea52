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


def test_arc_lengths_accumulate_the_segments():
    assert arc_lengths(CORNER).tolist() == [0.0, 3.0, 7.0]


def test_last_heading_is_repeated():
    np.testing.assert_allclose(headings(CORNER), [0.0, math.pi / 2, math.pi / 2])


def test_headings_are_unwrapped():
    assert np.abs(np.diff(headings(circle(5.0, share=0.95)))).max() < 0.5


def test_resampling_keeps_the_ends_and_divides_the_length():
    points = resample(CORNER, 1.5)
    np.testing.assert_allclose(points[[0, -1]], CORNER[[0, -1]])
    np.testing.assert_allclose(np.diff(arc_lengths(points)), 1.4, atol=0.45)


@pytest.mark.parametrize(("turn", "sign"), [(1.0, 1.0), (-1.0, -1.0)])
def test_curvature_of_a_circle_is_positive_to_the_left(turn, sign):
    points = circle(10.0) * (1.0, turn)
    np.testing.assert_allclose(curvatures(points), sign / 10.0, rtol=1e-2)


def test_curvature_of_two_points_is_zero():
    assert curvatures(CORNER[:2]).tolist() == [0.0, 0.0]


def test_distance_along_the_line_and_past_its_ends():
    assert distance_to(CORNER, 1.0, 2.0) == pytest.approx(2.0)
    assert distance_to(CORNER, -3.0, 4.0) == pytest.approx(5.0)
    assert distance_to(CORNER, 3.0, 5.0) == pytest.approx(1.0)


def test_cursor_follows_the_line_and_signs_the_offset():
    cursor = Cursor(CORNER)
    cursor.advance(1.0, 0.5)
    assert (cursor.progress, cursor.offset, cursor.heading) == (1.0, 0.5, 0.0)
    cursor.advance(3.5, 2.0)
    assert (cursor.progress, cursor.offset) == (5.0, -0.5)
    assert cursor.heading == pytest.approx(math.pi / 2)


def test_cursor_does_not_move_backwards():
    cursor = Cursor(CORNER)
    cursor.advance(2.0, 0.0)
    cursor.advance(1.0, 0.0)
    assert cursor.progress == 2.0


def test_cursor_stops_at_the_end():
    cursor = Cursor(CORNER)
    cursor.advance(3.1, 9.0)
    assert cursor.progress == cursor.length == 7.0


def test_cursor_advances_at_most_the_given_number_of_points():
    line = np.stack((np.arange(50.0), np.zeros(50)), axis=1)
    cursor = Cursor(line)
    cursor.advance(40.0, 0.0, most=8)
    assert cursor.index <= 9


def test_cursor_can_be_placed_anywhere_on_the_line():
    cursor = Cursor(CORNER)
    for at, index in ((6.0, 1), (1.0, 0), (99.0, 1), (-1.0, 0)):
        cursor.place(at)
        assert cursor.index == index
        assert cursor.progress == min(max(at, 0.0), 7.0)


def test_interpolated_value_equals_numpy_bit_for_bit():
    rng = np.random.default_rng(0)
    for count in (1, 2, 3, 200):
        along = np.cumsum(rng.uniform(0.01, 3.0, count))
        values = rng.normal(0.0, 1000.0, count)
        for at in [*rng.uniform(-5.0, along[-1] + 5.0, 200).tolist(), *along.tolist()]:
            assert value_at(at, along.tolist(), values.tolist()) == np.interp(at, along, values)
