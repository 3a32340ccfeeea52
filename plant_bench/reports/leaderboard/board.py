"""Data classes of a leaderboard: boards with their rows, runs and pairwise differences."""

from dataclasses import dataclass

from plant_bench.reports.leaderboard.rows import Row
from plant_bench.reports.leaderboard.score_sources import RankingSource, RunSource
from plant_bench.scoring.comparison import PairedDifference, Verdict, verdict_of
from plant_bench.scoring.metrics import Summary

HERE, CARLA = "plant-bench", "CARLA"  # worlds


@dataclass(frozen=True)
class Entry:
    """A plant-bench run on a board.

    Attributes:
        row: Its row of the table.
        run: Its episodes.
        summary: The summary of its episodes.
    """

    row: Row
    run: RunSource
    summary: Summary


@dataclass(frozen=True)
class Difference:
    """By how much one entry's DS is above another's, on the scenarios that both drove.

    Attributes:
        better: Id of the entry with the higher DS.
        worse: Id of the other entry.
        paired: The difference; its mean is not negative.
        p_corrected: p-value, corrected for all pairs of the board (Holm).
    """

    better: str
    worse: str
    paired: PairedDifference
    p_corrected: float

    @property
    def verdict(self) -> Verdict:
        """Whether the difference is significant, by `verdict_of` with the corrected p-value."""
        return verdict_of(self.paired, self.p_corrected)

    @property
    def significant(self) -> bool:
        """Whether the better entry is significantly better."""
        return self.verdict is Verdict.BETTER


@dataclass(frozen=True)
class Board:
    """One table: runs that can be compared with each other.

    Attributes:
        world: Simulator environment, `HERE` or `CARLA`.
        protocol: Version of the rules.
        suite: Name of the routes; empty if not known.
        density: Traffic density; empty if not known.
        penalties: The penalty scheme; empty if not known.
        rows: Rows of the table: complete ones first, then the highest driving score first.
        entries: The rows that are plant-bench runs, in the same order.
        differences: Differences of all pairs of entries that share scenarios.
        rankings: RFDS of all rankers on these routes, the highest first.
        source: Source of the figures, if they are not from plant-bench runs.
        routes: Number of different routes that the rows drove together; 0 if not known.
    """

    world: str
    protocol: str
    suite: str
    density: str
    penalties: str
    rows: tuple[Row, ...]
    entries: tuple[Entry, ...] = ()
    differences: tuple[Difference, ...] = ()
    rankings: tuple[RankingSource, ...] = ()
    source: str = ""
    routes: int = 0

    def is_complete(self, row: Row) -> bool:
        """Whether a row's mean is over all routes of the table, so that it can be ranked."""
        return row.routes >= self.routes


@dataclass(frozen=True)
class Leaderboard:
    """All boards, those of plant-bench runs first.

    Attributes:
        boards: One or more boards.
        notes: Notes for the user on how the boards were made.
    """

    boards: tuple[Board, ...]
    notes: tuple[str, ...]
