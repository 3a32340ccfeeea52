"""A leaderboard's values: boards, and on each the lines, the runs behind them, the differences."""

from dataclasses import dataclass

from plant_bench.reports.leaderboard.rows import Line
from plant_bench.reports.leaderboard.score_sources import RankingSource, RunSource
from plant_bench.scoring.comparison import PairedDifference
from plant_bench.scoring.metrics import Summary

HERE, CARLA = "plant-bench", "CARLA"  # worlds


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
        penalties: By which infractions became scores; empty where not known.
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
    penalties: str
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
