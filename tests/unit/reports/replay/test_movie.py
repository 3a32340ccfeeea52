import sys
from pathlib import Path

import numpy as np
import pytest
from PIL import Image, ImageSequence

from plant_bench.agent import NO_ACTOR
from plant_bench.data.recording import Recording
from plant_bench.errors import InputError
from plant_bench.reports.replay.movie import SAVERS, MovieRequest
from plant_bench.reports.replay.replay_episode import load_episode
from plant_bench.reports.replay.snapshots import snapshot_at
from tests.unit.reports.replay.drives import HIT_AT, SPEED, drive


@pytest.fixture
def episode(source):
    return load_episode(source)


def quiet(done: int, count: int) -> None:
    assert 0 < done <= count


def pixels(path: Path) -> np.ndarray:
    with Image.open(path) as image:
        return np.asarray(image.convert("RGB")).astype(int)


def test_moments_are_recorded_or_interpolated_between_frames(source, episode):
    recording = Recording.load(source.recording)
    moment = snapshot_at(episode, 2.0)
    scene = recording[40]
    np.testing.assert_allclose(moment.ego[:2], (scene.ego.x, scene.ego.y), atol=1e-6)
    np.testing.assert_array_equal(moment.ids, scene.actors.ids)
    np.testing.assert_allclose(moment.poses[:, :2], scene.actors.poses[:, :2], atol=1e-4)
    between = snapshot_at(episode, 2.05).poses[:, :2]
    np.testing.assert_allclose(between, recording[41].actors.poses[:, :2], atol=0.02)
    yaw = scene.ego.yaw
    ahead = np.array([np.cos(yaw), np.sin(yaw)]) * SPEED / 2 + 0.2 * np.array(
        [-np.sin(yaw), np.cos(yaw)]
    )
    np.testing.assert_allclose(moment.plan[0], (scene.ego.x, scene.ego.y) + ahead, atol=1e-6)
    assert moment.brakes_for == NO_ACTOR


def test_moment_names_the_actor_braked_for(tmp_path):
    moment = snapshot_at(load_episode(drive(tmp_path, plans=False)), 1.0)
    assert (moment.brakes_for, moment.reason) == (1, "leader")
    assert len(moment.plan) == 0


def test_picture_is_centred_on_the_ego_at_the_first_infraction(tmp_path, episode):
    path = tmp_path / "a.png"
    SAVERS["png"]([episode], MovieRequest(), path, quiet)
    image = pixels(path)
    middle = image[image.shape[0] // 2 - 6 : image.shape[0] // 2 + 6, 470:490].reshape(-1, 3)
    assert ((middle - (255, 210, 31)) ** 2).sum(axis=1).min() < 30, "the yellow of the ego"
    assert MovieRequest().moments([episode]) == [HIT_AT]
    SAVERS["png"]([episode], MovieRequest(dark=True), path, quiet)
    assert pixels(path).mean() < image.mean() - 40


def test_picture_of_a_time_span_is_a_strip_with_a_row_per_run(tmp_path, episode, monkeypatch):
    monkeypatch.setattr("plant_bench.reports.replay.movie.STRIP", 3)
    one, two = tmp_path / "one.png", tmp_path / "two.png"
    SAVERS["png"]([episode], MovieRequest(start=0.0, end=4.0), one, quiet)
    SAVERS["png"]([episode, episode], MovieRequest(start=0.0, end=4.0), two, quiet)
    strip, rows = pixels(one).shape, pixels(two).shape
    assert strip[1] > 3 * strip[0]
    assert rows[1] == strip[1]
    assert rows[0] > 1.9 * strip[0]


def test_gif_has_the_frames_of_its_time_span(tmp_path, episode):
    path = tmp_path / "a.gif"
    SAVERS["gif"]([episode], MovieRequest(start=1.0, end=1.6, fps=5.0), path, quiet)
    with Image.open(path) as image:
        assert len(list(ImageSequence.Iterator(image))) == 3
        assert image.info["duration"] == 200


def test_mp4_is_written_as_a_valid_file(tmp_path, episode):
    pytest.importorskip("imageio_ffmpeg")
    path = tmp_path / "a.mp4"
    SAVERS["mp4"]([episode], MovieRequest(start=1.0, end=1.4, fps=5.0), path, quiet)
    assert path.read_bytes()[4:8] == b"ftyp"
    assert [item.name for item in tmp_path.glob("a.*")] == ["a.mp4"]


def test_missing_video_extra_says_what_to_install(tmp_path, episode, monkeypatch):
    monkeypatch.setitem(sys.modules, "imageio_ffmpeg", None)
    with pytest.raises(InputError, match=r"pip install '\.\[video\]' in a checkout"):
        SAVERS["mp4"]([episode], MovieRequest(), tmp_path / "a.mp4", quiet)


def test_an_episode_without_length_has_no_part():
    with pytest.raises(InputError, match="only one scene: the episode ended at once"):
        MovieRequest().part(0.0)


@pytest.mark.parametrize(
    ("kind", "wanted", "words"),
    [
        ("png", MovieRequest(time=99.0), "--time 99"),
        ("gif", MovieRequest(start=3.0, end=2.0), "From 3 to 2 s is empty"),
        ("gif", MovieRequest(fps=0.1), "--fps 0.1"),
        ("gif", MovieRequest(start=-1.0), "From -1"),
    ],
)
def test_times_outside_the_recording_are_refused(tmp_path, episode, kind, wanted, words):
    with pytest.raises(InputError, match=words):
        SAVERS[kind]([episode], wanted, tmp_path / "a", quiet)


def test_a_gif_that_is_too_long_is_refused(tmp_path, monkeypatch, episode):
    monkeypatch.setattr("plant_bench.reports.replay.movie.MOST_GIF", 30)
    with pytest.raises(InputError, match="too long: expected at most 30"):
        SAVERS["gif"]([episode], MovieRequest(), tmp_path / "a.gif", quiet)
