import math

import numpy as np
import pytest

from plant_bench.geometry.pose import from_frame, to_frame, wrap_angle, wrap_angles


@pytest.mark.parametrize(
    ("angle", "expected"),
    [(0.0, 0.0), (math.pi, -math.pi), (-math.pi, -math.pi), (7.0, 7.0 - 2 * math.pi)],
)
def test_wrap_angle_maps_to_plus_minus_pi(angle, expected):
    assert wrap_angle(angle) == pytest.approx(expected)
    assert wrap_angles(np.array([angle]))[0] == pytest.approx(expected)


def test_to_frame_has_x_forward_and_y_left():
    ahead_and_left = np.array([[10.0, 25.0], [8.0, 20.0]])
    np.testing.assert_allclose(
        to_frame(ahead_and_left, 10.0, 20.0, math.pi / 2), [[5.0, 0.0], [0.0, 2.0]], atol=1e-12
    )


def test_from_frame_returns_world_coordinates():
    np.testing.assert_allclose(
        from_frame(np.array([[5.0, 2.0]]), 10.0, 20.0, math.pi / 2), [[8.0, 25.0]]
    )
