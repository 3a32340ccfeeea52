"""Episodes and checkpoint files for the tests of the interchange."""

import json
from pathlib import Path
from typing import Any

from plant_bench.scoring.infractions import Infraction, InfractionKind, Status
from plant_bench.scoring.results import EpisodeResult, HazardRecord
from plant_bench.world.hazard import HazardKind, Phase
from plant_bench.world.scene import ActorKind

NINE = [
    "collisions_layout", "collisions_pedestrian", "collisions_vehicle", "outside_route_lanes",
    "red_light", "route_dev", "route_timeout", "stop_infraction", "vehicle_blocked",
]  # fmt: skip


def episode(route: str = "town01-0", repetition: int = 0, **changes: Any) -> EpisodeResult:
    """An episode with one hit, half a kilometre driven of a whole one."""
    hit = Infraction(
        kind=InfractionKind.COLLISION_VEHICLE, time=3.1, x=1.5, y=-2.25, progress=30.0,
        actor=17, actor_kind=ActorKind.BUS, cause="ego",
    )  # fmt: skip
    outside = Infraction(
        kind=InfractionKind.OUTSIDE_LANES, time=99.0, x=9.0, y=8.0, progress=500.0, share=0.04
    )
    known: dict[str, Any] = {
        "protocol": "longest6-sumo-v2-rc2", "agent": "plant", "agent_checksum": "c0ffee",
        "inputs": ("objects", "route"), "route": route, "town": route.partition("-")[0],
        "scenario": "0123456789abcdef", "repetition": repetition, "seed": 7, "density": "dense",
        "town_checksum": "aa", "route_checksum": "bb", "status": Status.BLOCKED,
        "route_length": 1000.0, "completion": 0.5, "distance": 510.0, "duration": 99.0,
        "infractions": (hit, outside),
        "hazards": (HazardRecord(kind=HazardKind.CROSSING, at=5.0, phase=Phase.DONE, time=1.0),),
    }  # fmt: skip
    return EpisodeResult(**(known | changes))


def carla_record(route_id: str, **infractions: list[str]) -> dict[str, Any]:
    """A record as leaderboard 1.0 writes it: 1 km long, three quarters driven."""
    return {
        "index": 0,
        "infractions": {name: [] for name in NINE} | infractions,
        "meta": {"duration_game": 100.5, "duration_system": 300.25, "route_length": 1000.0},
        "route_id": route_id,
        "scores": {"score_composed": 45.0, "score_penalty": 0.6, "score_route": 75.0},
        "status": "Failed - Agent got blocked",
    }


def scored_record(route: int, score: float, length: float = 1500.0) -> dict[str, Any]:
    """A record as leaderboard 1.0 writes it: driven completely, with a length in metres."""
    scores = {"score_composed": score, "score_penalty": score / 100, "score_route": 100.0}
    meta = {"duration_game": 60.0, "duration_system": 90.0, "route_length": length}
    changes = {"scores": scores, "meta": meta, "status": "Completed"}
    return carla_record(f"RouteScenario_{route}") | changes


def bench2drive_record(route: int, score: float, repetition: int = 0) -> dict[str, Any]:
    """A record as Bench2Drive writes it, but without `index`, which merged files lack."""
    record: dict[str, Any] = {**scored_record(route, score, 120.0), "num_infractions": 0}
    del record["index"]
    record["infractions"] |= {"min_speed_infractions": [], "scenario_timeouts": []}
    more = {"scenario_name": "Some_1", "weather_id": "3", "save_name": "r", "town_name": "Town05"}
    return record | more | {"route_id": f"RouteScenario_{route}_rep{repetition}"}


def merged_file(records: list[dict[str, Any]]) -> dict[str, Any]:
    """A file as Bench2Drive's `merge_route_json.py` writes it: its score is over 220 routes."""
    total = sum(item["scores"]["score_composed"] for item in records)
    numbers = {"driving score": total / 220, "success rate": 0.01, "eval num": len(records)}
    return {"_checkpoint": {"records": records}, **numbers}


def part_file(
    records: list[dict[str, Any]], total: int | None = None, status: str = "Finished"
) -> dict[str, Any]:
    """A worker's file: its progress says how many records it has, of a total."""
    made = carla_file(records, entry_status=status)
    progress = [len(records), len(records) if total is None else total]
    made["_checkpoint"]["progress"] = progress
    return made


def carla_file(records: list[dict[str, Any]], labels: int = 12, **top: Any) -> dict[str, Any]:
    """A file as leaderboard 1.0 writes it, with its known wrong global rates."""
    return {
        "_checkpoint": {
            "global_record": {"infractions": dict.fromkeys(NINE, 123.0), "index": -1},
            "progress": [len(records), len(records)],
            "records": records,
        },
        "eligible": False,
        "entry_status": "Finished",
        "labels": [str(number) for number in range(labels)],
        "sensors": [],
        "values": ["0.000"] * labels,
        **top,
    }


def written(folder: Path, content: object, name: str = "expert.json") -> Path:
    """Write a file as it is given."""
    path = folder / name
    path.write_text(content if isinstance(content, str) else json.dumps(content), "utf-8")
    return path
