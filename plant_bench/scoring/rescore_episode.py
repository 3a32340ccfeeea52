"""Scoring a recording again: the same verdict from the scenes alone, with no simulator."""

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
    """Judge a recording anew; without a change of rules the record is the one first written.

    It has the newest format; `as_format` takes it back to that of an older record.

    Args:
        recording: What was driven; its metadata is an `EpisodeHeader`, what became of the route's
            `hazards` and, after a crash, the `status` and `reason` of it.
        town: The town it was driven in.
        route: The route it was driven on.

    Raises:
        InputError: The recording is of another route, has no header or stops before the end.
    """
    known = dict(recording.metadata)
    status, reason = known.pop("status", None), str(known.pop("reason", ""))
    told = known.pop("hazards", [])
    try:
        hazards = TypeAdapter(tuple[HazardRecord, ...]).validate_python(told, strict=False)
        header = EpisodeHeader.model_validate(known | {"format": RESULT_FORMAT})
        crash = None if status is None else Crash(Status(str(status)), reason)
    except (ValidationError, ValueError) as error:
        message = f"The recording does not say what it is of: {error}"
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
