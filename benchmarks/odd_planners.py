"""Planners that drive oddly, to test that the simulation survives whatever an ego does."""

# ruff: noqa: ARG002, D102 - the methods are those of `Agent`

import math
import random
from collections import deque

from plant_bench.agent import Agent, Control, Input, Observation, Plan
from plant_bench.agents.loading.registry import load_agent
from plant_bench.world.route import Route

TICKS = 20  # per second


class _Odd:
    """The rule-based planner, whose actions a subclass changes.

    It is called at each tick; the planner below decides at its own interval.
    """

    def __init__(self) -> None:
        self.planner: Agent = load_agent("rule-based")
        self.inputs = self.planner.inputs

    def reset(self, route: Route | None) -> None:
        self.planner.reset(route)
        seed = 0 if route is None else route.id
        self.draw = random.Random(f"{type(self).__name__}{seed}")
        self.tick = self.due = 0
        self.last: Plan | Control = Control(0.0, 0.0)

    def act(self, observation: Observation) -> Plan | Control:
        if self.tick == self.due:
            self.last = self.planner.act(observation)
            self.due += getattr(self.planner, "interval", 1)
        self.tick += 1
        return self.change(self.last, observation)

    def change(self, action: Plan | Control, observation: Observation) -> Plan | Control:
        raise NotImplementedError


class Late(_Odd):
    """Executes each action 0.3 s late."""

    DELAY = 6  # ticks

    def reset(self, route: Route | None) -> None:
        super().reset(route)
        self.queue = deque([Control(0.0, 0.0)] * self.DELAY, maxlen=self.DELAY + 1)

    def change(self, action: Plan | Control, observation: Observation) -> Plan | Control:
        self.queue.append(action)
        return self.queue[0]


class Jerky(_Odd):
    """Full throttle and full braking in turns of half a second; steers as the planner."""

    def change(self, action: Plan | Control, observation: Observation) -> Plan | Control:
        steering = action.steering if isinstance(action, Control) else 0.0
        forward = (self.tick // (TICKS // 2)) % 2 == 0
        return Control(3.5 if forward else -8.0, steering)


class OffTheLane(_Odd):
    """Sways across the road with an amplitude of several metres."""

    def change(self, action: Plan | Control, observation: Observation) -> Plan | Control:
        control = action if isinstance(action, Control) else Control(0.5, 0.0)
        sway = 0.12 * math.sin(2.0 * math.pi * self.tick / (6.0 * TICKS))
        return Control(control.acceleration, control.steering + sway)


class StopsAnywhere(_Odd):
    """Stops every now and then for 5 to 40 s, wherever it is."""

    def reset(self, route: Route | None) -> None:
        super().reset(route)
        self.until = 0

    def change(self, action: Plan | Control, observation: Observation) -> Plan | Control:
        if self.tick > self.until and self.draw.random() < 1.0 / (25.0 * TICKS):
            self.until = self.tick + self.draw.randint(5 * TICKS, 40 * TICKS)
        if self.tick < self.until:
            steering = action.steering if isinstance(action, Control) else 0.0
            return Control(-8.0, steering)
        return action


class Random:
    """Random steering and acceleration, held for a second; asks for no input but the route."""

    inputs = frozenset({Input.ROUTE})

    def reset(self, route: Route | None) -> None:
        self.draw = random.Random("random" if route is None else route.id)
        self.tick = 0
        self.control = Control(2.0, 0.0)

    def act(self, observation: Observation) -> Control:
        if self.tick % TICKS == 0:
            steering = max(-0.6, min(0.6, self.draw.gauss(0.0, 0.12)))
            self.control = Control(self.draw.uniform(-3.0, 3.5), steering)
        self.tick += 1
        return self.control


class StopAndGo:
    """Brakes fully every other second and sways; it also brakes when it stands.

    The ego has no reverse gear, so it must stay where it is.
    """

    inputs = frozenset({Input.ROUTE})

    def reset(self, route: Route | None) -> None:
        self.tick = 0

    def act(self, observation: Observation) -> Control:
        self.tick += 1
        brakes = (self.tick // TICKS) % 2
        return Control(-8.0 if brakes else 3.0, 0.3 * math.sin(self.tick / 37.0))


NAMES = ("Late", "Jerky", "OffTheLane", "StopsAnywhere", "Random", "StopAndGo")
