"""The towns of the suite `unseen`: the benchmark's town specs with other seeds.

They test generalisation, and are never used for training or model selection.
"""

from dataclasses import dataclass

SUITE = "unseen"
SUITE_SEED = 2000  # seed of routes and hazards; that of the benchmark is 6


@dataclass(frozen=True)
class UnseenTown:
    """Specification of a town of the suite.

    Attributes:
        base: The benchmark's town with the same spec, apart from name and seed.
        seed: Seed of its layout; the first that was tried.
    """

    base: str
    seed: int


UNSEEN = {
    f"unseen{number:02}": UnseenTown(f"town{number:02}", SUITE_SEED + number)
    for number in range(1, 7)
}
