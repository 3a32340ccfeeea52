"""Each two runs of a board compared on the scenarios that both drove."""

from collections.abc import Sequence
from dataclasses import replace
from itertools import combinations

from plant_bench.errors import InputError
from plant_bench.reports.leaderboard.board import Difference, Entry
from plant_bench.scoring.comparison import paired_difference
from plant_bench.scoring.laws import Law
from plant_bench.scoring.significance import holm


def differences_between(entries: Sequence[Entry], law: Law) -> tuple[Difference, ...]:
    """Return the differences of all pairs that share scenarios, p corrected for their number."""
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
