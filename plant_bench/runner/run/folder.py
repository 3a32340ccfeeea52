"""The folder of one run: one record an episode, and all that is derived from the records.

run.json: what it was made with (`Provenance`).
episodes/<route>_r<repetition>_<key>.json: an `EpisodeResult`; nothing of it depends on the clock.
timing/<the same>.json: a `Timing`; all that depends on the clock.
recordings/<the same>.parquet: every tick, for rescoring and replays.
summary.json, summary.csv: derived from the records alone.
speed.json: derived from the timings.
superseded/: episodes of an earlier agent, town, route or protocol.
logs/: what the workers printed.
claims/: who is driving into it now (`runner.run.lock`).
"""

import re
from collections.abc import Iterable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from pydantic import BaseModel

from plant_bench.atomic_files import UNFINISHED, move_whole, write_whole
from plant_bench.errors import InputError
from plant_bench.runner.run.provenance import Provenance
from plant_bench.scoring.results import EpisodeResult

_PARTS = {"episodes": ".json", "timing": ".json", "recordings": ".parquet"}


def in_order(results: Iterable[EpisodeResult]) -> list[EpisodeResult]:
    """Return records by route and repetition: sums of their numbers depend on the order."""
    return sorted(results, key=lambda result: (result.route, result.repetition))


@dataclass(frozen=True)
class RunFolder:
    """A run on disk.

    Attributes:
        path: The folder.
    """

    path: Path

    @classmethod
    def open(cls, path: Path) -> "RunFolder":
        """Return the folder of a run that exists.

        Raises:
            InputError: There is none.
        """
        folder = cls(path)
        if not folder.run_file.is_file():
            message = f"{path} is no run of plant-bench: it has no run.json."
            raise InputError(message)
        return folder

    @property
    def run_file(self) -> Path:
        """Where the provenance lies."""
        return self.path / "run.json"

    def create(self, *, sweeping: Sequence[str] | None = None) -> None:
        """Make the folder, and clear away what an interrupted run left half written.

        Args:
            sweeping: As in `sweep`.

        Raises:
            InputError: It cannot be written to.
        """
        for name in (*_PARTS, "logs"):
            self.make(name)
        self.sweep(sweeping)
        self.write("probe", "")
        (self.path / "probe").unlink(missing_ok=True)

    def sweep(self, names: Sequence[str] | None = None) -> None:
        """Remove what killed workers left half written.

        Args:
            names: Of episodes that nobody else drives; None where nobody else drives any.
        """
        starts = None if names is None else tuple(f"{name}." for name in names)
        for leftover in (*self.path.glob(f"*{UNFINISHED}"), *self.path.glob(f"*/*{UNFINISHED}")):
            if starts is None or leftover.name.startswith(starts):
                leftover.unlink(missing_ok=True)

    def make(self, name: str) -> None:
        """Make a sub-folder.

        Raises:
            InputError: It cannot be made.
        """
        try:
            (self.path / name).mkdir(parents=True, exist_ok=True)
        except OSError as error:
            message = f"Cannot write to {self.path}: {error.strerror}. Choose another with --out."
            raise InputError(message) from error

    def record_files(self) -> list[Path]:
        """Return the paths of all records, by name."""
        return sorted((self.path / "episodes").glob("*.json"))

    def recording_path(self, name: str) -> Path:
        """Return where an episode's recording lies."""
        return self.path / "recordings" / f"{name}.parquet"

    def record(self, name: str) -> EpisodeResult | None:
        """Return an episode's record if it is there and whole."""
        path = self.path / "episodes" / f"{name}.json"
        if not path.is_file():
            return None
        try:
            return EpisodeResult.load(path)
        except InputError:
            return None  # broken: it is made again

    def save(self, name: str, result: EpisodeResult, timing: BaseModel | None) -> None:
        """Write an episode's files, each whole or not at all; the record last.

        Raises:
            InputError: The disk is full, or the folder has gone.
        """
        if timing is not None:
            self.write(f"timing/{name}.json", timing.model_dump_json(indent=1) + "\n")
        self.write(f"episodes/{name}.json", result.to_json())

    def forget(self, names: Iterable[str]) -> None:
        """Remove the files of episodes that are driven anew."""
        for name in names:
            for part, suffix in _PARTS.items():
                (self.path / part / f"{name}{suffix}").unlink(missing_ok=True)

    def write(self, name: str, text: str) -> None:
        """Write a text file, whole or not at all.

        Raises:
            InputError: The disk is full, or the folder has gone.
        """
        self.keep(name, text.encode())

    def keep(self, name: str, content: bytes) -> None:
        """Write a file, whole or not at all, also where others write the same one.

        Raises:
            InputError: The disk is full, or the folder has gone.
        """
        path = self.path / name
        try:
            write_whole(path, lambda part: part.write_bytes(content))
        except OSError as error:
            message = f"Cannot write {path}: {error.strerror}. Finished episodes are kept."
            raise InputError(message) from error

    def results(self) -> list[EpisodeResult]:
        """Return all records, by route and repetition.

        Raises:
            InputError: One is broken.
        """
        return in_order(EpisodeResult.load(path) for path in self.record_files())

    def repetitions(self) -> int:
        """Return how many repetitions the records' names speak of."""
        names = [path.stem for path in self.record_files()]
        found = [re.search(r"_r(\d+)_[0-9a-f]+$", name) for name in names]
        return max((int(match[1]) + 1 for match in found if match), default=0)

    def set_aside(self, keep: Iterable[str]) -> int:
        """Move all episodes but the named ones to `superseded/`.

        Returns:
            How many records were moved.
        """
        kept = set(keep)
        stale = [path.stem for path in self.record_files() if path.stem not in kept]
        for name in stale:
            for part, suffix in reversed(_PARTS.items()):  # the record last: it names the others
                source = self.path / part / f"{name}{suffix}"
                target = self.path / "superseded" / part / source.name
                if source.is_file():
                    target.parent.mkdir(parents=True, exist_ok=True)
                    with suppress(FileNotFoundError):  # another shard has done it
                        move_whole(source, target)
        return len(stale)

    def provenance(self) -> Provenance | None:
        """Return what an earlier command noted here, None in a new folder.

        Raises:
            InputError: The note is broken.
        """
        return Provenance.load(self.run_file) if self.run_file.is_file() else None
