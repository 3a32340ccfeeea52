import math

import numpy as np
import pytest

from plant_bench.agent import Control
from plant_bench.runner.collect.perturbation import Perturbation
from plant_bench.sim.ego import advance
from plant_bench.world.scene import TICK
from tests.builders import make_ego, make_scene


def drive(seed, *, speed=10.0, seconds=60.0):
    """Drive along the x axis; return states, responses and executed controls."""
    perturbation = Perturbation(seed)
    ego, states, answers, executed = make_ego(speed), [], [], []
    for tick in range(int(seconds / TICK)):
        back = math.atan2(-ego.y, 5.0 + 0.5 * ego.speed) - ego.yaw
        answer = Control(min(max(speed - ego.speed, -3.0), 2.0), 0.8 * back)
        done = perturbation.executed(make_scene(tick, ego=ego), 0.0, ego.y, answer)
        states.append(ego)
        answers.append(answer)
        executed.append(done)
        ego = advance(ego, done)
    return states, answers, executed


def disturbed_ticks(answers, executed):
    return [i for i, pair in enumerate(zip(answers, executed, strict=True)) if pair[0] != pair[1]]


@pytest.mark.parametrize("speed", [4.0, 8.0, 14.0, 25.0])
def test_perturbation_displaces_the_ego_by_less_than_1_m(speed):
    offsets = [abs(state.y) for seed in range(4) for state in drive(seed, speed=speed)[0]]
    assert 0.1 < max(offsets) < 1.0


def test_perturbation_lasts_0_5_to_1_s():
    _, answers, executed = drive(0, seconds=200.0)
    ticks = disturbed_ticks(answers, executed)
    runs = np.split(np.array(ticks), np.flatnonzero(np.diff(ticks) > 1) + 1)
    assert len(runs) > 15
    assert max(map(len, runs)) <= 20
    assert 0.02 < len(ticks) / len(answers) < 0.15


def test_perturbation_changes_the_speed():
    _, answers, executed = drive(0, seconds=200.0)
    changed = {
        executed[i].steering != answers[i].steering for i in disturbed_ticks(answers, executed)
    }
    assert changed == {True, False}


def test_stationary_ego_is_not_perturbed():
    _, answers, executed = drive(0, speed=1.0)
    assert answers == executed


def test_equal_seeds_give_equal_perturbations():
    assert drive(3)[2] == drive(3)[2]
    assert drive(3)[2] != drive(4)[2]
