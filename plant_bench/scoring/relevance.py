"""Relative filtered driving score (RFDS): how well a ranking finds the relevant vehicle.

From PlanT, section 4.3. The expert drives the same scenarios twice: with all vehicles in its
observation, and with only the highest-ranked one. RFDS is the second driving score as a percentage
of the first.
"""

from collections.abc import Sequence
from dataclasses import dataclass

from plant_bench.errors import InputError
from plant_bench.scoring.metrics import Spread
from plant_bench.scoring.penalties import PenaltyScheme
from plant_bench.scoring.results import EpisodeResult


@dataclass(frozen=True)
class RelativeScore:
    """The RFDS of a ranking.

    Attributes:
        agent: The agent that drove filtered; its name contains the ranking.
        protocol: Version of the rules both drove under.
        penalties: The penalty scheme.
        score: RFDS in percent, over repetitions.
        filtered: DS of the expert with the filtered observation, 0 to 100, over repetitions.
        whole: DS of the expert with the complete observation, on the same scenarios.
        repetitions: RFDS of each repetition, in order.
        episodes: Number of scenarios that both drove.
        unmatched: Number of episodes that only one of the two has driven; they do not count.
        planner_checksum: Content hash of the planner that ranked; empty for rankers that need no
            planner, and if the file does not contain it.
    """

    agent: str
    protocol: str
    penalties: PenaltyScheme
    score: Spread
    filtered: Spread
    whole: Spread
    repetitions: tuple[float, ...]
    episodes: int
    unmatched: int
    planner_checksum: str = ""


def relative_score(
    whole: Sequence[EpisodeResult],
    filtered: Sequence[EpisodeResult],
    *,
    penalties: PenaltyScheme = PenaltyScheme.LB1_0,
    planner_checksum: str = "",
) -> RelativeScore:
    """Return the RFDS of the ranking that filtered the second agent's observation.

    Each repetition gives one RFDS: the ratio of the two mean driving scores over its scenarios.

    Args:
        whole: Episodes of the expert with the complete observation.
        filtered: Episodes of the expert with one vehicle in its observation; of one agent.
        penalties: The penalty scheme.
        planner_checksum: Content hash of the planner that ranked, if one did.

    Raises:
        InputError: The episodes have several protocols or agents, share no scenario, or the
            expert scores 0.
    """
    protocols = sorted({item.protocol for item in (*whole, *filtered)})
    agents = sorted({item.agent for item in filtered})
    if len(protocols) > 1 or len(agents) > 1:
        message = (
            f"Episodes of {', '.join(agents)} under {', '.join(protocols)}: expected one agent "
            "and one protocol."
        )
        raise InputError(message)
    first, second = _by_scenario(whole), _by_scenario(filtered)
    common = sorted(first.keys() & second.keys(), key=lambda key: (key[1], key[0]))
    if not common:
        message = "The two experts share no scenario: drive both on the same routes and seeds."
        raise InputError(message)
    numbers = sorted({repetition for _, repetition in common})
    parts = [[key for key in common if key[1] == number] for number in numbers]
    before = [_mean_score([first[key] for key in part], penalties) for part in parts]
    after = [_mean_score([second[key] for key in part], penalties) for part in parts]
    if min(before) <= 0.0:
        message = "The expert scores 0 in a repetition, so the relative score is undefined."
        raise InputError(message)
    ratios = tuple(100.0 * new / old for new, old in zip(after, before, strict=True))
    return RelativeScore(
        agent=agents[0],
        protocol=protocols[0],
        penalties=penalties,
        score=Spread.of(ratios),
        filtered=Spread.of(after),
        whole=Spread.of(before),
        repetitions=ratios,
        episodes=len(common),
        unmatched=len(first) + len(second) - 2 * len(common),
        planner_checksum=planner_checksum,
    )


def _by_scenario(results: Sequence[EpisodeResult]) -> dict[tuple[str, int], EpisodeResult]:
    return {(item.scenario, item.repetition): item for item in results}


def _mean_score(results: Sequence[EpisodeResult], penalties: PenaltyScheme) -> float:
    return sum(item.driving_score_by(penalties) for item in results) / len(results)
