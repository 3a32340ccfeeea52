"""Replays as files to show around: a PNG of one moment or a strip of some, a GIF, an MP4."""

import os
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from PIL import Image

from plant_bench.atomic_files import whole_file
from plant_bench.errors import InputError
from plant_bench.reports.replay.image_layout import Panels
from plant_bench.reports.replay.replay_episode import EpisodeReplay

STRIP = 5  # moments of a strip
MOST_GIF = 600  # pictures: more would take hundreds of megabytes
COLOURS = 128  # of a GIF
USUAL_FPS = {"gif": 10.0, "mp4": 20.0}
VIDEO_PARTS = "plant-bench[video]"

Told = Callable[[int, int], None]


@dataclass(frozen=True)
class MovieRequest:
    """What is to be shown of an episode.

    Attributes:
        time: The moment of a picture, seconds; None for the first infraction, or the middle.
        start: First second of a part, None for the start.
        end: Last second of a part, None for the end.
        fps: Pictures a second, None for what is usual.
        dark: In dark colours.
    """

    time: float | None = None
    start: float | None = None
    end: float | None = None
    fps: float | None = None
    dark: bool = False

    def check(self, duration: float) -> None:
        """Check all numbers, before an episode of so many seconds is read.

        Raises:
            InputError: One of them is out of range.
        """
        self.rate("gif")
        self._moment(self.part(duration)[1])

    def times(self, episodes: Sequence[EpisodeReplay], kind: str) -> list[float]:
        """Return the moments of a GIF or MP4.

        Raises:
            InputError: The part is empty or outside of the episode, or there are too few or too
                many pictures a second.
        """
        first, last = self.part(_duration(episodes))
        fps = self.rate(kind)
        return [first + number / fps for number in range(max(1, round((last - first) * fps)))]

    def rate(self, kind: str) -> float:
        """Return how many pictures a second a GIF or MP4 has.

        Raises:
            InputError: There are too few or too many.
        """
        fps = USUAL_FPS[kind] if self.fps is None else self.fps
        if not 1.0 <= fps <= 60.0:
            message = f"--fps {fps:g}: 1 to 60 is wanted."
            raise InputError(message)
        return fps

    def part(self, duration: float) -> tuple[float, float]:
        """Return the bounds of the part that is wanted of an episode, seconds.

        Raises:
            InputError: It is empty, or outside of the episode.
        """
        first = self.start or 0.0
        last = duration if self.end is None else min(self.end, duration)
        if not 0.0 <= first < last:
            message = (
                f"From {first:g} to {last:g} s is nothing: --from and --to are wanted in order, "
                f"within the {duration:.1f} s of the episode."
            )
            raise InputError(message)
        return first, last

    def moments(self, episodes: Sequence[EpisodeReplay]) -> list[float]:
        """Return the moments of a picture: one, or a strip of a part.

        Raises:
            InputError: They are outside of the episode.
        """
        first, last = self.part(_duration(episodes))
        moment = self._moment(last)
        if moment is not None:
            return [moment]
        if self.start is not None or self.end is not None:
            return np.linspace(first, last, STRIP).tolist()
        infractions = episodes[0].source.result.infractions
        return [infractions[0].time if infractions else last / 2.0]

    def _moment(self, last: float) -> float | None:
        if self.time is not None and not 0.0 <= self.time <= last:
            message = f"--time {self.time:g}: a moment from 0 to {last:.1f} s is wanted."
            raise InputError(message)
        return self.time


def check_path(kind: str, path: Path) -> None:
    """Check where a file is to be written, before there is anything to write.

    Args:
        kind: Of `SAVERS`.
        path: Of the file.

    Raises:
        InputError: The name does not end as such files' names do, or no file can be there.
    """
    if path.suffix.lower() != f".{kind}":
        message = f"--{kind} {path}: a file whose name ends with .{kind} is wanted."
        raise InputError(message)
    if path.is_dir():
        message = f"--{kind} {path}: that is a folder. Give the path of a file in it."
        raise InputError(message)
    check_folder(path.parent)


def check_folder(folder: Path) -> None:
    """Check that files can be written into a folder, which need not be there yet.

    Raises:
        InputError: They cannot.
    """
    there = next(item for item in (folder, *folder.absolute().parents) if item.exists())
    if not there.is_dir() or not os.access(there, os.W_OK):
        what = "may not be written to" if there.is_dir() else "is no folder"
        message = f"Cannot write into {folder}: {there} {what}. Choose another place."
        raise InputError(message)


def _duration(episodes: Sequence[EpisodeReplay]) -> float:
    """Return the seconds of the longest."""
    return max(episode.frames.duration for episode in episodes)


def save_png(
    episodes: Sequence[EpisodeReplay], wanted: MovieRequest, path: Path, told: Told
) -> None:
    """Write one picture: a row an episode, a column a moment.

    Raises:
        InputError: The moment is outside of the episode, or the file cannot be written.
    """
    times = wanted.moments(episodes)
    pixels = Panels(episodes, len(times), dark=wanted.dark).draw(times)
    with _whole(path) as part:
        Image.fromarray(pixels).save(part, format="PNG", optimize=True)
    told(1, 1)


def save_gif(
    episodes: Sequence[EpisodeReplay], wanted: MovieRequest, path: Path, told: Told
) -> None:
    """Write a GIF, which repeats.

    Raises:
        InputError: It would be too long, or cannot be written.
    """
    times = wanted.times(episodes, "gif")
    if len(times) > MOST_GIF:
        message = (
            f"A GIF of {len(times)} pictures is too long: up to {MOST_GIF} are written. Choose a "
            "part with --from and --to, fewer with --fps, or --mp4."
        )
        raise InputError(message)
    pictures = (
        Image.fromarray(pixels).quantize(COLOURS, dither=Image.Dither.NONE)
        for pixels in _pictures(episodes, times, told, dark=wanted.dark)
    )
    first = next(pictures)
    with _whole(path) as part, part.open("wb") as file:  # Pillow leaves its own open on Ctrl-C
        first.save(
            file,
            format="GIF",
            save_all=True,
            append_images=pictures,
            duration=round(1000.0 / wanted.rate("gif")),
            loop=0,
        )


def save_mp4(
    episodes: Sequence[EpisodeReplay], wanted: MovieRequest, path: Path, told: Told
) -> None:
    """Write an MP4 (H.264), which all browsers and slides play.

    Raises:
        InputError: imageio-ffmpeg is not installed, or the file cannot be written.
    """
    try:
        import imageio_ffmpeg
    except ImportError as error:
        message = (
            "An MP4 needs imageio-ffmpeg, which is not installed: pip install "
            f"'{VIDEO_PARTS}'. --gif does without."
        )
        raise InputError(message) from error
    pictures = _pictures(episodes, wanted.times(episodes, "mp4"), told, dark=wanted.dark)
    first = next(pictures)
    height, width = first.shape[:2]
    with _whole(path) as part:
        writer = imageio_ffmpeg.write_frames(
            str(part),
            (width, height),
            fps=wanted.rate("mp4"),  # pyright: ignore[reportArgumentType]  fractions work
            codec="libx264",
            macro_block_size=2,
            output_params=["-f", "mp4", "-crf", "20", "-movflags", "+faststart"],
        )
        writer.send(None)
        try:
            writer.send(first.tobytes())
            for pixels in pictures:
                writer.send(pixels.tobytes())
        finally:
            writer.close()


SAVERS: dict[str, Callable[[Sequence[EpisodeReplay], MovieRequest, Path, Told], None]] = {
    "png": save_png,
    "gif": save_gif,
    "mp4": save_mp4,
}


def _pictures(
    episodes: Sequence[EpisodeReplay], times: list[float], told: Told, *, dark: bool
) -> Iterator[np.ndarray]:
    panels = Panels(episodes, 1, dark=dark)
    for number, seconds in enumerate(times, start=1):
        yield panels.draw([seconds])
        told(number, len(times))


@contextmanager
def _whole(path: Path) -> Iterator[Path]:
    """Give where to write a file that appears under its name whole or not at all."""
    try:
        with whole_file(path) as part:
            yield part
    except OSError as error:
        message = f"Cannot write {path}: {error.strerror or error}. Choose another place."
        raise InputError(message) from error
