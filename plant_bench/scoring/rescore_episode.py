"""Scores a recording again, from its scenes alone and without a simulator."""

from pydantic import TypeAdapter, ValidationError

from plant_bench.data.recording import Recording
from plant_bench.errors import InputError
from plant_bench.scoring.infractions import Status
from plant_bench.scoring.referee import Referee, result_of
from plant_bench.scoring.results import (
    RESULT_FORMAT,
    Crash,
    EpisodeHeader,
    EpisodeResult,
    HazardRecord,
)
from plant_bench.world.route import Route
from plant_bench.world.town import Town


def rescore(recording: Recording, town: Town, route: Route) -> EpisodeResult:
    """Score a recording again; if the rules are unchanged, the record equals the original one.

    It has the newest format; `as_format` converts it to that of an older record.

    Args:
        recording: The recording; its metadata is an `EpisodeHeader`, the outcomes of the route's
            `hazards` and, after a crash, its `status` and `reason`.
        town: The town it was driven in.
        route: The route it was driven on.

    Raises:
        InputError: The recording is of another route, has no header or ends early.
    """
    known = dict(recording.metadata)
    status, reason = known.pop("status", None), str(known.pop("reason", ""))
    outcomes = known.pop("hazards", [])
    try:
        hazards = TypeAdapter(tuple[HazardRecord, ...]).validate_python(outcomes, strict=False)
        header = EpisodeHeader.model_validate(known | {"format": RESULT_FORMAT})
        crash = None if status is None else Crash(Status(str(status)), reason)
    except (ValidationError, ValueError) as error:
        message = f"The recording has no valid episode header: {error}"
        raise InputError(message) from error
    if header.route_checksum != route.checksum:
        message = (
            f"The recording is of route {header.route} ({header.route_checksum[:12]}), "
            f"not of {route.id} ({route.checksum[:12]}) as it is now."
        )
        raise InputError(message)
    referee = Referee(town, route)
    for scene in recording:
        referee.judge(scene)
    return result_of(referee, header, crash=crash, hazards=hazards)
