"""The kinds of infraction and the tables of what each costs (`scoring.penalties` says how)."""

from enum import StrEnum

from pydantic import BaseModel, ConfigDict

from plant_bench.world.scene import ActorKind


class InfractionKind(StrEnum):
    """Everything the referee can hold against a driver; names follow the CARLA leaderboard."""

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
    # OUTSIDE_LANES costs its share of the distance driven; the last three end the episode and cost
    # through route completion alone.
    InfractionKind.ROUTE_DEVIATION: 1.0,
    InfractionKind.BLOCKED: 1.0,
    InfractionKind.TIMEOUT: 1.0,
}

COEFFICIENTS: dict[InfractionKind, float] = {
    # CARLA leaderboard 2.1, leaderboard/utils/statistics_manager.py. OUTSIDE_LANES and what ends
    # the episode cost as above; stop signs, minimum speed, scenario time-outs and emergency
    # vehicles, which cost there too, are no rules of this benchmark.
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
        kind: What happened.
        time: Seconds since the start of the episode.
        x: Where the ego's centre was, metres.
        y: As x.
        progress: Arc length on the route, metres.
        actor: The other actor's id, if there is one.
        actor_kind: What it was.
        cause: "ego" (ego into other) or "other" (other into ego); for collisions only. Both count.
        share: For OUTSIDE_LANES: the share of the distance driven outside, 0 to 1.
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
        """What the infraction score is multiplied by (leaderboard 1.0)."""
        if self.kind is InfractionKind.OUTSIDE_LANES:
            return 1.0 - (self.share or 0.0)
        return PENALTIES[self.kind]
