"""What a planner may answer, checked to the last field: nothing it sends is believed."""

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
Pass = Annotated[tuple[Seconds, Count], Field(strict=False)]  # msgpack knows lists alone


class _Answer(BaseModel):
    model_config = ConfigDict(strict=True, extra="forbid", frozen=True)


class Hello(_Answer):
    """What a planner is.

    Attributes:
        protocol: The version it speaks.
        about: One line of itself.
        inputs: What it wants to be given.
        interval: Ticks between two decisions, before the first one.
        ranks: Whether it answers "rank".
        files: What it is made of, apart from what starts it: the checksum covers them.
        libraries: Packages of Python that it computes with: the checksum covers their versions.
    """

    type: Literal["hello"]
    protocol: int
    inputs: Annotated[list[Text], Field(max_length=MOST_INPUTS)]
    about: Text = ""
    interval: int = 1
    ranks: bool = False
    files: Annotated[list[Text], Field(max_length=10_000)] = []
    libraries: Annotated[list[Text], Field(max_length=MOST_INPUTS)] = []


class Ready(_Answer):
    """The episode may begin."""

    type: Literal["ready"]
    interval: int = 1


class Told(_Answer):
    """Why a planner acted as it did."""

    cause: Annotated[int, Field(ge=min(Cause), le=max(Cause))]
    actor: int = -1


class _Decision(_Answer):
    interval: int = 1
    reason: Told | None = None
    passes: Annotated[list[Pass], Field(max_length=MOST_PASSES)] = []
    explain_failed: Text | None = None


class ControlAnswer(_Decision):
    """A decision as a control; finiteness is the benchmark's to check."""

    type: Literal["control"]
    acceleration: float
    steering: float


class PlanAnswer(_Decision):
    """A decision as a plan; its shape is the benchmark's to check."""

    type: Literal["plan"]
    waypoints: dict[str, Any]


class Ranks(_Answer):
    """The relevance of each actor."""

    type: Literal["ranks"]
    values: dict[str, Any]


class Failed(_Answer):
    """The planner's own code raised."""

    type: Literal["failed"]
    error: Text
    message: Text


Answer = Hello | Ready | ControlAnswer | PlanAnswer | Ranks | Failed
_READER: TypeAdapter[Answer] = TypeAdapter(Annotated[Answer, Field(discriminator="type")])
_KINDS = ("hello", "ready", "control", "plan", "ranks", "failed")


def answer_in(data: bytes, *wanted: type[BaseModel]) -> Any:
    """Return a planner's answer as one of the kinds wanted.

    Raises:
        ProtocolError: It is none of them.
        RemoteError: The planner's code raised, by its own account.
    """
    message = unpack(data)
    if message.get("type") not in _KINDS:
        wrong = f"it sent a message of no known type: one of {', '.join(_KINDS)} is wanted."
        raise ProtocolError(wrong)
    if message["type"] == "hello" and message.get("protocol") != PROTOCOL_VERSION:
        wrong = f"it does not speak version {PROTOCOL_VERSION} of the protocol."
        raise ProtocolError(wrong)
    try:
        answer = _READER.validate_python(message)
    except ValidationError as error:
        raise ProtocolError(_first(error, message["type"])) from error
    if isinstance(answer, Failed):
        raise raised_remotely(answer.error, answer.message)
    if not isinstance(answer, wanted):
        wrong = f"it sent '{answer.type}' where that is no answer."
        raise ProtocolError(wrong)
    return answer


def _first(error: ValidationError, kind: str) -> str:
    found = error.errors(include_url=False, include_context=False, include_input=False)[0]
    where = ".".join(map(str, found["loc"][1:]))[:100]
    return tidy(f"its '{kind}' has a wrong {where or 'shape'}: {found['msg']}.")
