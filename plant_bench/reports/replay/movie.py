"""Exports replays as a PNG image, an animated GIF or an MP4 video."""

import os
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from PIL import Image

from plant_bench.atomic_files import whole_file
from plant_bench.errors import InputError
from plant_bench.reports.replay.image_layout import SceneGrid
from plant_bench.reports.replay.replay_episode import EpisodeReplay

STRIP = 5  # moments in a strip
MOST_GIF = 600  # frames: more would take hundreds of megabytes
COLOURS = 128  # in the palette of a GIF
USUAL_FPS = {"gif": 10.0, "mp4": 20.0}
VIDEO_EXTRA = ".[video]"

ProgressCallback = Callable[[int, int], None]


@dataclass(frozen=True)
class MovieRequest:
    """Which part of an episode to export, and how.

    Attributes:
        time: Moment of an image, seconds; None for the first infraction, or the middle.
        start: Start of the part, seconds; None for the start of the episode.
        end: End of the part, seconds; None for the end of the episode.
        fps: Frames per second; None for `USUAL_FPS`.
        dark: Whether to use dark colours.
    """

    time: float | None = None
    start: float | None = None
    end: float | None = None
    fps: float | None = None
    dark: bool = False

    def check(self, duration: float) -> None:
        """Check all numbers against the duration of an episode, before the episode is read.

        Raises:
            InputError: A number is out of range.
        """
        self.rate("gif")
        self._moment(self.part(duration)[1])

    def times(self, episodes: Sequence[EpisodeReplay], kind: str) -> list[float]:
        """Return the moments of a GIF or MP4.

        Raises:
            InputError: The part is empty or outside the episode, or `fps` is out of range.
        """
        first, last = self.part(_duration(episodes))
        fps = self.rate(kind)
        return [first + number / fps for number in range(max(1, round((last - first) * fps)))]

    def rate(self, kind: str) -> float:
        """Return the frames per second of a GIF or MP4.

        Raises:
            InputError: `fps` is out of range.
        """
        fps = USUAL_FPS[kind] if self.fps is None else self.fps
        if not 1.0 <= fps <= 60.0:
            message = f"--fps {fps:g}: expected 1 to 60."
            raise InputError(message)
        return fps

    def part(self, duration: float) -> tuple[float, float]:
        """Return start and end of the requested part of an episode, seconds.

        Raises:
            InputError: It is empty, or outside the episode, or the episode has no length.
        """
        if duration == 0.0:
            message = "The recording has only one scene: the episode ended at once."
            raise InputError(message)
        first = self.start or 0.0
        last = duration if self.end is None else min(self.end, duration)
        if not 0.0 <= first < last:
            message = (
                f"From {first:g} to {last:g} s is empty: expected --from below --to, both within "
                f"the {duration:.1f} s of the episode."
            )
            raise InputError(message)
        return first, last

    def moments(self, episodes: Sequence[EpisodeReplay]) -> list[float]:
        """Return the moments of an image: one, or a strip of a part.

        Raises:
            InputError: They are outside the episode.
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
            message = f"--time {self.time:g}: expected 0 to {last:.1f} s."
            raise InputError(message)
        return self.time


def check_path(kind: str, path: Path) -> None:
    """Check the path of an output file, before the output is computed.

    Args:
        kind: A key of `SAVERS`.
        path: The path.

    Raises:
        InputError: The name has the wrong ending, or the file cannot be created.
    """
    if path.suffix.lower() != f".{kind}":
        message = f"--{kind} {path}: expected a file name that ends with .{kind}."
        raise InputError(message)
    if path.is_dir():
        message = f"--{kind} {path}: this is a folder. Give the path of a file."
        raise InputError(message)
    check_folder(path.parent)


def check_folder(folder: Path) -> None:
    """Check that files can be written into a folder, which need not exist yet.

    Raises:
        InputError: They cannot be written.
    """
    existing = next(item for item in (folder, *folder.absolute().parents) if item.exists())
    if not existing.is_dir() or not os.access(existing, os.W_OK):
        what = "is not writable" if existing.is_dir() else "is not a folder"
        message = f"Cannot write into {folder}: {existing} {what}. Choose another folder."
        raise InputError(message)


def _duration(episodes: Sequence[EpisodeReplay]) -> float:
    """Return the duration of the longest episode, seconds."""
    return max(episode.frames.duration for episode in episodes)


def save_png(
    episodes: Sequence[EpisodeReplay], request: MovieRequest, path: Path, progress: ProgressCallback
) -> None:
    """Write one image: a row per episode, a column per moment.

    Raises:
        InputError: The moment is outside the episode, or the file cannot be written.
    """
    times = request.moments(episodes)
    pixels = SceneGrid(episodes, len(times), dark=request.dark).draw(times)
    with _whole(path) as part:
        Image.fromarray(pixels).save(part, format="PNG", optimize=True)
    progress(1, 1)


def save_gif(
    episodes: Sequence[EpisodeReplay], request: MovieRequest, path: Path, progress: ProgressCallback
) -> None:
    """Write a looping GIF.

    Raises:
        InputError: It would be too long, or cannot be written.
    """
    times = request.times(episodes, "gif")
    if len(times) > MOST_GIF:
        message = (
            f"A GIF of {len(times)} frames is too long: expected at most {MOST_GIF}. Choose a part "
            "with --from and --to, a lower --fps, or --mp4."
        )
        raise InputError(message)
    pictures = (
        Image.fromarray(pixels).quantize(COLOURS, dither=Image.Dither.NONE)
        for pixels in _pictures(episodes, times, progress, dark=request.dark)
    )
    first = next(pictures)
    with _whole(path) as part, part.open("wb") as file:  # Pillow leaves its own open on Ctrl-C
        first.save(
            file,
            format="GIF",
            save_all=True,
            append_images=pictures,
            duration=round(1000.0 / request.rate("gif")),
            loop=0,
        )


def save_mp4(
    episodes: Sequence[EpisodeReplay], request: MovieRequest, path: Path, progress: ProgressCallback
) -> None:
    """Write an MP4 (H.264), the most widely supported video format.

    Raises:
        InputError: imageio-ffmpeg is not installed, or the file cannot be written.
    """
    try:
        import imageio_ffmpeg
    except ImportError as error:
        message = (
            "An MP4 needs imageio-ffmpeg, which is not installed: pip install "
            f"'{VIDEO_EXTRA}' in a checkout of plant-bench. --gif does not need it."
        )
        raise InputError(message) from error
    pictures = _pictures(episodes, request.times(episodes, "mp4"), progress, dark=request.dark)
    first = next(pictures)
    height, width = first.shape[:2]
    with _whole(path) as part:
        writer = imageio_ffmpeg.write_frames(
            str(part),
            (width, height),
            fps=request.rate("mp4"),  # pyright: ignore[reportArgumentType]  fractions work
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


SAVERS: dict[
    str, Callable[[Sequence[EpisodeReplay], MovieRequest, Path, ProgressCallback], None]
] = {
    "png": save_png,
    "gif": save_gif,
    "mp4": save_mp4,
}


def _pictures(
    episodes: Sequence[EpisodeReplay], times: list[float], progress: ProgressCallback, *, dark: bool
) -> Iterator[np.ndarray]:
    panels = SceneGrid(episodes, 1, dark=dark)
    for number, seconds in enumerate(times, start=1):
        yield panels.draw([seconds])
        progress(number, len(times))


@contextmanager
def _whole(path: Path) -> Iterator[Path]:
    """Yield a temporary path; the file is moved to its final path when complete."""
    try:
        with whole_file(path) as part:
            yield part
    except OSError as error:
        message = f"Cannot write {path}: {error.strerror or error}. Choose another path."
        raise InputError(message) from error
