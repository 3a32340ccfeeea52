"""Finds and reads a leaderboard's sources: runs, RFDS of rankings, CARLA checkpoint files."""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

from pydantic import TypeAdapter

from plant_bench.errors import InputError, in_one_line
from plant_bench.runner.run.folder import RunFolder
from plant_bench.runner.run.previous_version import previous_folder, previous_records
from plant_bench.runner.run.provenance import Provenance
from plant_bench.scoring.relevance import RelativeScore
from plant_bench.scoring.results import EpisodeResult
from plant_bench.untrusted_files import read_json

RANKING_FILE = "rfds.json"
# Files in the folders of leaderboards, replays, trainings and ablations:
_OTHER_OUTPUT = ("leaderboard.html", "replay.html", "losses.csv", "ablations.md")
LARGEST_WHOLE = 2**63 - 1  # largest value of an integer column


@dataclass(frozen=True)
class Episode:
    """One episode of a run.

    Attributes:
        name: Stem of its files' names.
        result: Its record.
        recording: Path of its recording; None if it has none.
    """

    name: str
    result: EpisodeResult
    recording: Path | None


@dataclass(frozen=True)
class RunSource:
    """A run read from disk.

    Attributes:
        folder: Its folder.
        provenance: How it was made.
        episodes: Its episodes, in order of name; at least one.
        previous: Whether they are of the previous version of the run's planner; then `folder` is
            the run's folder of superseded episodes.
    """

    folder: RunFolder
    provenance: Provenance
    episodes: tuple[Episode, ...]
    previous: bool = False

    @property
    def place(self) -> str:
        """Name of the folder, with that of the run if it is the folder of superseded episodes."""
        path = self.folder.path
        return f"{path.parent.name}/{path.name}" if self.previous else path.name

    @property
    def record_files(self) -> list[Path]:
        """Paths of the records."""
        return [self.folder.path / "episodes" / f"{item.name}.json" for item in self.episodes]

    @property
    def results(self) -> list[EpisodeResult]:
        """The records alone."""
        return [item.result for item in self.episodes]


@dataclass(frozen=True)
class RankingSource:
    """An RFDS that `plant-bench rfds` wrote into the folder of the filtered expert's run.

    Attributes:
        ranker: Name of the ranker, such as "attention".
        planner: Name of the planner that it used; None for rankers that need no planner.
        provenance: How the filtered expert's run was made.
        score: The RFDS.
    """

    ranker: str
    planner: str | None
    provenance: Provenance
    score: RelativeScore


@dataclass(frozen=True)
class CheckpointFiles:
    """Checkpoint files of one planner.

    Attributes:
        name: The planner; empty for the name in the file.
        files: The files, each with other episodes.
    """

    name: str
    files: tuple[Path, ...]


@dataclass(frozen=True)
class Sources:
    """All sources found.

    Attributes:
        runs: Folders that `plant-bench score` wrote.
        rankings: Folders with an RFDS that `plant-bench rfds` wrote.
        checkpoints: Files that may be checkpoints of the CARLA leaderboard, by planner.
        notes: Notes for the user on what was left out.
        previous: Folders of runs whose planner's previous version is also a source.
    """

    runs: tuple[Path, ...]
    rankings: tuple[Path, ...]
    checkpoints: tuple["CheckpointFiles", ...]
    notes: tuple[str, ...]
    previous: tuple[Path, ...] = ()


def find_sources(paths: Sequence[Path], *, below: Path, against_last: bool = False) -> Sources:
    """Return the sources at the given paths; without any path, search a folder.

    Args:
        paths: Runs, folders of `plant-bench rfds` runs, checkpoint files, folders of checkpoint
            files; NAME=PATH, also several times, for the checkpoint files of the planner NAME.
        below: Folder to search for runs if no path is given.
        against_last: Whether the previous versions of the runs' planners are sources, too.

    Raises:
        InputError: A given path is none of these, nothing was found, or `against_last` is set and
            no planner has a previous version.
    """
    if paths:
        given = dict.fromkeys(paths)
        skipped = [path for path in given if len(given) > 1 and _is_other_output(path)]
        parts = [_source_of(path) for path in given if path not in skipped]
        parts += [
            Sources((), (), (), (f"{path} is not a run: it is left out.",)) for path in skipped
        ]
    else:
        folders = sorted(path for path in below.glob("*") if path.is_dir())
        parts = [part for path in folders if (part := _source_below(path)) is not None]
    runs = [path for part in parts for path in part.runs]
    checkpoints = _by_planner([item for part in parts for item in part.checkpoints])
    if not runs and not checkpoints:
        message = (
            f"There is no run to report in {below}. Score a planner first, for example with "
            "'plant-bench score --agent expert', or give the folders of runs."
            if not paths
            else "No run of 'plant-bench score' was given: add runs."
        )
        raise InputError(message)
    return Sources(
        tuple(runs),
        tuple(path for part in parts for path in part.rankings),
        tuple(checkpoints),
        tuple(note for part in parts for note in part.notes),
        tuple(_with_previous(runs)) if against_last else (),
    )


def _with_previous(runs: Sequence[Path]) -> list[Path]:
    """Return the runs whose planner has a previous version.

    Raises:
        InputError: None has; the message is about the first.
    """
    found, errors = [], []
    for path in runs:
        try:
            previous_records(RunFolder.open(path))
            found.append(path)
        except InputError as error:
            errors.append(error)
    if not found:
        raise errors[0] if errors else InputError("--against-last: expected a run of plant-bench.")
    return found


def read_run(path: Path) -> RunSource:
    """Read a run's records.

    Raises:
        InputError: It has none, or one is broken.
    """
    folder = RunFolder.open(path)
    provenance = Provenance.load(folder.run_file)
    episodes = tuple(_episode(folder, file) for file in folder.record_files())
    if not episodes:
        message = f"{path} has no finished episodes: run its command again ({provenance.command})."
        raise InputError(message)
    return RunSource(folder, provenance, episodes)


def read_previous_version(path: Path) -> RunSource:
    """Read the records of the previous version of a run's planner.

    Args:
        path: The run.

    Raises:
        InputError: There are none, or one is broken.
    """
    run = RunFolder.open(path)
    folder = previous_folder(run)
    episodes = tuple(
        _episode(folder, folder.path / "episodes" / f"{name}.json")
        for name in previous_records(run)
    )
    return RunSource(folder, Provenance.load(run.run_file), episodes, previous=True)


def read_ranking(path: Path) -> RankingSource:
    """Read an RFDS.

    Raises:
        InputError: The file is broken, or its folder is not a run.
    """
    file = path / RANKING_FILE
    try:
        content = read_json(file)
        score = TypeAdapter(RelativeScore).validate_python(_with_nan(content))
    except (OSError, ValueError) as error:
        message = f"Cannot read {file} ({in_one_line(error)}). Run 'plant-bench rfds' again."
        raise InputError(message) from error
    ranker, _, planner = score.agent.partition("@")[2].partition(":")
    provenance = Provenance.load(RunFolder.open(path).run_file)
    return RankingSource(ranker, planner or None, provenance, score)


def _source_of(path: Path) -> Sources:
    if path.is_file():
        return Sources((), (), (CheckpointFiles("", (path,)),), ())
    name, sign, place = str(path).partition("=")
    if sign and not path.exists():
        if (Path(place) / "run.json").is_file():
            message = (
                f"{path}: {place} is a run of plant-bench, which has a name already. Give it "
                f"without '{name}='; NAME=PATH is for checkpoint files."
            )
            raise InputError(message)
        files = _checkpoint_files(Path(place))
        if not name or not files:
            message = (
                f"{path}: expected NAME=FILE or NAME=FOLDER with checkpoint files (.json or "
                ".json.gz) of the CARLA leaderboard."
            )
            raise InputError(message)
        return Sources((), (), (CheckpointFiles(name, files),), ())
    found = _source_below(path)
    if found is None and (files := _checkpoint_files(path)):
        return Sources((), (), (CheckpointFiles(path.resolve().name, files),), ())
    if found is None:
        kind = "has no run.json" if path.is_dir() else "does not exist"
        message = (
            f"{path} is not a run of plant-bench: it {kind}. Give folders written by 'plant-bench "
            "score' or 'plant-bench rfds', or checkpoint files of the CARLA leaderboard."
        )
        raise InputError(message)
    if found.notes:
        raise InputError(found.notes[0])
    return found


def _is_other_output(path: Path) -> bool:
    """Whether a path is something else that plant-bench writes into `reports/`."""
    if path.is_file():
        return path.suffix == ".md"
    return path.is_dir() and (
        path.name == "planners" or any((path / name).is_file() for name in _OTHER_OUTPUT)
    )


def _checkpoint_files(path: Path) -> tuple[Path, ...]:
    """Return a checkpoint file, or those of a folder, in order of name."""
    if path.is_file():
        return (path,)
    return tuple(sorted(file for end in ("*.json", "*.json.gz") for file in path.glob(end)))


def _by_planner(found: Sequence[CheckpointFiles]) -> list[CheckpointFiles]:
    """Return the files with those of one named planner together."""
    named: dict[str, list[Path]] = {}
    for item in found:
        if item.name:
            named.setdefault(item.name, []).extend(item.files)
    joined = [CheckpointFiles(name, tuple(dict.fromkeys(files))) for name, files in named.items()]
    return [item for item in found if not item.name] + joined


def _source_below(path: Path) -> Sources | None:
    """Return the sources in a folder, None if plant-bench did not write it."""
    if (path / RANKING_FILE).is_file():
        return Sources((), (path,), (), ())
    if (path / "run.json").is_file():
        if not RunFolder(path).record_files():
            return Sources((), (), (), (f"{path} has no finished episodes: it is left out.",))
        return Sources((path,), (), (), ())
    rankings = sorted(file.parent for file in path.glob(f"*/{RANKING_FILE}"))
    return Sources((), tuple(rankings), (), ()) if rankings else None


def _episode(folder: RunFolder, file: Path) -> Episode:
    recording, result = folder.recording_path(file.stem), EpisodeResult.load(file)
    if max(abs(result.seed), abs(result.format)) > LARGEST_WHOLE:
        message = f"Not an episode record: {file} (seed or format too large). Score again."
        raise InputError(message)
    return Episode(file.stem, result, recording if recording.is_file() else None)


def _with_nan(value: object) -> object:
    """Return JSON values with nan in place of null."""
    if isinstance(value, dict):
        return {name: _with_nan(item) for name, item in value.items()}
    if isinstance(value, Iterable) and not isinstance(value, str):
        return [_with_nan(item) for item in value]
    return math.nan if value is None else value
