"""Reads checkpoint JSON files of the CARLA leaderboard and of `plant-bench export`.

The global figures in the file are ignored: rates are recomputed as total counts over total
kilometres, since the file has sums of per-route rates (carla-simulator/leaderboard#117).
"""

import json
import math
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from pydantic import ValidationError

from plant_bench.errors import InputError
from plant_bench.reports.carla_checkpoint_records import ImportedRecord, imported_record
from plant_bench.reports.carla_checkpoint_schema import (
    ALL_NAMES,
    OUTSIDE,
    RATE_LABELS,
    SCORE_LABELS,
    Checkpoint,
)
from plant_bench.scoring.normalised_score import LEAST_KM
from plant_bench.scoring.results import EpisodeResult
from plant_bench.text_escaping import one_line
from plant_bench.untrusted_files import read_text

LB1, LB2, BENCH2DRIVE = "carla-lb1.0", "carla-lb2", "carla-bench2drive"
BENCH2DRIVE_ROUTES = 220
FAILED_STATUS = ("Crashed", "Rejected", "Failed", "Started")
COMPLETE_STATUS = ("Finished", "Finished with agent errors")
SAME_SCORE = 0.01  # between a file's own driving score and that of its episodes
LARGEST = 256_000_000  # bytes of a file


@dataclass(frozen=True)
class ImportedRun:
    """A run read from a checkpoint file.

    Attributes:
        name: Name of the planner: the agent of a plant-bench run, else the file's stem.
        protocol: The rules: those of a plant-bench run, "carla-lb1.0", "carla-lb2" or
            "carla-bench2drive".
        source: The file, or the first of several.
        expected: Number of episodes in a complete run.
        records: The episodes, in the files' order.
        notes: What the user should know about the files: contradictions, missing episodes.
    """

    name: str
    protocol: str
    source: Path
    expected: int
    records: tuple[ImportedRecord, ...]
    notes: tuple[str, ...] = ()

    @property
    def route_lengths(self) -> dict[str, float]:
        """The routes and their lengths, kilometres; 0 if not known, as after a failed start."""
        lengths: dict[str, float] = {}
        for item in self.records:
            lengths[item.route] = max(item.route_km, lengths.get(item.route, 0.0))
        return lengths

    @property
    def results(self) -> tuple[EpisodeResult, ...]:
        """The original records of an exported plant-bench run; empty for other files."""
        return tuple(item.original for item in self.records if item.original is not None)

    @property
    def km(self) -> float:
        """Kilometres driven along the routes."""
        return math.fsum(item.km for item in self.records)

    @property
    def infractions_per_km(self) -> dict[str, float]:
        """Total counts over total kilometres, by the file's names; kilometres for outside lanes."""
        km = max(self.km, LEAST_KM)
        counts: Counter[str] = Counter()
        for item in self.records:
            counts.update(item.counts)
        outside = math.fsum(item.outside_km for item in self.records)
        names = sorted({*ALL_NAMES, *counts})
        return {name: counts[name] / km for name in names} | {OUTSIDE: outside / km}


@dataclass(frozen=True)
class _Part:
    """One file's share of a run.

    Attributes:
        run: The file alone.
        total: Number of episodes by its progress; None if it has none.
        failed: Whether its evaluation ended early, by its status.
    """

    run: ImportedRun
    total: int | None
    failed: bool

    @property
    def count(self) -> int:
        """Number of its episodes."""
        return len(self.run.records)


def load_checkpoints(paths: Sequence[Path], name: str = "") -> ImportedRun:
    """Read the checkpoint files of one planner, each with other episodes.

    Args:
        paths: The files, at least one, for instance one per route or per worker.
        name: The planner; empty for the name in the files.

    Returns:
        The run, with the files' episodes together.

    Raises:
        InputError: One is not a checkpoint file, or they are not parts of one run.
    """
    parts = [_load(path) for path in paths]
    runs = [part.run for part in parts]
    first = runs[0]
    if len({run.protocol for run in runs}) > 1:
        protocols = ", ".join(f"{run.source.name} {run.protocol}" for run in runs[:5])
        message = f"These files are not parts of one run, their protocols differ: {protocols}."
        raise InputError(message)
    records = tuple(item for run in runs for item in run.records)
    try:
        _check_different(records)
    except ValueError as error:
        names = ", ".join(path.name for path in paths[:5])
        message = f"These files are not parts of one run ({error}): {names}."
        raise InputError(message) from error
    name = name or first.name
    expected, reading = _expected(parts, records)
    notes = [note for run in runs for note in run.notes]
    notes += [f"{name}: {reading}"] * bool(reading)
    return replace(first, name=name, expected=expected, records=records, notes=tuple(notes))


def load_checkpoint(path: Path) -> ImportedRun:
    """Read a checkpoint file of CARLA or of `plant-bench export`.

    Raises:
        InputError: It is not a checkpoint file, or it is broken or inconsistent.
    """
    return load_checkpoints([path])


def _load(path: Path) -> _Part:
    """Read a file.

    Raises:
        InputError: It is not a checkpoint file, or it is broken or inconsistent.
    """
    try:
        document = _document(path)
        file = Checkpoint.model_validate(document)
        run = _run(file, path)
    except ValidationError as error:
        first = error.errors()[0]
        where = ".".join(map(str, first["loc"]))
        raise _refusal(path, f"{one_line(where)}: {first['msg']}") from error
    except OSError as error:
        raise _refusal(path, error.strerror or str(error)) from error
    except RecursionError as error:
        raise _refusal(path, "it is nested too deeply") from error
    except ValueError as error:
        raise _refusal(path, one_line(str(error))) from error
    total = next(iter(file.checkpoint.progress[1:]), None)
    return _Part(run, total, failed=file.entry_status in FAILED_STATUS)


def _expected(parts: Sequence[_Part], records: Sequence[ImportedRecord]) -> tuple[int, str]:
    """Return the number of episodes of a complete run, and how ambiguous files were read.

    Files with equal totals that no file reaches, not even all together, are ambiguous: the total
    is each file's, or each file repeats that of the whole run.
    """
    protocol = parts[0].run.protocol
    whole = BENCH2DRIVE_ROUTES * len({item.repetition for item in records})
    total, files = parts[0].total, len(parts)
    together = sum(max(part.count, part.total or 0) for part in parts)
    if protocol == BENCH2DRIVE and any(part.total is None for part in parts):
        return max(whole, together), ""
    ambiguous = (
        files > 1
        and total is not None
        and len(records) <= total
        and all(part.total == total > part.count for part in parts)
    )
    if not ambiguous or total is None:
        return together, ""
    of_all = (protocol == BENCH2DRIVE and total == whole) or not any(part.failed for part in parts)
    expected = total if of_all else together
    return expected, f"each of its {files} files says {total} episodes: read as {expected} in all."


def _refusal(path: Path, why: str) -> InputError:
    return InputError(
        f"Not a checkpoint of the CARLA leaderboard: {path} ({why}). Give the JSON file of an "
        "evaluation or of `plant-bench export`."
    )


def _document(path: Path) -> object:
    """Return the file's JSON, also of a file compressed with gzip.

    Raises:
        OSError: It cannot be read.
        ValueError: It is not JSON, is too large, or has a duplicate key, NaN or invalid Unicode.
    """
    text = read_text(path, largest=LARGEST).removeprefix("\ufeff")
    document = json.loads(text, object_pairs_hook=_unique_keys, parse_constant=_no_constant)
    json.dumps(document, ensure_ascii=False).encode()  # fails for unpaired surrogates
    return document


def _unique_keys(pairs: Iterable[tuple[str, object]]) -> dict[str, object]:
    unique: dict[str, object] = {}
    for key, value in pairs:
        if key in unique:
            message = f"the key {one_line(key)!r} occurs twice"
            raise ValueError(message)
        unique[key] = value
    return unique


def _no_constant(name: str) -> float:
    message = f"{name} is not a valid number"
    raise ValueError(message)


def _run(file: Checkpoint, path: Path) -> ImportedRun:
    """Return the run of a file that matches the schema.

    Raises:
        ValueError: The file is inconsistent.
    """
    records = file.checkpoint.records
    if not records:
        message = "it has no records"
        raise ValueError(message)
    seen: Counter[str] = Counter()
    imported = []
    for place, record in enumerate(records):
        try:
            imported.append(imported_record(record, seen))
        except ValueError as error:
            message = f"record {place}: {one_line(str(error))}"
            raise ValueError(message) from error
    _check_different(imported)
    originals = [item.original for item in imported if item.original is not None]
    if originals and len(originals) < len(imported):
        message = "some of its records are plant-bench's, some are not"
        raise ValueError(message)
    if len({(item.protocol, item.agent) for item in originals}) > 1:
        message = "its records have several agents or protocols"
        raise ValueError(message)
    protocol = originals[0].protocol if originals else _protocol(file)
    return ImportedRun(
        name=originals[0].agent if originals else path.name.split(".json")[0],
        protocol=protocol,
        source=path,
        expected=len(imported),
        records=tuple(imported),
        notes=(*_contradictions(file, path), *_score_notes(file, path)),
    )


def _contradictions(file: Checkpoint, path: Path) -> Iterator[str]:
    """Yield a note if a file's progress, status and records contradict each other."""
    count, progress = len(file.checkpoint.records), file.checkpoint.progress
    if progress and progress[0] != count:
        status = f", entry_status '{one_line(file.entry_status)}'" if file.entry_status else ""
        left_over = "; the others may be left over from an earlier run"
        more = left_over if progress[0] < count else ""
        total = f" of {progress[1]}" if len(progress) > 1 else ""
        yield (
            f"{path.name} contradicts itself: its progress says {progress[0]}{total} routes"
            f"{status}, but it has {count} records{more}."
        )
    elif file.entry_status in FAILED_STATUS:
        yield f"{path.name}: its evaluation ended with the status '{file.entry_status}'."
    elif file.entry_status in COMPLETE_STATUS and len(progress) > 1 and progress[1] > count:
        yield (
            f"{path.name} contradicts itself: its entry_status is '{file.entry_status}', but its "
            f"progress says {count} of {progress[1]} routes."
        )


def _score_notes(file: Checkpoint, path: Path) -> Iterator[str]:
    """Yield a note if a merged file's own driving score is not the mean of its episodes."""
    own, records = file.merged_score, file.checkpoint.records
    total = math.fsum(item.scores.score_composed for item in records)
    mean = total / len(records)
    if own is None or abs(own - mean) < SAME_SCORE:
        return
    missing = BENCH2DRIVE_ROUTES - len(records)
    if missing > 0 and abs(own - total / BENCH2DRIVE_ROUTES) < SAME_SCORE:
        why = f"counts {missing} missing routes as 0"
    else:
        why = f"is not the mean of its episodes, {mean:.2f}"
    yield (
        f"{path.name}: its own driving score, {own:.2f}, {why}; the table has the mean of its "
        "episodes."
    )


def _check_different(records: Iterable[ImportedRecord]) -> None:
    places = Counter((item.route, item.repetition) for item in records)
    (route, repetition), count = places.most_common(1)[0]
    if count > 1:
        message = f"route {one_line(route)}, repetition {repetition} occurs {count} times"
        raise ValueError(message)


def _protocol(file: Checkpoint) -> str:
    records = file.checkpoint.records
    if any(item.scenario_name is not None and item.weather_id is not None for item in records):
        return BENCH2DRIVE
    more_labels = len(file.labels) > len(SCORE_LABELS) + len(RATE_LABELS)
    if more_labels or any(item.num_infractions is not None for item in records):
        return LB2
    return LB1
