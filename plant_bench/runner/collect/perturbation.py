"""Perturbs the executed control during data collection, so that the driver must recover.

The recorded action remains the driver's own. A perturbation adds steering or acceleration for a
short time; it ends early if the ego is too far from its route.
"""

import math
import random
from dataclasses import dataclass

from plant_bench.agent import Control
from plant_bench.world.scene import TICK, WHEELBASE, Scene

FIRST, PAUSE = (
    (2.0, 10.0),
    (6.0, 16.0),
)  # s of driving before the first perturbation, and between two
STEERED = 0.75  # fraction that changes the steering; the others change the acceleration
TIME = (0.5, 1.0)  # s, duration
ASIDE = (0.4, 0.9)  # m, lateral displacement at its end if the driver did not react
HARDEST_PULL = 0.2  # rad
MOST_OFFSET = 0.6  # m from the route at which it ends; the ego then stays within about 1 m
BRAKING, PUSHING = (1.0, 3.5), (0.5, 1.5)  # m/s2
SLOWEST = 3.0  # m/s, minimum speed; slower, there is nothing to recover from


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
        self._draw = random.Random(f"perturbation|{seed}")
        self._wait = self._draw.uniform(*FIRST)
        self._push: Pulse | None = None

    def executed(self, scene: Scene, _progress: float, offset: float, control: Control) -> Control:
        """Return the control to execute: the driver's, plus the current perturbation if any."""
        push = self._push
        if push is not None and (scene.tick >= push.end or self._is_far(push, offset)):
            push = self._push = None
            self._wait = self._draw.uniform(*PAUSE)
        if push is None:
            if scene.ego.speed < SLOWEST:
                return control
            self._wait -= TICK
            if self._wait > 0.0 or abs(offset) > 0.5 * MOST_OFFSET:
                return control
            push = self._push = self._begin(scene)
        return Control(control.acceleration + push.acceleration, control.steering + push.steering)

    def _is_far(self, push: Pulse, offset: float) -> bool:
        """Return whether the ego is too far from the route, on the side it is steered to."""
        return push.steering * offset > 0.0 and abs(offset) > MOST_OFFSET

    def _begin(self, scene: Scene) -> Pulse:
        draw = self._draw
        time = draw.uniform(*TIME)
        end = scene.tick + max(round(time / TICK), 1)
        if draw.random() < STEERED:
            metres = scene.ego.speed * time
            pull = math.atan(2.0 * WHEELBASE * draw.uniform(*ASIDE) / metres**2)
            return Pulse(end, steering=draw.choice((-1.0, 1.0)) * min(pull, HARDEST_PULL))
        harder = draw.random() < 0.5
        pull = draw.uniform(*PUSHING) if harder else -draw.uniform(*BRAKING)
        return Pulse(end, acceleration=pull)
