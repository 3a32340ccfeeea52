"""Actions as numbers: a control scaled to the vehicle's limits, or a plan's waypoints."""

from typing import Any, Protocol, runtime_checkable

import numpy as np
from gymnasium import spaces
from jaxtyping import Float

from plant_bench.agent import PLAN_STEPS, Control, Plan
from plant_bench.errors import InputError
from plant_bench.sim.ego import ACCELERATION_LIMIT, BRAKING_LIMIT, STEERING_LIMIT

FARTHEST, ASIDE = 60.0, 30.0  # m: two seconds at 30 m/s, and to either side
BACKWARDS = -5.0  # m


@runtime_checkable
class ActionKind(Protocol):
    """What an action of the environment means."""

    @property
    def space(self) -> spaces.Box[Any]:
        """The actions."""
        ...

    def decode(self, action: Float[np.ndarray, "..."]) -> Plan | Control:
        """Return what the vehicle is asked for by an action inside the space."""
        ...


class ControlAction:
    """Acceleration and steering, each -1 to 1: of the hardest braking, throttle and steering."""

    def __init__(self) -> None:
        self.space = spaces.Box(-1.0, 1.0, (2,), np.float32)

    def decode(self, action: Float[np.ndarray, "..."]) -> Control:
        """Return the control; 0 is neither throttle nor brake, and straight on."""
        pedal, wheel = action.tolist()
        limit = BRAKING_LIMIT if pedal < 0.0 else ACCELERATION_LIMIT
        return Control(pedal * limit, wheel * STEERING_LIMIT)

    def encode(self, control: Control) -> Float[np.ndarray, " 2"]:
        """Return the action that asks for a control; what the vehicle cannot do is cut off."""
        limit = BRAKING_LIMIT if control.acceleration < 0.0 else ACCELERATION_LIMIT
        wanted = (control.acceleration / limit, control.steering / STEERING_LIMIT)
        return np.clip(np.array(wanted, np.float32), -1.0, 1.0)


class PlanAction:
    """Waypoints in the ego frame at 0.5, 1.0, 1.5 and 2.0 s, metres; `follow_plan` drives them."""

    def __init__(self) -> None:
        low = np.tile(np.array([BACKWARDS, -ASIDE], np.float32), (PLAN_STEPS, 1))
        high = np.tile(np.array([FARTHEST, ASIDE], np.float32), (PLAN_STEPS, 1))
        self.space = spaces.Box(low, high, dtype=np.float32)

    def decode(self, action: Float[np.ndarray, "..."]) -> Plan:
        """Return the plan."""
        return Plan(action.astype(float))


ACTIONS: dict[str, type[ControlAction] | type[PlanAction]] = {
    "control": ControlAction,
    "plan": PlanAction,
}


def action_kind(name: str) -> ActionKind:
    """Return a kind of action by its name.

    Raises:
        InputError: There is none of this name.
    """
    if name not in ACTIONS:
        message = f"There is no action kind {name!r}. Kinds: {', '.join(ACTIONS)}."
        raise InputError(message)
    return ACTIONS[name]()


def inside(action: object, space: spaces.Box[Any]) -> Float[np.ndarray, "..."]:
    """Return an action as an array of the space; what lies beyond the bounds is cut off.

    Raises:
        InputError: It has another shape, or values that are not finite.
    """
    try:
        given = np.asarray(action, dtype=space.dtype)
    except (TypeError, ValueError) as error:
        message = f"The action {action!r} is not numbers: an array of {space.shape} is wanted."
        raise InputError(message) from error
    if given.shape != space.shape or not np.isfinite(given).all():
        message = f"An action of shape {given.shape}: {space.shape} of finite numbers is wanted."
        raise InputError(message)
    return np.clip(given, space.low, space.high)
