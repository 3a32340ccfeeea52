import math

import numpy as np
import pytest

from plant_bench.geometry.box import corners, overlap, overlap_one

CAR = np.array([[4.0, 2.0]])


def boxes(*poses):
    return np.array(poses, dtype=float)


def test_corners_run_counter_clockwise_from_front_left():
    found = corners(boxes((1.0, 2.0, 0.0)), CAR)[0]
    np.testing.assert_allclose(found, [(3, 3), (-1, 3), (-1, 1), (3, 1)])


def test_corners_turn_with_the_box():
    found = corners(boxes((0.0, 0.0, math.pi / 2)), CAR)[0]
    np.testing.assert_allclose(found, [(-1, 2), (-1, -2), (1, -2), (1, 2)], atol=1e-12)


@pytest.mark.parametrize(
    ("pose", "expected"),
    [
        ((3.99, 0.0, 0.0), True),
        ((4.0, 0.0, 0.0), False),
        ((0.0, 1.99, 0.0), True),
        ((0.0, 2.0, 0.0), False),
        ((2.99, 0.0, math.pi / 2), True),
        ((3.01, 0.0, math.pi / 2), False),
        ((3.2, 2.2, math.pi / 4), True),
        ((3.2, 2.6, -math.pi / 4), False),
        ((0.0, 0.0, 1.0), True),
    ],
)
def test_overlap_of_two_boxes_is_symmetric(pose, expected):
    one = boxes((0.0, 0.0, 0.0))
    assert overlap(one, CAR, boxes(pose), CAR).tolist() == [expected]
    assert overlap(boxes(pose), CAR, one, CAR).tolist() == [expected]
    assert overlap_one((0.0, 0.0, 0.0), (4.0, 2.0), boxes(pose), CAR).tolist() == [expected]


def test_overlap_with_no_boxes_is_empty():
    assert overlap_one((0.0, 0.0, 0.0), (4.0, 2.0), np.zeros((0, 3)), np.zeros((0, 2))).size == 0
