"""The table of `plant-bench rfds`."""

from collections.abc import Mapping

from plant_bench.reports.tables import print_rows
from plant_bench.scoring.relevance import RelativeScore


def print_relative_scores(scores: Mapping[str, RelativeScore]) -> None:
    """Print a row for each ranker, in the given order."""
    some = next(iter(scores.values()))
    rows = [
        [name, item.score.text(2), item.filtered.text(2), item.whole.text(2), item.episodes]
        for name, item in scores.items()
    ]
    title = f"RFDS: the expert's DS with one vehicle in sight, in % ({some.protocol}, {some.law})"
    print_rows(title, ["ranker", "RFDS", "DS, one vehicle", "DS, all", "episodes"], rows)
