"""Routes, a suite on disk and scripted episodes for the runner's tests."""

import json
from collections.abc import Callable
from pathlib import Path

import pytest

from plant_bench.world.route import ROUTE_FORMAT, Route
from tests.builders import first_lane, straight_route

SCRIPTED = "scripted_episode:run_episode"


def make_route(name: str, metres: int = 40) -> Route:
    lane = first_lane("town01")
    return straight_route(metres, name=name, town="town01", lane=lane, speed_limit=8.33)


def save_suite(path: Path, *routes: Route) -> Path:
    payload = {"format": ROUTE_FORMAT, "routes": [route.to_payload() for route in routes]}
    path.write_text(json.dumps(payload), encoding="utf-8")
    return path


@pytest.fixture
def route() -> Callable[..., Route]:
    """Make a route of 40 m that has this id; see `make_route`."""
    return make_route


@pytest.fixture
def suite_file() -> Callable[..., Path]:
    """Write a file of routes; see `save_suite`."""
    return save_suite


@pytest.fixture
def script(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Path:
    """Let workers import the scripted modules; the fixture is the file that lists what ran."""
    monkeypatch.syspath_prepend(str(Path(__file__).parent))
    log = tmp_path / "script.log"
    log.touch()
    monkeypatch.setenv("SCRIPT_LOG", str(log))
    return log
