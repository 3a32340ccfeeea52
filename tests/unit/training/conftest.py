"""A hand-made data folder: an ego drives along a straight road behind a car."""

import json
import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch

from plant_bench.data.recorder import Recorder
from plant_bench.data.tick_log import Action
from plant_bench.world.route import PROTOCOL, Route
from plant_bench.world.scene import TICK, Scene
from tests.builders import cars, make_ego, make_scene, straight_route

SPEED, HEADING = 8.0, 0.5  # m/s, radians
NORTH_EAST = np.array([math.cos(HEADING), math.sin(HEADING)])


def route_of(name: str, town: str = "nowhere") -> Route:
    return straight_route(name=name, town=town, lane="a_0", heading=HEADING, speed_limit=13.0)


def scene_of(tick: int, *, leaves_at: int = 10_000, starts_at: int = 0) -> Scene:
    """The ego at SPEED from its start on; a leader 12 m ahead at that speed until it leaves."""
    x, y = ((2.0 + SPEED * max(tick - starts_at, 0) * TICK) * NORTH_EAST).tolist()
    leader = (14.0 + SPEED * tick * TICK) * NORTH_EAST
    return make_scene(
        tick,
        ego=make_ego(SPEED if tick >= starts_at else 0.0, x=x, y=y, yaw=HEADING),
        actors=cars((*leader, HEADING, SPEED), ids=[3]) if tick < leaves_at else None,
    )


def write_recording(
    path: Path,
    route: Route,
    ticks: int = 260,
    *,
    every: int = 1,
    disturbed: range = range(0),
    protocol: str = PROTOCOL,
    answers: Callable[[int], Action] = lambda _tick: None,
    **facts: int,
) -> Path:
    about = {"route": route.id, "route_checksum": route.checksum, "protocol": protocol}
    recorder = Recorder(path, about, every=every)
    for tick in range(ticks):
        recorder.add(scene_of(tick, **facts), answers(tick), disturbed=tick in disturbed)
    recorder.close()
    return path


def write_routes(folder: Path, routes: list[Route]) -> None:
    folder.mkdir(parents=True)
    payload = {"format": 1, "routes": [route.to_payload() for route in routes]}
    (folder / "suite.json").write_text(json.dumps(payload), encoding="utf-8")


@pytest.fixture(autouse=True)
def one_thread() -> None:
    torch.set_num_threads(1)


@pytest.fixture
def route() -> Route:
    return route_of("one")


@pytest.fixture
def write() -> Callable[..., Path]:
    """Writes a recording; see `write_recording`."""
    return write_recording


@pytest.fixture
def make_data(tmp_path: Path) -> Callable[..., Path]:
    """Makes a folder with an episode on each of the named routes; see `write_recording`."""

    def make(name: str, *driven: str, town: str = "nowhere", **facts: Any) -> Path:
        folder = tmp_path / name
        routes = {route: route_of(route, town) for route in sorted(set(driven))}
        write_routes(folder / "routes", list(routes.values()))
        for episode, route in zip("abcdefgh", driven, strict=False):
            write_recording(folder / "episodes" / f"{episode}.parquet", routes[route], **facts)
        return folder

    return make


@pytest.fixture
def data(make_data: Callable[..., Path]) -> Path:
    """Three episodes on two routes."""
    return make_data("data", "one", "two", "one")
