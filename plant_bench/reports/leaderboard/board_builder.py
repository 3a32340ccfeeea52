"""Builds the boards of a leaderboard from runs: one per protocol, suite and traffic density."""

import math
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from pathlib import Path
from typing import TypeVar

from plant_bench.agents.loading.planner_spec import without_folders
from plant_bench.errors import InputError
from plant_bench.reports.carla_checkpoint import (
    BENCH2DRIVE,
    BENCH2DRIVE_ROUTES,
    ImportedRun,
    load_checkpoints,
)
from plant_bench.reports.leaderboard.board import CARLA, HERE, Board, Difference, Entry, Leaderboard
from plant_bench.reports.leaderboard.imported_checkpoints import imported_row
from plant_bench.reports.leaderboard.published import paper_rows
from plant_bench.reports.leaderboard.rows import Row, distinct, run_row
from plant_bench.reports.leaderboard.score_sources import (
    RankingSource,
    RunSource,
    Sources,
    read_previous_version,
    read_ranking,
    read_run,
)
from plant_bench.reports.tables import counted
from plant_bench.scoring.comparison import paired_difference
from plant_bench.scoring.metrics import Summary, summarise
from plant_bench.scoring.penalties import PenaltyScheme
from plant_bench.scoring.significance import holm
from plant_bench.text_escaping import table_cell

RANKERS = ("attention", "masking")  # a row shows the first one available
LONGEST_ID = 40  # characters
NAMELESS = "(no name)"


SAME_LENGTH = 0.002  # km between the lengths of a route in two files

_Named = tuple[ImportedRun, str, str]  # with the row's id and the planner's name
_Key = tuple[str, str, str]  # protocol, suite, density
_Source = TypeVar("_Source")


@dataclass
class _RouteSet:
    """Imported runs on the same routes. Mutable.

    Attributes:
        lengths: The routes and their lengths in kilometres; 0 if not known.
        runs: The runs; some may lack routes.
    """

    lengths: dict[str, float]
    runs: list[_Named]

    @property
    def text(self) -> str:
        """Number of routes and their length."""
        return f"{counted(len(self.lengths), 'route')}, {math.fsum(self.lengths.values()):.1f} km"

    def contains(self, routes: Mapping[str, float]) -> bool:
        """Whether all given routes are among these, with equal lengths where both are known."""
        return all(
            route in self.lengths
            and (0.0 in (km, self.lengths[route]) or abs(self.lengths[route] - km) < SAME_LENGTH)
            for route, km in routes.items()
        )


def make_leaderboard(
    sources: Sources, *, penalties: PenaltyScheme, paper: bool, progress: Callable[[str], None]
) -> Leaderboard:
    """Read all sources and build the boards.

    Args:
        sources: Runs, rankings and checkpoint files to read.
        penalties: The penalty scheme.
        paper: Whether to add a board with the figures of the PlanT paper.
        progress: Called with the name of what is read next.

    Raises:
        InputError: A source cannot be read, or its episodes cannot be summarised.
    """
    runs = _read(sources.runs, progress, read_run)
    runs += _read(sources.previous, progress, read_previous_version)
    rankings = _read(sources.rankings, progress, read_ranking)
    imported = []
    for item in sources.checkpoints:
        progress(item.name or item.files[0].name)
        imported.append(load_checkpoints(item.files, item.name))
    progress("differences")
    notes = [*sources.notes, *_twin_notes(runs)]
    notes += [note for run in imported for note in run.notes]
    ids = _ids([_run_name(run) for run in runs] + [item.name for item in imported])
    groups: dict[_Key, list[tuple[str, RunSource]]] = {}
    for id, run in zip(ids, runs, strict=False):
        groups.setdefault(_key(run), []).append((id, run))
    boards = [
        _board(
            key, group, [item for item in rankings if _ranking_key(item) == key], penalties, notes
        )
        for key, group in groups.items()
    ]
    boards.sort(key=lambda board: (-len(board.rows), board.protocol, board.suite))
    boards += _imported_boards(imported, ids[len(runs) :], notes)
    if paper:
        rows = paper_rows()
        boards.append(
            Board(CARLA, "longest6", "longest6", "", "lb1.0", rows, source=rows[0].source)
        )
    return Leaderboard(tuple(boards), tuple(notes))


def _read(
    paths: Sequence[Path], progress: Callable[[str], None], reader: Callable[[Path], _Source]
) -> list[_Source]:
    sources = []
    for path in paths:
        progress(path.name)
        sources.append(reader(path))
    return sources


def _key(run: RunSource) -> _Key:
    """Return the key of a run's board: protocol (from the records), suite, density."""
    provenance = run.provenance
    return run.episodes[0].result.protocol, without_folders(provenance.suite), provenance.density


def _ranking_key(ranking: RankingSource) -> _Key:
    provenance = ranking.provenance
    return ranking.score.protocol, without_folders(provenance.suite), provenance.density


def _board(
    key: _Key,
    group: Sequence[tuple[str, RunSource]],
    rankings: Sequence[RankingSource],
    penalties: PenaltyScheme,
    notes: list[str],
) -> Board:
    names = distinct(
        [_planner(_run_name(run)) for _, run in group], lambda place: group[place][1].place
    )
    entries = []
    for (id, run), planner in zip(group, names, strict=True):
        summary = _summary(run, penalties)
        ranking = _ranking_of(run, group, rankings, notes)
        entries.append(Entry(run_row(run, summary, ranking, id=id, planner=planner), run, summary))
    routes = len({result.route for entry in entries for result in entry.run.results})
    entries.sort(key=lambda entry: _rank(entry.row, routes))
    return Board(
        HERE,
        *key,
        penalties.value,
        tuple(entry.row for entry in entries),
        tuple(entries),
        _differences_between(entries, penalties),
        tuple(sorted(rankings, key=lambda item: -item.score.score.mean)),
        routes=routes,
    )


def _run_name(run: RunSource) -> str:
    """Return the name of a run's planner, with "(previous)" if it is the previous version."""
    return run.provenance.agent + " (previous)" * run.previous


def _planner(agent: str) -> str:
    """Return an agent's display name: without folders, and never empty."""
    name = without_folders(agent)
    return name if table_cell(name) else NAMELESS


def _summary(run: RunSource, penalties: PenaltyScheme) -> Summary:
    planned = len(run.provenance.routes) * run.provenance.repetitions
    try:
        return summarise(run.results, expected=max(planned, len(run.episodes)), penalties=penalties)
    except InputError as error:
        message = f"{run.folder.path}: {error}"
        raise InputError(message) from error


def _ranking_of(
    run: RunSource,
    group: Sequence[tuple[str, RunSource]],
    rankings: Sequence[RankingSource],
    notes: list[str],
) -> RankingSource | None:
    """Return the RFDS of a run's planner, matched by checksum.

    A file without a checksum is matched by name, provided that only one run has this name.
    """
    agent, checksum = run.provenance.agent, run.episodes[0].result.agent_checksum
    named = {
        item.ranker: item
        for item in rankings
        if item.planner == agent and not item.score.planner_checksum
    }
    own = {item.ranker: item for item in rankings if item.score.planner_checksum == checksum}
    if not own and named and sum(other.provenance.agent == agent for _, other in group) > 1:
        note = f"The RFDS of '{agent}' is left out: several runs have this name."
        notes.extend([note] * (note not in notes))
        return None
    own = own or named
    return next((own[name] for name in RANKERS if name in own), None)


def _imported_boards(
    runs: Sequence[ImportedRun], ids: Sequence[str], notes: list[str]
) -> list[Board]:
    """Return one board per protocol and set of routes; add notes on missing routes."""
    names = distinct(
        [_planner(run.name) for run in runs], lambda place: runs[place].source.parent.name
    )
    named = list(zip(runs, ids, names, strict=True))
    boards = []
    for world, protocol in sorted({_world(run) for run in runs}):
        sets = _route_sets([item for item in named if _world(item[0]) == (world, protocol)])
        if len(sets) > 1:
            notes.append(
                f"{protocol}: the files are about {len(sets)} different sets of routes, which "
                "cannot be compared; each has a table of its own."
            )
        for number, group in enumerate(sets, start=1):
            rows = [
                imported_row(run, id=id, planner=name, expected=_episodes_of_set(run, group))
                for run, id, name in group.runs
            ]
            notes += _missing_notes(group)
            routes = len(group.lengths)
            boards.append(
                Board(
                    world,
                    protocol,
                    f"route set {number} ({group.text})" if len(sets) > 1 else "",
                    "",
                    "",
                    tuple(sorted(rows, key=lambda row: _rank(row, routes))),
                    source="checkpoint files of the CARLA leaderboard",
                    routes=routes,
                )
            )
    return boards


def _world(run: ImportedRun) -> tuple[str, str]:
    return (HERE if run.results else CARLA), run.protocol


def _rank(row: Row, routes: int) -> tuple[bool, float]:
    """Return a key that sorts rows with all routes first, then by driving score."""
    return row.routes < routes, -row.driving_score.mean


def _route_sets(named: Sequence[_Named]) -> list[_RouteSet]:
    """Return the runs in groups with comparable routes, the largest set of routes first.

    Runs are comparable if the routes of one are among those of the other, with equal lengths; a
    run that lacks routes is shown with the larger set.
    """
    sets: list[_RouteSet] = []
    for item in sorted(named, key=lambda item: -len(item[0].route_lengths)):
        own = item[0].route_lengths
        group = next((group for group in sets if group.contains(own)), None)
        if group is None:
            sets.append(_RouteSet(own, [item]))
        else:
            group.lengths |= {route: km for route, km in own.items() if km > 0.0}
            group.runs.append(item)
    return sets


def _episodes_of_set(run: ImportedRun, group: _RouteSet) -> int:
    """Return the number of episodes if a run drove all routes of its set."""
    return len(group.lengths) * len({item.repetition for item in run.records})


def _missing_notes(group: _RouteSet) -> list[str]:
    """Return a note for each run that lacks episodes, with both possible means."""
    notes = []
    for run, _, name in group.runs:
        count = len(run.records)
        most = max(run.expected, _episodes_of_set(run, group))
        total = math.fsum(item.driving_score for item in run.records)
        if most > count:
            notes.append(
                f"{name} lacks {most - count} of {most} episodes: DS {total / count:.1f} on those "
                f"it has, {total / most:.1f} if the others count as 0."
            )
        elif run.protocol == BENCH2DRIVE and count < BENCH2DRIVE_ROUTES:
            notes.append(
                f"{name} has {counted(count, 'episode')}; all of Bench2Drive is "
                f"{BENCH2DRIVE_ROUTES}: DS {total / BENCH2DRIVE_ROUTES:.1f} if the others count "
                "as 0."
            )
    return notes


def _ids(names: Sequence[str]) -> list[str]:
    """Return a short id for each name; ids of equal names are numbered."""
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
    """Return a note for each pair of runs with the same agent."""
    notes = []
    for first, second in combinations(runs, 2):
        checksum = first.episodes[0].result.agent_checksum
        if checksum == second.episodes[0].result.agent_checksum and _key(first) == _key(second):
            notes.append(
                f"{first.folder.path} and {second.folder.path} have the same agent "
                f"({first.provenance.agent}, {checksum[:12]}): both are shown."
            )
    return notes


def _differences_between(
    entries: Sequence[Entry], penalties: PenaltyScheme
) -> tuple[Difference, ...]:
    """Return the differences of all pairs that share scenarios, p corrected for their number."""
    found = []
    for high, low in combinations(entries, 2):
        try:
            paired = paired_difference(low.run.results, high.run.results, penalties=penalties)
            if paired.mean < 0.0:  # on the common scenarios, the lower row scores higher
                paired = paired_difference(high.run.results, low.run.results, penalties=penalties)
                high, low = low, high
        except InputError:
            continue  # no scenario in common
        found.append(Difference(high.row.id, low.row.id, paired, paired.p_value))
    corrected = holm([item.p_corrected for item in found])
    return tuple(replace(item, p_corrected=p) for item, p in zip(found, corrected, strict=True))
