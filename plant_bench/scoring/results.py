"""The record of one episode: everything that scores are computed from, and no wall-clock times."""

from dataclasses import dataclass
from pathlib import Path

from pydantic import BaseModel, ConfigDict, Field

from plant_bench.errors import InputError, in_one_line
from plant_bench.scoring.episode_measures import Measures
from plant_bench.scoring.episode_metrics import EPISODE_METRICS
from plant_bench.scoring.infractions import Infraction, Status
from plant_bench.scoring.penalties import PenaltyScheme, score_of
from plant_bench.untrusted_files import read_text
from plant_bench.world.hazard import HazardKind, Phase

RESULT_FORMAT = max(item.since for item in EPISODE_METRICS.values())  # 1 had no measures
MOST_REPETITIONS = 10_000  # of a route; more are taken for a mistake
LARGEST_NUMBER = 1e12  # metres or seconds; keeps sums finite
LARGEST_RECORD = 16_000_000  # bytes


class EpisodeHeader(BaseModel):
    """The part of a record that is known before the episode starts.

    Attributes:
        format: Version of the record format.
        protocol: Version of the rules.
        agent: The agent's name, as registered or as given.
        agent_checksum: Content hash of the agent's code and weights.
        inputs: The observation inputs that the agent used.
        route: Route id.
        town: Town name.
        scenario: `Scenario.key`.
        repetition: From 0.
        seed: The scenario's seed.
        density: The scenario's traffic density.
        town_checksum: Content hash of the road network.
        route_checksum: Content hash of the route.
    """

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    format: int = RESULT_FORMAT
    protocol: str
    agent: str
    agent_checksum: str
    inputs: tuple[str, ...]
    route: str
    town: str
    scenario: str
    repetition: int = Field(ge=0, lt=MOST_REPETITIONS)
    seed: int
    density: str
    town_checksum: str
    route_checksum: str


@dataclass(frozen=True)
class Crash:
    """A crash that ended an episode; stored in the recording by `close(**vars(crash))`.

    Attributes:
        status: `Status.AGENT_CRASHED` or `Status.SIMULATION_CRASHED`.
        reason: Error message of the agent or the simulator.
    """

    status: Status
    reason: str


class HazardRecord(BaseModel):
    """Outcome of one of the route's hazards.

    Attributes:
        kind: Kind of hazard.
        at: Metres along the route.
        phase: "done", "void", or the last phase reached when the episode ended.
        time: Seconds into the episode when it was triggered, else when it reached its last phase.
        reason: Why it is void, else empty.
    """

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    kind: HazardKind
    at: float
    phase: Phase
    time: float
    reason: str = ""


class EpisodeResult(EpisodeHeader):
    """One episode of one agent on one route; scores are properties, never stored.

    Attributes:
        status: How it ended.
        reason: Error message of the agent or the simulator if it crashed.
        route_length: Metres.
        completion: Share of the route completed, 0 to 1.
        distance: Metres driven.
        duration: Simulated seconds.
        infractions: In order of time.
        measures: Metrics besides the score; None in records of format 1 and without a scene.
        hazards: Outcomes of the route's hazards, in order; empty if the route has none.
    """

    status: Status
    reason: str = ""
    route_length: float = Field(gt=0, le=LARGEST_NUMBER)
    completion: float = Field(ge=0, le=1)
    distance: float = Field(ge=0, le=LARGEST_NUMBER)
    duration: float = Field(ge=0, le=LARGEST_NUMBER)
    infractions: tuple[Infraction, ...] = ()
    measures: Measures | None = None
    hazards: tuple[HazardRecord, ...] = ()

    @property
    def route_completion(self) -> float:
        """RC in percent."""
        return 100.0 * self.completion

    @property
    def infraction_score(self) -> float:
        """IS: the product of all penalties (CARLA leaderboard 1.0)."""
        return self.infraction_score_by(PenaltyScheme.LB1_0)

    @property
    def driving_score(self) -> float:
        """DS = RC x IS, 0 to 100 (CARLA leaderboard 1.0)."""
        return self.driving_score_by(PenaltyScheme.LB1_0)

    def infraction_score_by(self, penalties: PenaltyScheme) -> float:
        """Return the IS under a penalty scheme."""
        return score_of(self.infractions, penalties)

    def driving_score_by(self, penalties: PenaltyScheme) -> float:
        """Return the DS under a penalty scheme: RC x IS, 0 to 100."""
        return self.route_completion * self.infraction_score_by(penalties)

    def as_format(self, version: int) -> "EpisodeResult":
        """Return the record as an earlier version would have written it."""
        if version >= RESULT_FORMAT:
            return self
        measures = self.measures and self.measures.up_to(version)
        known = measures if measures and measures.root else None
        return self.model_copy(update={"format": version, "measures": known})

    def to_json(self) -> str:
        """Return the record as text; equal records give equal text."""
        absent = {name for name in ("measures", "hazards") if not getattr(self, name)}
        return self.model_dump_json(indent=1, exclude=absent) + "\n"

    @classmethod
    def load(cls, path: Path) -> "EpisodeResult":
        """Read a record.

        Raises:
            InputError: The file is not a record.
        """
        try:
            return cls.model_validate_json(read_text(path, largest=LARGEST_RECORD))
        except (OSError, ValueError) as error:
            message = (
                f"Not an episode record: {path} ({in_one_line(error)}). Remove it, or score again."
            )
            raise InputError(message) from error
