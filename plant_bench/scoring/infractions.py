"""Kinds of infraction, their penalty factors and coefficients, and how episodes can end."""

from enum import StrEnum

from pydantic import BaseModel, ConfigDict

from plant_bench.world.scene import ActorKind


class InfractionKind(StrEnum):
    """All kinds of infraction; names follow the CARLA leaderboard."""

    COLLISION_PEDESTRIAN = "collision_pedestrian"
    COLLISION_VEHICLE = "collision_vehicle"
    COLLISION_STATIC = "collision_static"
    RED_LIGHT = "red_light"
    OUTSIDE_LANES = "outside_lanes"
    ROUTE_DEVIATION = "route_deviation"
    BLOCKED = "blocked"
    TIMEOUT = "timeout"


COLLISIONS = (
    InfractionKind.COLLISION_PEDESTRIAN,
    InfractionKind.COLLISION_VEHICLE,
    InfractionKind.COLLISION_STATIC,
)

PENALTIES: dict[InfractionKind, float] = {
    # CARLA leaderboard 1.0, leaderboard/utils/statistics_manager.py; Longest6 keeps these factors
    # and does not penalise stop signs (PlanT, section 4; protocol of TransFuser's Longest6).
    InfractionKind.COLLISION_PEDESTRIAN: 0.50,
    InfractionKind.COLLISION_VEHICLE: 0.60,
    InfractionKind.COLLISION_STATIC: 0.65,
    InfractionKind.RED_LIGHT: 0.70,
    # OUTSIDE_LANES costs its share of the distance driven. The last three end the episode, so they
    # cost route completion only.
    InfractionKind.ROUTE_DEVIATION: 1.0,
    InfractionKind.BLOCKED: 1.0,
    InfractionKind.TIMEOUT: 1.0,
}

COEFFICIENTS: dict[InfractionKind, float] = {
    # CARLA leaderboard 2.1, leaderboard/utils/statistics_manager.py. OUTSIDE_LANES and infractions
    # that end the episode cost as above. Its penalties for stop signs, minimum speed, scenario
    # timeouts and emergency vehicles do not exist in this benchmark.
    InfractionKind.COLLISION_PEDESTRIAN: 1.0,
    InfractionKind.COLLISION_VEHICLE: 0.7,
    InfractionKind.COLLISION_STATIC: 0.6,
    InfractionKind.RED_LIGHT: 0.4,
    InfractionKind.ROUTE_DEVIATION: 0.0,
    InfractionKind.BLOCKED: 0.0,
    InfractionKind.TIMEOUT: 0.0,
}


class Status(StrEnum):
    """How an episode ended; texts are the CARLA leaderboard's."""

    COMPLETED = "Completed"
    TIMED_OUT = "Failed - Agent timed out"
    BLOCKED = "Failed - Agent got blocked"
    DEVIATED = "Failed - Agent deviated from the route"
    AGENT_CRASHED = "Failed - Agent crashed"
    SIMULATION_CRASHED = "Failed - Simulation crashed"


class Infraction(BaseModel):
    """One infraction.

    Attributes:
        kind: Kind of infraction.
        time: Seconds since the start of the episode.
        x: Position of the ego's centre in the world frame, metres.
        y: As x.
        progress: Arc length on the route, metres.
        actor: The other actor's id, if there is one.
        actor_kind: The other actor's kind.
        cause: For collisions, "ego" (ego ran into other) or "other" (other ran into ego). Both
            count.
        share: For OUTSIDE_LANES, the share of the distance driven outside, 0 to 1.
    """

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    kind: InfractionKind
    time: float
    x: float
    y: float
    progress: float
    actor: int | None = None
    actor_kind: ActorKind | None = None
    cause: str | None = None
    share: float | None = None

    @property
    def factor(self) -> float:
        """Penalty factor of the infraction score (leaderboard 1.0)."""
        if self.kind is InfractionKind.OUTSIDE_LANES:
            return 1.0 - (self.share or 0.0)
        return PENALTIES[self.kind]
