"""Hazards of a route as data, their phases and outcomes; `sim.hazards` simulates them."""

from dataclasses import dataclass, field
from enum import StrEnum
from typing import NamedTuple

from plant_bench.world.hazard_table import HazardKind


@dataclass(frozen=True)
class Hazard:
    """One hazard of a route.

    Attributes:
        kind: Kind of hazard.
        at: Arc length on the route of the conflict point, metres.
        arm: Arc length on the route; the hazard is armed when the ego reaches it, metres.
        seed: Seed of the random choices, together with the scenario's seed.
        parameters: Parameters of the kind, SI units; the kind's module lists them.
    """

    kind: HazardKind
    at: float
    arm: float
    seed: int
    parameters: dict[str, float] = field(default_factory=dict)

    def to_payload(self) -> dict:
        """Return the hazard as JSON values."""
        return {**vars(self), "kind": self.kind.value}

    @classmethod
    def from_payload(cls, payload: dict) -> "Hazard":
        """Read a payload of `to_payload`; raises KeyError, TypeError or ValueError if invalid."""
        places = {name: float(payload[name]) for name in ("at", "arm")}
        return cls(**{**payload, **places, "kind": HazardKind(payload["kind"])})


class Phase(StrEnum):
    """State of a hazard."""

    DORMANT = "dormant"
    ARMED = "armed"
    COMMITTED = "committed"
    DONE = "done"
    VOID = "void"


class HazardOutcome(NamedTuple):
    """Outcome of a hazard in one episode.

    Attributes:
        kind: Kind of hazard.
        at: Arc length on the route, metres.
        phase: DONE, VOID, or its phase when the episode ended.
        time: Time at which it was committed, or else reached its last phase, seconds.
        reason: Why it is void; else empty.
    """

    kind: HazardKind
    at: float
    phase: Phase
    time: float
    reason: str = ""
