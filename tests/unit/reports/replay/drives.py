"""Synthetic drives on a real route, recorded as the benchmark records them."""

from pathlib import Path

import numpy as np

from plant_bench.agent import Cause, Control, Plan, Reason
from plant_bench.data.recorder import Recorder
from plant_bench.reports.replay.replay_source import ReplaySource
from plant_bench.scoring.infractions import Infraction, InfractionKind, Status
from plant_bench.scoring.results import EpisodeHeader, EpisodeResult, HazardRecord
from plant_bench.world.hazard import HazardKind, Phase
from plant_bench.world.route import PROTOCOL, Route, Scenario, load_suite
from plant_bench.world.scene import TICK, ActorKind, Scene
from plant_bench.world.town import town_checksum
from tests.builders import make_actors, make_ego, make_scene

HIT_AT = 2.0  # s
SPEED = 8.0  # m/s


def some_route() -> Route:
    return load_suite("longest6")[0]


def header(route: Route, **changes: object) -> EpisodeHeader:
    facts: dict[str, object] = {
        "protocol": PROTOCOL,
        "agent": "cruise",
        "agent_checksum": "0" * 64,
        "inputs": ("objects", "route"),
        "route": route.id,
        "town": route.town,
        "scenario": Scenario(route, 1).key,
        "repetition": 0,
        "seed": 1,
        "density": "dense",
        "town_checksum": town_checksum(route.town),
        "route_checksum": route.checksum,
    }
    return EpisodeHeader.model_validate(facts | changes)


def result(route: Route, seconds: float, *, reason: str = "", **changes: object) -> EpisodeResult:
    x, y = route.points[int(HIT_AT * SPEED)].tolist()
    hit = Infraction(
        kind=InfractionKind.COLLISION_VEHICLE,
        time=HIT_AT,
        x=x,
        y=y,
        progress=HIT_AT * SPEED,
        actor=1,
        actor_kind=ActorKind.CAR,
        cause="ego",
    )
    light = hit.model_copy(
        update={"kind": InfractionKind.RED_LIGHT, "time": 3.0, "actor": None, "cause": None}
    )
    return EpisodeResult(
        **header(route, **changes).model_dump(),
        status=Status.TIMED_OUT,
        reason=reason,
        route_length=route.length,
        completion=0.5,
        distance=SPEED * seconds,
        duration=seconds,
        infractions=(hit, light) if seconds > HIT_AT else (),
        hazards=(HazardRecord(kind=HazardKind.CUT_IN, at=30.0, phase=Phase.DONE, time=1.0),),
    )


def scene(route: Route, tick: int, actors: int) -> Scene:
    """Return a scene: the ego on its route, actor 0 on it ahead, the others about."""
    at = min(SPEED * tick * TICK, route.length - 20.0)
    x, y = (float(np.interp(at, route.along, column)) for column in route.points.T)
    yaw = float(np.interp(at, route.along, route.headings))
    numbers = np.arange(actors)
    poses = np.stack(
        [
            x + 12.0 * np.cos(yaw) + 5.0 * numbers + np.sin(tick * 0.01 + numbers),
            y + 12.0 * np.sin(yaw) + 7.0 * (numbers % 9) + np.cos(tick * 0.02 * (numbers % 3)),
            np.angle(np.exp(1j * (yaw + 0.3 * numbers + 0.05 * tick))),
        ],
        axis=1,
    )
    others = make_actors(poses, speeds=3.0, kinds=numbers % len(ActorKind), ids=numbers + 1)
    if 20 <= tick < 40:
        others = others.only(others.ids != 2)  # out of sight for a second
    lights = np.full(len(route.signal_passages), 1 + tick // 30 % 3, np.uint8)
    ego = make_ego(SPEED, x=x, y=y, yaw=yaw, acceleration=0.1)
    return make_scene(tick, ego=ego, actors=others, lights=lights)


def drive(
    folder: Path,
    *,
    run: str = "ours",
    title: str = "cruise",
    agent: str = "cruise",
    seconds: float = 4.0,
    actors: int = 9,
    every: int = 1,
    plans: bool = True,
    reason: str = "",
    **changes: object,
) -> ReplaySource:
    """Record a drive and return it as the source of a replay."""
    route = some_route()
    told = result(route, seconds, reason=reason, **{"agent": agent} | changes)
    path = folder / run / "recordings" / "town01-0_r0_abc.parquet"
    recorder = Recorder(path, header(route, **changes).model_dump(mode="json"), every=every)
    waypoints = np.stack([np.arange(1.0, 5.0) * SPEED / 2.0, np.full(4, 0.2)], axis=1)
    for tick in range(round(seconds / TICK) + 1):
        action = Plan(waypoints) if plans else Control(0.1, 0.0)
        why = None if plans else Reason(Cause.LEADER, 1)
        recorder.add(scene(route, tick, actors), action if tick % 2 == 0 else None, why)
    recorder.close()
    return ReplaySource(f"{run}/town01-0_r0_abc", title, agent, path, told)
