"""Parses and validates the responses of a planner's process."""

from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field, TypeAdapter, ValidationError

from plant_bench.agent import Cause
from plant_bench.agents.remote.codec import MOST_PASSES, unpack
from plant_bench.agents.remote.messages import PROTOCOL_VERSION
from plant_bench.agents.remote.remote_errors import ProtocolError, raised_remotely, tidy

MOST_INPUTS = 100
Text = Annotated[str, Field(max_length=10_000)]
Count = Annotated[int, Field(ge=0, lt=1 << 62)]
Seconds = Annotated[float, Field(ge=0.0, allow_inf_nan=False)]
Pass = Annotated[tuple[Seconds, Count], Field(strict=False)]  # msgpack has lists only


class _Response(BaseModel):
    model_config = ConfigDict(strict=True, extra="forbid", frozen=True)


class Hello(_Response):
    """A planner's description of itself.

    Attributes:
        protocol: The protocol version.
        about: One-line description.
        inputs: The inputs that it declares.
        interval: Ticks until its second decision.
        ranks: Whether it supports "rank".
        files: Its files, apart from those in the command; part of the checksum.
        libraries: The Python packages that it computes with; their versions are part of the
            checksum.
    """

    type: Literal["hello"]
    protocol: int
    inputs: Annotated[list[Text], Field(max_length=MOST_INPUTS)]
    about: Text = ""
    interval: int = 1
    ranks: bool = False
    files: Annotated[list[Text], Field(max_length=10_000)] = []
    libraries: Annotated[list[Text], Field(max_length=MOST_INPUTS)] = []


class Ready(_Response):
    """The planner has been reset."""

    type: Literal["ready"]
    interval: int = 1


class ReportedReason(_Response):
    """Why a planner acted as it did."""

    cause: Annotated[int, Field(ge=min(Cause), le=max(Cause))]
    actor: int = -1


class _Decision(_Response):
    interval: int = 1
    reason: ReportedReason | None = None
    passes: Annotated[list[Pass], Field(max_length=MOST_PASSES)] = []
    explain_failed: Text | None = None


class ControlResponse(_Decision):
    """A decision as a control; `check_action` checks that it is finite."""

    type: Literal["control"]
    acceleration: float
    steering: float


class PlanResponse(_Decision):
    """A decision as a plan; `check_action` checks its shape."""

    type: Literal["plan"]
    waypoints: dict[str, Any]


class Ranks(_Response):
    """The relevance of each actor."""

    type: Literal["ranks"]
    values: dict[str, Any]


class Failed(_Response):
    """The planner's code has raised an exception."""

    type: Literal["failed"]
    error: Text
    message: Text


Response = Hello | Ready | ControlResponse | PlanResponse | Ranks | Failed
_READER: TypeAdapter[Response] = TypeAdapter(Annotated[Response, Field(discriminator="type")])
_KINDS = ("hello", "ready", "control", "plan", "ranks", "failed")


def response_in(data: bytes, *expected: type[BaseModel]) -> Any:
    """Return a planner's response, parsed as one of the expected types.

    Raises:
        ProtocolError: It is none of them.
        RemoteError: The planner reports that its code raised an exception.
    """
    message = unpack(data)
    if message.get("type") not in _KINDS:
        wrong = f"it sent a message of unknown type, expected one of {', '.join(_KINDS)}."
        raise ProtocolError(wrong)
    if message["type"] == "hello" and message.get("protocol") != PROTOCOL_VERSION:
        wrong = f"it does not speak version {PROTOCOL_VERSION} of the protocol."
        raise ProtocolError(wrong)
    try:
        response = _READER.validate_python(message)
    except ValidationError as error:
        raise ProtocolError(_first(error, message["type"])) from error
    if isinstance(response, Failed):
        raise raised_remotely(response.error, response.message)
    if not isinstance(response, expected):
        wrong = f"it sent an unexpected '{response.type}'."
        raise ProtocolError(wrong)
    return response


def _first(error: ValidationError, kind: str) -> str:
    found = error.errors(include_url=False, include_context=False, include_input=False)[0]
    where = ".".join(map(str, found["loc"][1:]))[:100]
    return tidy(f"its '{kind}' has a wrong {where or 'shape'}: {found['msg']}.")
