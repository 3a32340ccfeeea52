"""Action spaces of the environment: a normalised control, or a plan's waypoints."""

from typing import Any, Protocol, runtime_checkable

import numpy as np
from gymnasium import spaces
from jaxtyping import Float

from plant_bench.agent import PLAN_STEPS, Control, Plan
from plant_bench.errors import InputError
from plant_bench.sim.ego import ACCELERATION_LIMIT, BRAKING_LIMIT, STEERING_LIMIT

MAX_FORWARD, MAX_LATERAL = 60.0, 30.0  # m: two seconds at 30 m/s; to either side
MIN_FORWARD = -5.0  # m


@runtime_checkable
class ActionKind(Protocol):
    """Converts actions of the environment into planner actions."""

    @property
    def space(self) -> spaces.Box[Any]:
        """The action space."""
        ...

    def decode(self, action: Float[np.ndarray, "..."]) -> Plan | Control:
        """Return the plan or control of an action inside the space."""
        ...


class ControlAction:
    """Acceleration and steering as fractions of the vehicle's limits, each -1 to 1."""

    def __init__(self) -> None:
        self.space = spaces.Box(-1.0, 1.0, (2,), np.float32)

    def decode(self, action: Float[np.ndarray, "..."]) -> Control:
        """Return the control; (0, 0) means no acceleration and no steering."""
        pedal, wheel = action.tolist()
        limit = BRAKING_LIMIT if pedal < 0.0 else ACCELERATION_LIMIT
        return Control(pedal * limit, wheel * STEERING_LIMIT)

    def encode(self, control: Control) -> Float[np.ndarray, " 2"]:
        """Return the action of a control, clipped to the vehicle's limits."""
        limit = BRAKING_LIMIT if control.acceleration < 0.0 else ACCELERATION_LIMIT
        action = (control.acceleration / limit, control.steering / STEERING_LIMIT)
        return np.clip(np.array(action, np.float32), -1.0, 1.0)


class PlanAction:
    """Waypoints in the ego frame at 0.5, 1.0, 1.5 and 2.0 s, metres; see `follow_plan`."""

    def __init__(self) -> None:
        low = np.tile(np.array([MIN_FORWARD, -MAX_LATERAL], np.float32), (PLAN_STEPS, 1))
        high = np.tile(np.array([MAX_FORWARD, MAX_LATERAL], np.float32), (PLAN_STEPS, 1))
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
        InputError: There is no kind of this name.
    """
    if name not in ACTIONS:
        message = f"There is no action kind {name!r}. Kinds: {', '.join(ACTIONS)}."
        raise InputError(message)
    return ACTIONS[name]()


def inside(action: object, space: spaces.Box[Any]) -> Float[np.ndarray, "..."]:
    """Return an action as an array, clipped to the space.

    Raises:
        InputError: It has another shape, or values that are not finite.
    """
    try:
        values = np.asarray(action, dtype=space.dtype)
    except (TypeError, ValueError) as error:
        message = f"Action: expected numbers of shape {space.shape}, got {action!r}."
        raise InputError(message) from error
    if values.shape != space.shape:
        message = f"Action: expected finite numbers of shape {space.shape}, got {values.shape}."
        raise InputError(message)
    if not np.isfinite(values).all():
        message = f"Action: expected finite numbers of shape {space.shape}, got {action!r}."
        raise InputError(message)
    return np.clip(values, space.low, space.high)
