"""Hazards as data: what may go wrong at which place of a route. `sim.hazards` plays them."""

from dataclasses import dataclass, field
from enum import StrEnum
from typing import NamedTuple


class HazardKind(StrEnum):
    """The benchmark's hazards; the comment is the CARLA leaderboard's scenario type mirrored."""

    CONTROL_LOSS = "control_loss"  # 1
    CROSSING = "crossing"  # 3: a walker or rider mid-block
    CROSSING_AFTER_TURN = "crossing_after_turn"  # 4
    RED_LIGHT_RUNNER = "red_light_runner"  # 7
    UNPROTECTED_LEFT = "unprotected_left"  # 8
    RIGHT_TURN = "right_turn"  # 9
    UNSIGNALLED_CROSSING = "unsignalled_crossing"  # 10
    HARD_BRAKE = "hard_brake"  # beyond CARLA's ten, as all below
    CUT_IN = "cut_in"
    BLOCKED_LANE = "blocked_lane"
    MERGE_PRESSURE = "merge_pressure"
    QUEUE_TAIL = "queue_tail"


class HazardFacts(NamedTuple):
    """What people are told of a kind.

    Attributes:
        letter: Marks it on pictures.
        carla: The CARLA leaderboard's scenario type it mirrors, None beyond those.
        sentence: What happens.
    """

    letter: str
    carla: int | None
    sentence: str


HAZARDS = {
    HazardKind.CONTROL_LOSS: HazardFacts(
        "S", 1, "For a moment the road is slippery and the ego's wheels pull aside."
    ),
    HazardKind.CROSSING: HazardFacts(
        "X", 3, "A walker or rider crosses mid-block, also from behind a parked van."
    ),
    HazardKind.CROSSING_AFTER_TURN: HazardFacts(
        "A", 4, "A walker or rider crosses the street that the ego has just turned into."
    ),
    HazardKind.RED_LIGHT_RUNNER: HazardFacts(
        "R", 7, "A vehicle from the side ignores its red light while the ego has green."
    ),
    HazardKind.UNPROTECTED_LEFT: HazardFacts(
        "L", 8, "Oncoming vehicles, with and without gaps, while the ego turns left on green."
    ),
    HazardKind.RIGHT_TURN: HazardFacts(
        "T",
        9,
        "A vehicle comes from the left (at lights against its red) as the ego turns right.",
    ),
    HazardKind.UNSIGNALLED_CROSSING: HazardFacts(
        "U", 10, "A vehicle arrives together with the ego at a junction without lights."
    ),
    HazardKind.HARD_BRAKE: HazardFacts(
        "H", None, "The vehicle ahead brakes hard for no visible reason."
    ),
    HazardKind.CUT_IN: HazardFacts(
        "C", None, "A vehicle of the next lane changes closely in front of the ego."
    ),
    HazardKind.BLOCKED_LANE: HazardFacts(
        "B", None, "A van stands in the lane, and drives off after a wait."
    ),
    HazardKind.MERGE_PRESSURE: HazardFacts(
        "M", None, "The lane that the ego has to change to is taken by a row of vehicles."
    ),
    HazardKind.QUEUE_TAIL: HazardFacts("Q", None, "The ego comes upon the slow tail of a queue."),
}


@dataclass(frozen=True)
class Hazard:
    """One hazard of a route.

    Attributes:
        kind: What happens.
        at: Arc length on the route where the ego and the other would meet, metres.
        arm: Arc length from which on the hazard may begin.
        seed: Seeds what the kind leaves to chance, together with the scenario's seed.
        parameters: Numbers of the kind, SI units; each kind's module names them.
    """

    kind: HazardKind
    at: float
    arm: float
    seed: int
    parameters: dict[str, float] = field(default_factory=dict)

    def to_payload(self) -> dict:
        """Return the hazard as JSON-able values."""
        return {**vars(self), "kind": self.kind.value}

    @classmethod
    def from_payload(cls, payload: dict) -> "Hazard":
        """Read what `to_payload` gave; raises KeyError, TypeError or ValueError where it cannot."""
        places = {name: float(payload[name]) for name in ("at", "arm")}
        return cls(**{**payload, **places, "kind": HazardKind(payload["kind"])})


class Phase(StrEnum):
    """How far a hazard has come."""

    DORMANT = "dormant"
    ARMED = "armed"
    COMMITTED = "committed"
    DONE = "done"
    VOID = "void"


class HazardOutcome(NamedTuple):
    """What became of a hazard in one episode.

    Attributes:
        kind: What it was.
        at: Where, metres along the route.
        phase: DONE, VOID, or what it was when the episode ended.
        time: Seconds when it was committed, or the last phase was reached.
        reason: Why it is void.
    """

    kind: HazardKind
    at: float
    phase: Phase
    time: float
    reason: str = ""
