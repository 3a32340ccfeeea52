"""The towns of the suite `unseen`: the benchmark's characters with other seeds.

A planner that drives here as well as in the benchmark's towns has learned to drive, not the towns.
Nobody trains in them, nor chooses anything by them.
"""

from dataclasses import dataclass

SUITE = "unseen"
SUITE_SEED = 2000  # of the drawing of routes and hazards; the benchmark's is 6


@dataclass(frozen=True)
class UnseenTown:
    """How a town of the suite is made.

    Attributes:
        base: The benchmark's town whose spec it has, but for name and seed.
        seed: Of its layout; the first one tried for each.
    """

    base: str
    seed: int


UNSEEN = {
    f"unseen{number:02}": UnseenTown(f"town{number:02}", SUITE_SEED + number)
    for number in range(1, 7)
}
