"""Actions as arrays: scaled to the vehicle's limits; anything else is refused."""

import numpy as np
import pytest

from plant_bench.agent import Control, Plan
from plant_bench.errors import InputError
from plant_bench.gym.actions import ControlAction, action_kind, inside
from plant_bench.sim.ego import ACCELERATION_LIMIT, BRAKING_LIMIT, STEERING_LIMIT


def test_control_action_spans_the_vehicle_limits() -> None:
    kind = ControlAction()
    full = kind.decode(np.array([1.0, -1.0], np.float32))
    hard = kind.decode(np.array([-1.0, 0.0], np.float32))
    assert full == Control(ACCELERATION_LIMIT, -STEERING_LIMIT)
    assert hard == Control(-BRAKING_LIMIT, 0.0)


@pytest.mark.parametrize("control", [Control(1.5, 0.2), Control(-6.0, -0.3), Control(0.0, 0.0)])
def test_control_action_round_trip(control: Control) -> None:
    kind = ControlAction()
    again = kind.decode(kind.encode(control))
    assert again.acceleration == pytest.approx(control.acceleration, abs=1e-6)
    assert again.steering == pytest.approx(control.steering, abs=1e-6)


def test_plan_action_is_its_waypoints() -> None:
    kind = action_kind("plan")
    points = np.arange(8, dtype=np.float32).reshape(4, 2)
    plan = kind.decode(inside(points, kind.space))
    assert isinstance(plan, Plan)
    assert np.array_equal(plan.waypoints, points)


def test_actions_beyond_the_bounds_are_clipped() -> None:
    space = action_kind("control").space
    assert inside([3.0, -2.0], space).tolist() == [1.0, -1.0]


@pytest.mark.parametrize("action", [[np.nan, 0.0], [0.0], "fast", None])
def test_invalid_actions_are_refused(action: object) -> None:
    with pytest.raises(InputError, match="expected"):
        inside(action, action_kind("control").space)


def test_unknown_action_kind_is_refused() -> None:
    with pytest.raises(InputError, match="control, plan"):
        action_kind("controls")
