"""The observations of an agent, and that it cannot modify the simulation through them."""

from dataclasses import replace

import numpy as np
import pytest

from plant_bench.agent import Input, Observation
from plant_bench.sensing import observe as observing
from plant_bench.sensing.inputs import InputRow, Track
from plant_bench.sensing.observe import Sensors
from plant_bench.world.hazard import Hazard, HazardKind
from plant_bench.world.route import load_suite
from plant_bench.world.scene import Light, Scene
from tests.builders import make_ego, make_scene

ROUTE = load_suite("longest6")[0]


def scene_at(along: float, light: Light = Light.UNKNOWN) -> Scene:
    x, y = (float(np.interp(along, ROUTE.along, column)) for column in ROUTE.points.T)
    lights = np.full(len(ROUTE.signal_passages), light, np.uint8)
    return make_scene(3, ego=make_ego(5.0, x=x, y=y), lights=lights)


def observe(scene: Scene, progress: float, inputs: frozenset[str]) -> Observation:
    return Sensors(ROUTE, 0, inputs).observe(scene, progress, 0.0)


def test_undeclared_inputs_are_not_given() -> None:
    observation = observe(scene_at(10.0), 10.0, frozenset())
    assert observation.actors is None
    assert observation.route is None
    assert observation.light is None
    assert observation.privileged is None


def test_route_ahead_starts_at_the_last_point_passed() -> None:
    for progress in (0.0, 10.4, 500.9, ROUTE.length - 3.0):
        ahead = observe(scene_at(progress), progress, frozenset({Input.ROUTE})).route
        assert ahead is not None
        assert 0.0 <= ahead.past < 1.1
        begin = np.array([np.interp(progress - ahead.past, ROUTE.along, c) for c in ROUTE.points.T])
        assert ahead.points[0] == pytest.approx(begin, abs=1e-6)


def test_light_is_given_only_near_its_stop_line() -> None:
    inputs = frozenset({Input.LIGHT})
    entry = ROUTE.signal_entries[0]
    near = observe(scene_at(0.0, Light.RED), entry - 20.0, inputs).light
    assert near is not None
    assert (near.state, near.distance) == (Light.RED, pytest.approx(20.0 - 2.45))
    assert observe(scene_at(0.0, Light.RED), entry - 60.0, inputs).light is None
    on_the_line = observe(scene_at(0.0, Light.RED), entry, inputs).light
    assert on_the_line is not None
    assert on_the_line.distance < 0.0


def test_route_plan_hides_hazards_and_is_read_only() -> None:
    hazard = Hazard(HazardKind.CROSSING, 100.0, 40.0, 1)
    route = replace(ROUTE, hazards=(hazard,))
    assert route.plan.hazards == ()
    with pytest.raises(ValueError, match="read-only"):
        route.plan.points[:] = 0.0


@pytest.mark.parametrize("given", [[1.0, 2.0], None, np.array(["text"])])
def test_input_function_without_a_numeric_array_is_named(monkeypatch, given) -> None:
    row = InputRow("shade", Track.SENSORS, "an image", lambda moment: given)
    monkeypatch.setitem(vars(observing), "INPUTS", {"shade": row})
    monkeypatch.setitem(vars(observing), "check_inputs", lambda inputs, who: None)

    with pytest.raises(TypeError, match="Input 'shade': expected an array of numbers"):
        observe(scene_at(10.0), 10.0, frozenset({"shade"}))
