"""Perturbs the executed control during data collection, so that the driver must recover.

The recorded action remains the driver's own. A perturbation adds steering or acceleration for a
short time; it ends early if the ego is too far from its route.
"""

import math
import random
from dataclasses import dataclass

from plant_bench.agent import Control
from plant_bench.world.scene import TICK, WHEELBASE, Scene

DELAY = (2.0, 10.0)  # s of driving before the first perturbation
PAUSE = (6.0, 16.0)  # s between two perturbations
STEERING_FRACTION = 0.75  # fraction that changes the steering; the others change the acceleration
DURATION = (0.5, 1.0)  # s
DISPLACEMENT = (0.4, 0.9)  # m, lateral displacement at its end if the driver did not react
MAX_STEERING = 0.2  # rad
MAX_OFFSET = 0.6  # m from the route at which it ends; the ego then stays within about 1 m
BRAKING, ACCELERATING = (1.0, 3.5), (0.5, 1.5)  # m/s2
MIN_SPEED = 3.0  # m/s; at lower speeds there is nothing to recover from


@dataclass(frozen=True)
class Pulse:
    """One perturbation.

    Attributes:
        end: First tick without the perturbation.
        steering: Radians added to the front wheels' angle.
        acceleration: m/s2 added.
    """

    end: int
    steering: float = 0.0
    acceleration: float = 0.0


class Perturbation:
    """Perturbs one episode; mutable. Equal seeds and scenes give equal perturbations.

    Args:
        seed: Random seed.
    """

    def __init__(self, seed: int) -> None:
        self._rng = random.Random(f"perturbation|{seed}")
        self._wait = self._rng.uniform(*DELAY)
        self._pulse: Pulse | None = None

    def executed(self, scene: Scene, _progress: float, offset: float, control: Control) -> Control:
        """Return the control to execute: the driver's, plus the current perturbation if any."""
        pulse = self._pulse
        if pulse is not None and (scene.tick >= pulse.end or self._is_far(pulse, offset)):
            pulse = self._pulse = None
            self._wait = self._rng.uniform(*PAUSE)
        if pulse is None:
            if scene.ego.speed < MIN_SPEED:
                return control
            self._wait -= TICK
            if self._wait > 0.0 or abs(offset) > 0.5 * MAX_OFFSET:
                return control
            pulse = self._pulse = self._begin(scene)
        return Control(control.acceleration + pulse.acceleration, control.steering + pulse.steering)

    def _is_far(self, pulse: Pulse, offset: float) -> bool:
        """Return whether the ego is too far from the route, on the side it is steered to."""
        return pulse.steering * offset > 0.0 and abs(offset) > MAX_OFFSET

    def _begin(self, scene: Scene) -> Pulse:
        rng = self._rng
        time = rng.uniform(*DURATION)
        end = scene.tick + max(round(time / TICK), 1)
        if rng.random() < STEERING_FRACTION:
            metres = scene.ego.speed * time
            angle = math.atan(2.0 * WHEELBASE * rng.uniform(*DISPLACEMENT) / metres**2)
            return Pulse(end, steering=rng.choice((-1.0, 1.0)) * min(angle, MAX_STEERING))
        faster = rng.random() < 0.5
        change = rng.uniform(*ACCELERATING) if faster else -rng.uniform(*BRAKING)
        return Pulse(end, acceleration=change)
