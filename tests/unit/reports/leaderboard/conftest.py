"""Leaderboards of hand-made runs."""

from collections.abc import Callable, Sequence
from pathlib import Path

import pytest

from plant_bench.reports.leaderboard.board import Leaderboard
from plant_bench.reports.leaderboard.board_builder import make_leaderboard
from plant_bench.reports.leaderboard.score_sources import find_sources
from plant_bench.scoring.penalties import PenaltyScheme


def _leaderboard(paths: Sequence[Path], *, paper: bool = False) -> Leaderboard:
    sources = find_sources(paths, below=Path("nowhere"))
    return make_leaderboard(
        sources, penalties=PenaltyScheme.LB1_0, paper=paper, progress=lambda _: None
    )


@pytest.fixture
def leaderboard() -> Callable[..., Leaderboard]:
    """Make a leaderboard of run folders."""
    return _leaderboard
