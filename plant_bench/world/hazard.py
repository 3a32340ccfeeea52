"""Hazards as data: what may go wrong at which place of a route. `sim.hazards` plays them."""

from dataclasses import dataclass, field
from enum import StrEnum
from typing import NamedTuple

from plant_bench.world.hazard_table import HazardKind


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
