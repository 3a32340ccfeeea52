import numpy as np

from plant_bench.data.recording import Recording
from plant_bench.reports.replay.replay_frames import FRAME, frames_of


def test_frames_hold_the_recorded_scenes(source):
    recording = Recording.load(source.recording)
    frames = frames_of(recording)
    assert len(frames) == 41
    assert frames.duration == 4.0
    row = 25
    scene = recording[row * 2]
    tracks = frames.tracks
    here = (tracks.first <= row) & (row < tracks.first + np.diff(tracks.starts))
    np.testing.assert_array_equal(tracks.ids[here], scene.actors.ids)
    poses = tracks.poses[tracks.starts[:-1][here] + row - tracks.first[here]]
    np.testing.assert_allclose(poses[:, :2], scene.actors.poses[:, :2])
    np.testing.assert_allclose(np.exp(1j * poses[:, 2]), np.exp(1j * scene.actors.poses[:, 2]))
    np.testing.assert_array_equal(frames.lights[row], scene.lights)


def test_actor_that_reappears_has_two_separate_trajectories(source):
    tracks = frames_of(Recording.load(source.recording)).tracks
    mine = np.flatnonzero(tracks.ids == 2)
    spans = [(int(tracks.first[row]), int(np.diff(tracks.starts)[row])) for row in mine]
    assert spans == [(0, 10), (20, 21)]


def test_headings_are_interpolated_the_short_way(source):
    tracks = frames_of(Recording.load(source.recording)).tracks
    steps = np.abs(np.diff(tracks.poses[:, 2]))
    steps = np.delete(steps, tracks.starts[1:-1] - 1)
    assert steps.max() < 0.3
    assert FRAME == 0.1
