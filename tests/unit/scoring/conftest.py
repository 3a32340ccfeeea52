"""Hand-made episodes."""

from collections.abc import Callable

import pytest

from plant_bench.scoring.infractions import Infraction, InfractionKind, Status
from plant_bench.scoring.results import EpisodeResult

Episodes = Callable[..., EpisodeResult]


def _episode(
    route: int = 0,
    repetition: int = 0,
    *,
    completion: float = 1.0,
    length: float = 1000.0,
    kinds: tuple[str, ...] = (),
    cause: str = "ego",
    share: float | None = None,
    status: Status = Status.COMPLETED,
    **facts: object,
) -> EpisodeResult:
    infractions = [
        Infraction(
            kind=InfractionKind(kind),
            time=1.0,
            x=0.0,
            y=0.0,
            progress=0.0,
            cause=cause if "collision" in kind else None,
        )
        for kind in kinds
    ]
    if share is not None:
        kind = InfractionKind.OUTSIDE_LANES
        infractions.append(Infraction(kind=kind, time=1.0, x=0.0, y=0.0, progress=0.0, share=share))
    town = 1 + route % 2
    return EpisodeResult.model_validate(
        {
            "protocol": "longest6-sumo-v2-rc2",
            "agent": "scripted",
            "agent_checksum": "a" * 64,
            "inputs": ("objects",),
            "route": f"town0{town}-{route}",
            "town": f"town0{town}",
            "scenario": f"{route}-{repetition}",
            "repetition": repetition,
            "seed": repetition,
            "density": "dense",
            "town_checksum": "b" * 64,
            "route_checksum": "c" * 64,
            "status": status,
            "route_length": length,
            "completion": completion,
            "distance": completion * length,
            "duration": 100.0,
            "infractions": infractions,
            **facts,
        }
    )


@pytest.fixture
def episode() -> Episodes:
    """Make an episode of a route and a repetition."""
    return _episode
