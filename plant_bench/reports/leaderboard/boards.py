"""Runs -> boards: one a protocol and suite, each with its lines and the differences between them."""

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from pathlib import Path

from plant_bench.errors import InputError
from plant_bench.reports.carla_checkpoint import ImportedRun, load_checkpoint
from plant_bench.reports.leaderboard.imported import imported_line
from plant_bench.reports.leaderboard.lines import Line, distinct, run_line
from plant_bench.reports.leaderboard.published import paper_lines
from plant_bench.reports.leaderboard.sources import (
    RankingSource,
    RunSource,
    Sources,
    read_ranking,
    read_run,
)
from plant_bench.runner.provenance import without_folders
from plant_bench.scoring.comparison import PairedDifference, paired_difference
from plant_bench.scoring.laws import Law
from plant_bench.scoring.metrics import Summary, summarise
from plant_bench.scoring.significance import holm

HERE, CARLA = "plant-bench", "CARLA"  # worlds
RANKERS = ("attention", "masking")  # a line tells the first there is
LONGEST_ID = 40  # characters


@dataclass(frozen=True)
class Entry:
    """A run of ours on a board.

    Attributes:
        line: What the table tells.
        run: Its episodes.
        summary: All that is derived from them.
    """

    line: Line
    run: RunSource
    summary: Summary


@dataclass(frozen=True)
class Difference:
    """By how much one entry's DS is above another's, on the scenarios that both drove.

    Attributes:
        better: Id of the entry with the higher mean difference.
        worse: Id of the other.
        paired: The difference, not below zero.
        p_corrected: Its p-value, corrected for all pairs of the board (Holm).
    """

    better: str
    worse: str
    paired: PairedDifference
    p_corrected: float


@dataclass(frozen=True)
class Board:
    """One table: runs that may be compared.

    Attributes:
        world: `HERE` or `CARLA`.
        protocol: The rules.
        suite: Name of the routes; empty where not known.
        density: Of the traffic; empty where not known.
        law: By which infractions became scores; empty where not known.
        lines: The highest driving score first.
        entries: Of the lines that are runs of ours, in the same order.
        differences: Of each two entries that share scenarios.
        rankings: RFDS of all rankers on these routes, the highest first.
        source: Where the figures are from, if not from runs of ours.
    """

    world: str
    protocol: str
    suite: str
    density: str
    law: str
    lines: tuple[Line, ...]
    entries: tuple[Entry, ...] = ()
    differences: tuple[Difference, ...] = ()
    rankings: tuple[RankingSource, ...] = ()
    source: str = ""


@dataclass(frozen=True)
class Leaderboard:
    """All boards, those of our own runs first.

    Attributes:
        boards: At least one.
        notes: What the user should know of how they were made.
    """

    boards: tuple[Board, ...]
    notes: tuple[str, ...]


_Key = tuple[str, str, str]  # protocol, suite, density


def make_leaderboard(
    sources: Sources, *, law: Law, paper: bool, progress: Callable[[str], None]
) -> Leaderboard:
    """Read all sources and put them into boards.

    Args:
        sources: What was found.
        law: By which infractions become scores.
        paper: Whether PlanT's own figures get a board.
        progress: Told what is read next.

    Raises:
        InputError: A source cannot be read, or its episodes cannot be summed up.
    """
    runs = [_told(path, progress, read_run) for path in sources.runs]
    rankings = [_told(path, progress, read_ranking) for path in sources.rankings]
    imported = [_told(path, progress, load_checkpoint) for path in sources.checkpoints]
    progress("differences")
    notes = [*sources.notes, *_twin_notes(runs)]
    ids = _ids([run.provenance.agent for run in runs] + [item.name for item in imported])
    groups: dict[_Key, list[tuple[str, RunSource]]] = {}
    for id, run in zip(ids, runs, strict=False):
        groups.setdefault(_key(run), []).append((id, run))
    boards = [
        _board(key, group, [item for item in rankings if _ranking_key(item) == key], law, notes)
        for key, group in groups.items()
    ]
    boards.sort(key=lambda board: (-len(board.lines), board.protocol, board.suite))
    boards += _imported_boards(imported, ids[len(runs) :])
    if paper:
        lines = paper_lines()
        boards.append(Board(CARLA, "longest6", "longest6", "", "lb1.0", lines, source=lines[0].source))
    return Leaderboard(tuple(boards), tuple(notes))


def _told[Source](
    path: Path, progress: Callable[[str], None], read: Callable[[Path], Source]
) -> Source:
    progress(path.name)
    return read(path)


def _key(run: RunSource) -> _Key:
    """Return what runs of one board have in common; the rules are those of the records."""
    provenance = run.provenance
    return run.episodes[0].result.protocol, without_folders(provenance.suite), provenance.density


def _ranking_key(ranking: RankingSource) -> _Key:
    provenance = ranking.provenance
    return ranking.score.protocol, without_folders(provenance.suite), provenance.density


def _board(
    key: _Key,
    group: Sequence[tuple[str, RunSource]],
    rankings: Sequence[RankingSource],
    law: Law,
    notes: list[str],
) -> Board:
    names = distinct(
        [without_folders(run.provenance.agent) for _, run in group],
        lambda place: group[place][1].folder.path.name,
    )
    entries = []
    for (id, run), planner in zip(group, names, strict=True):
        summary = _summary(run, law)
        ranking = _ranking_of(run, group, rankings, notes)
        entries.append(Entry(run_line(run, summary, ranking, id=id, planner=planner), run, summary))
    entries.sort(key=lambda entry: -entry.line.driving_score.mean)
    return Board(
        HERE,
        *key,
        law.value,
        tuple(entry.line for entry in entries),
        tuple(entries),
        _differences(entries, law),
        tuple(sorted(rankings, key=lambda item: -item.score.score.mean)),
    )


def _summary(run: RunSource, law: Law) -> Summary:
    asked = len(run.provenance.routes) * run.provenance.repetitions
    try:
        return summarise(run.results, expected=max(asked, len(run.episodes)), law=law)
    except InputError as error:
        message = f"{run.folder.path}: {error}"
        raise InputError(message) from error


def _ranking_of(
    run: RunSource,
    group: Sequence[tuple[str, RunSource]],
    rankings: Sequence[RankingSource],
    notes: list[str],
) -> RankingSource | None:
    """Return the RFDS of a run's planner: that of its name, where one run alone has that name."""
    agent = run.provenance.agent
    own = {item.ranker: item for item in rankings if item.planner == agent}
    if own and sum(other.provenance.agent == agent for _, other in group) > 1:
        note = f"RFDS is told of '{agent}', and several runs are of it: none of them is given it."
        notes.extend([note] * (note not in notes))
        return None
    return next((own[name] for name in RANKERS if name in own), None)


def _differences(entries: Sequence[Entry], law: Law) -> tuple[Difference, ...]:
    found = []
    for high, low in combinations(entries, 2):
        try:
            paired = paired_difference(low.run.results, high.run.results, law=law)
            if paired.mean < 0.0:  # on what both drove, the lower in the table is the better one
                paired = paired_difference(high.run.results, low.run.results, law=law)
                high, low = low, high
        except InputError:
            continue  # no scenario in common
        found.append(Difference(high.line.id, low.line.id, paired, paired.p_value))
    corrected = holm([item.p_corrected for item in found])
    return tuple(replace(item, p_corrected=p) for item, p in zip(found, corrected, strict=True))


def _imported_boards(runs: Sequence[ImportedRun], ids: Sequence[str]) -> list[Board]:
    names = distinct([run.name for run in runs], lambda place: runs[place].source.parent.name)
    by_protocol: dict[str, list[Line]] = {}
    for run, id, name in zip(runs, ids, names, strict=True):
        by_protocol.setdefault(run.protocol, []).append(imported_line(run, id=id, planner=name))
    return [
        Board(
            CARLA,
            protocol,
            "",
            "",
            "",
            tuple(sorted(lines, key=lambda line: -line.driving_score.mean)),
            source="checkpoint files of the CARLA leaderboard",
        )
        for protocol, lines in sorted(by_protocol.items())
    ]


def _ids(names: Sequence[str]) -> list[str]:
    """Return a short id for each name; those of equal names are numbered."""
    short = [
        re.sub(r"[^a-z0-9]+", "-", name.lower()).strip("-")[:LONGEST_ID].strip("-") or "run"
        for name in names
    ]
    found: list[str] = []
    for name in short:
        number = 1
        while (id := name if number == 1 else f"{name}-{number}") in found:
            number += 1
        found.append(id)
    return found


def _twin_notes(runs: Sequence[RunSource]) -> list[str]:
    """Say which runs are of one and the same agent."""
    notes = []
    for first, second in combinations(runs, 2):
        checksum = first.episodes[0].result.agent_checksum
        if checksum == second.episodes[0].result.agent_checksum and _key(first) == _key(second):
            notes.append(
                f"{first.folder.path} and {second.folder.path} are of the same agent "
                f"({first.provenance.agent}, {checksum[:12]}): both are shown."
            )
    return notes
