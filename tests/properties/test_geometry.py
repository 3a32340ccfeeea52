import math

import numpy as np
import shapely
from hypothesis import assume, given
from hypothesis import strategies as st

from plant_bench.agents.careful.box_overlaps import overlapping
from plant_bench.geometry.box import corners, overlap, overlap_one
from plant_bench.geometry.polyline import Cursor, arc_lengths, distance_to, resample
from plant_bench.geometry.pose import from_frame, to_frame, wrap_angle
from plant_bench.scoring.collisions import overlapping_actors
from plant_bench.world.scene import EGO_EXTENT, EgoState
from tests.builders import make_actors

metres = st.floats(-500.0, 500.0)
angles = st.floats(-10.0, 10.0)
poses = st.tuples(st.floats(-8.0, 8.0), st.floats(-8.0, 8.0), angles)
extents = st.tuples(st.floats(0.3, 12.0), st.floats(0.3, 3.0))
clouds = st.lists(st.tuples(metres, metres), min_size=1, max_size=9).map(np.array)


@given(clouds, metres, metres, angles)
def test_to_frame_and_from_frame_are_inverse(points, x, y, yaw):
    there = to_frame(points, x, y, yaw)
    np.testing.assert_allclose(from_frame(there, x, y, yaw), points, atol=1e-9)
    np.testing.assert_allclose(
        np.hypot(*there.T), np.hypot(points[:, 0] - x, points[:, 1] - y), atol=1e-9
    )


@given(st.floats(-1e3, 1e3))
def test_wrapping_an_angle_keeps_its_direction(angle):
    wrapped = wrap_angle(angle)
    assert -math.pi <= wrapped < math.pi
    assert math.isclose(math.cos(wrapped), math.cos(angle), abs_tol=1e-9)
    assert math.isclose(math.sin(wrapped), math.sin(angle), abs_tol=1e-9)


@given(poses, extents, poses, extents)
def test_box_overlap_agrees_with_polygon_intersection(pose_a, extent_a, pose_b, extent_b):
    a, b = np.array([pose_a]), np.array([pose_b])
    size_a, size_b = np.array([extent_a]), np.array([extent_b])
    polygon_a = shapely.Polygon(corners(a, size_a)[0])
    polygon_b = shapely.Polygon(corners(b, size_b)[0])
    common = polygon_a.intersection(polygon_b).area
    gap = polygon_a.distance(polygon_b)
    assume(common > 1e-6 or gap > 1e-6)
    expected = [common > 1e-6]
    assert overlap(a, size_a, b, size_b).tolist() == expected
    assert overlap_one(pose_a, extent_a, b, size_b).tolist() == expected
    assert overlapping(*pose_a, *extent_a, *pose_b, *extent_b) == expected[0]


@given(poses, st.lists(st.tuples(poses, extents), max_size=6))
def test_referee_finds_the_same_overlaps(pose, others):
    seen = np.array([other for other, _ in others], np.float32).reshape(-1, 3)
    sizes = np.array([size for _, size in others], np.float32).reshape(-1, 2)
    actors = make_actors(seen, extents=sizes)
    exact = overlap_one(pose, EGO_EXTENT, seen.astype(float), sizes.astype(float))
    for index in np.flatnonzero(exact):
        grown = sizes.astype(float)[[index]] + 1e-6
        shrunk = sizes.astype(float)[[index]] - 1e-6
        near = seen.astype(float)[[index]]
        assume(
            overlap_one(pose, EGO_EXTENT, near, grown)
            == overlap_one(pose, EGO_EXTENT, near, shrunk)
        )
    assert overlapping_actors(EgoState(*pose, speed=0.0), actors) == np.flatnonzero(exact).tolist()


@st.composite
def lines(draw):
    """A line that turns by less than 40 degrees at each point, as roads do."""
    turns = draw(st.lists(st.floats(-0.7, 0.7), min_size=1, max_size=30))
    heading = np.cumsum(turns)
    return np.cumsum(np.stack((np.cos(heading), np.sin(heading)), axis=1), axis=0)


@given(lines())
def test_cursor_on_the_line_returns_its_arc_length(points):
    assume(len(points) > 1)
    cursor = Cursor(points)
    for point, along in zip(points, arc_lengths(points), strict=True):
        cursor.advance(*point.tolist())
        assert math.isclose(cursor.progress, along, abs_tol=1e-9)
        assert abs(cursor.offset) < 1e-9


@given(lines(), st.lists(st.tuples(metres, metres), max_size=20))
def test_cursor_moves_neither_backwards_nor_past_the_end(points, places):
    assume(len(points) > 1)
    cursor = Cursor(points)
    before = 0.0
    for place in places:
        cursor.advance(*place)
        assert before <= cursor.progress <= cursor.length
        before = cursor.progress


@given(lines(), metres, metres)
def test_distance_equals_shapely(points, x, y):
    assume(len(points) > 1)
    expected = shapely.LineString(points).distance(shapely.Point(x, y))
    assert math.isclose(distance_to(points, x, y), expected, abs_tol=1e-6)


@given(lines(), st.floats(0.2, 5.0))
def test_resampled_points_lie_on_the_line(points, spacing):
    assume(len(points) > 1)
    found = resample(points, spacing)
    np.testing.assert_allclose(found[[0, -1]], points[[0, -1]], atol=1e-9)
    assert all(distance_to(points, *point.tolist()) < 1e-6 for point in found)
