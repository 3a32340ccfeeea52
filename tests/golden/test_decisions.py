"""Decisions and inputs of planners in random scenes, stored before their loops were compiled."""

import json
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from plant_bench.agent import PATH_POSES, Observation, Privileged, RouteAhead
from plant_bench.agents.careful.driver import CarefulDriver
from plant_bench.agents.careful.forecast import along_true_lanes, straight_on
from plant_bench.agents.careful.motion_forecast import MotionForecast
from plant_bench.features.motion import rates_between
from plant_bench.features.tokens import TokenSpec, tokens_of
from plant_bench.world.scene import Actors, EgoState

WANTED = Path(__file__).with_name("decisions.json")
SCENES = 120
TOLD = TokenSpec(conflicts=True, motion=True, horizon=3.0, vulnerable=True)


def actors(draw: np.random.Generator, line: np.ndarray) -> Actors:
    """Return actors that stand, drive and walk along and across a line."""
    count = int(draw.integers(1, 9))
    near = line[draw.integers(0, min(len(line), 50), count)]
    poses = np.column_stack((near + draw.normal(0.0, 4.0, (count, 2)), draw.uniform(-3, 3, count)))
    speeds = np.where(draw.random(count) < 0.3, 0.0, draw.uniform(0.0, 12.0, count))
    extents = np.column_stack((draw.uniform(0.6, 12.0, count), draw.uniform(0.5, 2.5, count)))
    kinds = draw.integers(0, 8, count).astype(np.uint8)
    places, paces, sizes = (part.astype(np.float32) for part in (poses, speeds, extents))
    return Actors(np.arange(count), places, paces, sizes, kinds)


def observation(seed: int) -> Observation:
    draw = np.random.default_rng(seed)
    steps = int(draw.integers(12, 102))
    headings = np.cumsum(draw.normal(0.0, 0.03, steps))
    line = np.cumsum(np.column_stack((np.cos(headings), np.sin(headings))), axis=0)
    speed = float(draw.choice([0.0, 0.05, 4.0, 9.0, 14.0]))
    ego = EgoState(float(line[0, 0]), float(line[0, 1]), float(draw.uniform(-0.3, 0.3)), speed)
    limits = draw.uniform(2.0, 14.0, steps)
    route = RouteAhead(0.0, float(draw.uniform(0.0, 1.0)), 0.0, line, headings, limits)
    others = actors(draw, line)
    count = len(others)
    way = np.arange(PATH_POSES)[:, None] * draw.uniform(-1.0, 1.0, (count, 1, 2))
    yaws = np.broadcast_to(others.poses[:, None, 2:].astype(float), (count, PATH_POSES, 1))
    paths = np.concatenate((others.poses[:, None, :2] + way, yaws), axis=2)
    stops = np.where(draw.random(count) < 0.5, math.inf, draw.uniform(-2.0, 30.0, count))
    facts = Privileged(
        paths, draw.normal(0.0, 2.0, count), draw.uniform(1.0, 15.0, count), stops, np.zeros(count)
    )
    return Observation(1.0, ego, 10.0, others, route, None, facts)


def decided(seed: int) -> dict[str, list]:
    """Return the decisions and inputs in a scene, after another scene half a second earlier."""
    now = observation(seed)
    assert now.actors is not None
    assert now.route is not None
    before = replace(
        now.actors,
        poses=(now.actors.poses - np.float32(0.3)).astype(np.float32),
        speeds=np.maximum(now.actors.speeds - np.float32(0.5), np.float32(0.0)),
    )
    tracked = MotionForecast()
    tracked.update(replace(now, time=0.5, actors=before))
    tracked.update(now)
    found: dict[str, list] = {}
    for name, way in (("expert", along_true_lanes), ("rules", straight_on), ("tracks", tracked)):
        driver = CarefulDriver(way)
        control, reason = driver.act(now), driver.explain()
        found[name] = [control.acceleration, control.steering, reason.cause.value, reason.actor]
    rates = rates_between(before, now.actors, 0.5)
    tokens = tokens_of(now.ego, now.actors, now.route, TOLD, None, rates)
    found["tokens"] = tokens.attributes.astype(float).round(4).ravel().tolist()
    return found


@pytest.mark.parametrize("seed", range(SCENES))
def test_planner_decisions_and_inputs_match_the_stored_ones(seed: int) -> None:
    wanted = json.loads(WANTED.read_text(encoding="utf-8"))[seed]
    found = decided(seed)
    for name in ("expert", "rules", "tracks"):
        assert found[name][2:] == wanted[name][2:], name
        assert found[name][:2] == pytest.approx(wanted[name][:2], abs=1e-6), name
    assert found["tokens"] == pytest.approx(wanted["tokens"], abs=2e-4)
