"""Settings for all tests, and hand-made run folders."""

import json
from collections.abc import Callable
from pathlib import Path

import pytest
from hypothesis import settings

from plant_bench.scoring.results import EpisodeResult

settings.register_profile("ci", derandomize=True, max_examples=50, deadline=None)
settings.load_profile("ci")

PROTOCOL = "longest6-sumo-v2-rc2"
MEASURES = {
    "ttc_vehicle": 1.5,
    "ttc_vulnerable": None,
    "pet_vehicle": 0.8,
    "pet_vulnerable": None,
    "hard_brakes": 2,
    "hard_brake_share": 0.01,
    "jerk_p95": 3.25,
    "lateral_acceleration_p95": 2.5,
    "relative_speed": 0.8,
    "standing_share": 0.3,
    "off_lane_distance": 0.0,
    "wrong_lane_distance": 0.0,
}
RunWriter = Callable[..., Path]


def _record(
    agent: str,
    route: int,
    repetition: int,
    hits: int,
    *,
    protocol: str,
    checksum: str,
    reason: str,
    density: str,
) -> EpisodeResult:
    town = f"town0{1 + route % 2}"
    return EpisodeResult.model_validate(
        {
            "protocol": protocol,
            "agent": agent,
            "agent_checksum": checksum,
            "inputs": ("objects", "route"),
            "route": f"{town}-{route}",
            "town": town,
            "scenario": f"{route}-{repetition}",
            "repetition": repetition,
            "seed": 7 * route + repetition,
            "density": density,
            "town_checksum": "b" * 64,
            "route_checksum": "c" * 64,
            "status": "Completed",
            "reason": reason,
            "route_length": 1000.0 + route / 3.0,
            "completion": 1.0,
            "distance": 1001.0 + route / 7.0,
            "duration": 100.05,
            "infractions": [
                {
                    "kind": "collision_vehicle",
                    "time": 20.5 + number,
                    "x": 1.0,
                    "y": 2.0,
                    "progress": 105.0,
                    "actor": 12,
                    "actor_kind": 0,
                    "cause": "ego",
                }
                for number in range(hits)
            ],
            "measures": MEASURES,
            "hazards": [{"kind": "cut_in", "at": 100.0, "phase": "done", "time": 20.0}],
        }
    )


def _write_run(
    path: Path,
    agent: str = "scripted",
    *,
    worse: int = 3,
    routes: int = 6,
    repetitions: int = 2,
    protocol: str = PROTOCOL,
    checksum: str = "a" * 64,
    reason: str = "",
    suite: str = "longest6",
    density: str = "dense",
    recorded: bool = False,
) -> Path:
    """Write a run's folder; on one route in `worse` the agent hits a vehicle."""
    for part in ("episodes", "recordings", "timing"):
        (path / part).mkdir(parents=True)
    facts = {"protocol": protocol, "checksum": checksum, "reason": reason, "density": density}
    for route in range(routes):
        for repetition in range(repetitions):
            hits = int((route + repetition) % worse == 0)
            record = _record(agent, route, repetition, hits, **facts)
            name = f"{record.route}_r{repetition}_{route:04x}{repetition:04x}"
            (path / "episodes" / f"{name}.json").write_text(record.to_json(), encoding="utf-8")
            if recorded:
                (path / "recordings" / f"{name}.parquet").write_bytes(b"")
    run = {
        "agent": agent,
        "agent_checksum": checksum,
        "suite": suite,
        "seed": 0,
        "density": density,
        "hazards": True,
        "protocol": protocol,
        "towns": {},
        "routes": {f"town0{1 + route % 2}-{route}": "c" * 64 for route in range(routes)},
        "repetitions": repetitions,
        "command": f"plant-bench score --agent {agent}",
        "versions": {},
        "processor": "a processor",
    }
    (path / "run.json").write_text(json.dumps(run), encoding="utf-8")
    return path


@pytest.fixture
def write_run() -> RunWriter:
    """Write the folder of a run: path, agent, then facts by name."""
    return _write_run
