"""Routes, a suite on disk and scripted episodes for the runner's tests."""

import json
from pathlib import Path

import numpy as np
import pytest

from plant_bench.world.route import ROUTE_FORMAT, LaneSpan, Route
from plant_bench.world.town import load_town

SCRIPTED = "scripted_episode:run_episode"


def make_route(name: str, metres: int = 40) -> Route:
    count = metres + 1
    lane = next(iter(load_town("town01").edges.values()))[0]
    return Route(
        id=name,
        town="town01",
        points=np.stack([np.arange(count, dtype=float), np.zeros(count)], axis=1),
        elevations=np.zeros(count),
        speed_limits=np.full(count, 8.33),
        edges=(lane.edge,),
        lanes=(LaneSpan(lane.id, 0.0, float(metres)),),
        passages=(),
        lane_changes=(),
        manoeuvres={},
    )


def save_suite(path: Path, *routes: Route) -> Path:
    payload = {"format": ROUTE_FORMAT, "routes": [route.to_payload() for route in routes]}
    path.write_text(json.dumps(payload), encoding="utf-8")
    return path


@pytest.fixture
def route():
    return make_route


@pytest.fixture
def suite_file():
    return save_suite


@pytest.fixture
def script(monkeypatch, tmp_path):
    """Let workers import the scripted modules; the fixture is the file that lists what ran."""
    monkeypatch.syspath_prepend(str(Path(__file__).parent))
    log = tmp_path / "script.log"
    log.touch()
    monkeypatch.setenv("SCRIPT_LOG", str(log))
    return log
