"""The table of `plant-bench rfds`."""

import math
from collections.abc import Mapping

from plant_bench.reports.tables import print_rows
from plant_bench.scoring.metrics import Spread
from plant_bench.scoring.relevance import RelativeScore


def print_relative_scores(scores: Mapping[str, RelativeScore]) -> None:
    """Print a row for each ranker, in the given order."""
    some = next(iter(scores.values()))
    rows = [
        [name, _spread(item.score), _spread(item.filtered), _spread(item.whole), item.episodes]
        for name, item in scores.items()
    ]
    title = f"RFDS: the expert's DS with one vehicle in sight, in % ({some.protocol}, {some.law})"
    print_rows(title, ["ranker", "RFDS", "DS, one vehicle", "DS, all", "episodes"], rows)


def _spread(spread: Spread) -> str:
    mean = f"{spread.mean:.2f}"
    return mean if math.isnan(spread.std) else f"{mean} ± {spread.std:.2f}"
