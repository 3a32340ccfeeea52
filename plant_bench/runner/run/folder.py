"""The folder of a run: reads and writes one record per episode and the derived files.

run.json: versions and settings of the run (`Provenance`).
episodes/<route>_r<repetition>_<key>.json: an `EpisodeResult`, independent of the clock.
timing/<the same>.json: a `Timing`, all that depends on the clock.
recordings/<the same>.parquet: every tick, for rescoring and replays.
summary.json, summary.csv: derived from the records alone.
speed.json: derived from the timings.
superseded/: episodes of an earlier agent, town, route or protocol.
logs/: output of the workers, with the tracebacks of planners and of the simulator.
claims/: locks of the processes that write to the folder (`runner.run.run_lock`).
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


def sorted_results(results: Iterable[EpisodeResult]) -> list[EpisodeResult]:
    """Sort records by route and repetition, since floating-point sums depend on the order."""
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
            message = (
                f"{path} is not a run of plant-bench: it has no run.json. Give a folder written "
                "by `plant-bench score`."
            )
            raise InputError(message)
        return folder

    @property
    def planner_log(self) -> Path:
        """Path of the file for the traceback of a planner that cannot be loaded for the run."""
        return self.path / "logs" / "planner.log"

    @property
    def run_file(self) -> Path:
        """Path of the provenance file."""
        return self.path / "run.json"

    def create(self, *, partial_of: Sequence[str] | None = None) -> None:
        """Create the folder, and remove partly written files of an interrupted run.

        Args:
            partial_of: Names of the episodes whose partly written files are removed; None for
                all.

        Raises:
            InputError: It cannot be written to.
        """
        for name in (*_PARTS, "logs"):
            self.make_subfolder(name)
        self.remove_partial_files(partial_of)
        self.write("probe", "")
        (self.path / "probe").unlink(missing_ok=True)

    def remove_partial_files(self, names: Sequence[str] | None = None) -> None:
        """Remove the partly written files of killed workers.

        Args:
            names: Names of the episodes that only this process drives; None for all.
        """
        starts = None if names is None else tuple(f"{name}." for name in names)
        for leftover in (*self.path.glob(f"*{UNFINISHED}"), *self.path.glob(f"*/*{UNFINISHED}")):
            if starts is None or leftover.name.startswith(starts):
                leftover.unlink(missing_ok=True)

    def make_subfolder(self, name: str) -> None:
        """Create a sub-folder.

        Raises:
            InputError: It cannot be created.
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
        """Return the path of an episode's recording."""
        return self.path / "recordings" / f"{name}.parquet"

    def record(self, name: str) -> EpisodeResult | None:
        """Return an episode's record; None if it is missing or broken."""
        path = self.path / "episodes" / f"{name}.json"
        if not path.is_file():
            return None
        try:
            return EpisodeResult.load(path)
        except InputError:
            return None  # broken: the episode is driven again

    def save(self, name: str, result: EpisodeResult, timing: BaseModel | None) -> None:
        """Write an episode's files, each completely or not at all; the record last.

        Raises:
            InputError: The disk is full, or the folder is missing.
        """
        if timing is not None:
            self.write(f"timing/{name}.json", timing.model_dump_json(indent=1) + "\n")
        self.write(f"episodes/{name}.json", result.to_json())

    def remove_episodes(self, names: Iterable[str]) -> None:
        """Remove the files of episodes that are driven again."""
        for name in names:
            for part, suffix in _PARTS.items():
                (self.path / part / f"{name}{suffix}").unlink(missing_ok=True)

    def write(self, name: str, text: str) -> None:
        """Write a text file, completely or not at all.

        Raises:
            InputError: The disk is full, or the folder is missing.
        """
        self.write_bytes(name, text.encode())

    def write_bytes(self, name: str, content: bytes) -> None:
        """Write a file, completely or not at all, even if other processes write the same one.

        Raises:
            InputError: The disk is full, or the folder is missing.
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
        return sorted_results(EpisodeResult.load(path) for path in self.record_files())

    def repetitions(self) -> int:
        """Return the number of repetitions, from the names of the records."""
        names = [path.stem for path in self.record_files()]
        found = [re.search(r"_r(\d+)_[0-9a-f]+$", name) for name in names]
        return max((int(match[1]) + 1 for match in found if match), default=0)

    def move_superseded(self, current: Iterable[str]) -> int:
        """Move all episodes except the current ones to `superseded/`.

        Args:
            current: Names of the episodes to keep.

        Returns:
            Number of records moved.
        """
        current_names = set(current)
        superseded = [path.stem for path in self.record_files() if path.stem not in current_names]
        for name in superseded:
            for part, suffix in reversed(_PARTS.items()):  # the record last: it names the others
                source = self.path / part / f"{name}{suffix}"
                target = self.path / "superseded" / part / source.name
                if source.is_file():
                    target.parent.mkdir(parents=True, exist_ok=True)
                    with suppress(FileNotFoundError):  # already moved by another shard
                        move_whole(source, target)
        return len(superseded)

    def provenance(self) -> Provenance | None:
        """Return the provenance written by an earlier command; None in a new folder.

        Raises:
            InputError: The file is broken.
        """
        return Provenance.load(self.run_file) if self.run_file.is_file() else None
