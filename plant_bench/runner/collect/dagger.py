"""DAgger (Ross et al., 2011): another planner drives while the expert's actions are recorded.

The recording holds what the expert would have done in the states that the other planner reached. A
planner that stays stationary although the expert would go adds no information, so the expert then
takes over for a few seconds.
"""

from plant_bench.agent import Control
from plant_bench.agents.loading.registry import load_agent
from plant_bench.errors import InputError
from plant_bench.runner.decisions import PlannerSession
from plant_bench.sensing.inputs import DRIVER_ONLY
from plant_bench.world.route import Route
from plant_bench.world.scene import TICK, Scene

STATIONARY_SPEED = 0.1  # m/s
MIN_EXPERT_ACCELERATION = 0.2  # m/s2, above which the expert would go
PATIENCE = 6.0  # s that the planner may stay stationary although the expert would go
TAKEOVER = 5.0  # s of an expert takeover

_PATIENCE_TICKS, _TAKEOVER_TICKS = round(PATIENCE / TICK), round(TAKEOVER / TICK)


def check_driver(driver: str) -> None:
    """Check that a planner can drive in a DAgger collection.

    Raises:
        InputError: There is no such planner, or it has privileged inputs.
    """
    inputs = load_agent(driver).inputs
    if refused := inputs & DRIVER_ONLY:
        message = (
            f"'{driver}' cannot drive in a DAgger collection: its inputs include "
            f"{' and '.join(sorted(refused))}. Expected a planner without these inputs, e.g. "
            "plant@models/mine."
        )
        raise InputError(message)


class DaggerOverride:
    """Executes another planner's control instead of the expert's in one episode; mutable.

    Args:
        driver: Name of the planner that drives, as for `--agent`; see `check_driver`.
        route: The route being driven.
        seed: The scenario's seed.

    Raises:
        InputError: There is no such planner.
    """

    def __init__(self, driver: str, route: Route, seed: int) -> None:
        self._driver = PlannerSession(load_agent(driver), route, seed, "the driver's ")
        self._control: Control | None = None  # None before its first decision
        self._stationary_ticks = 0  # ticks
        self._takeover_until = 0  # tick

    def executed(self, scene: Scene, progress: float, offset: float, control: Control) -> Control:
        """Return the control to execute: the other planner's, or the expert's during a takeover.

        Raises:
            AgentError: The other planner fails.
        """
        driver_control = self._driver_control(scene, progress, offset)
        if scene.tick < self._takeover_until:
            return control
        waits_needlessly = (
            scene.ego.speed < STATIONARY_SPEED and control.acceleration > MIN_EXPERT_ACCELERATION
        )
        self._stationary_ticks = self._stationary_ticks + 1 if waits_needlessly else 0
        if self._stationary_ticks > _PATIENCE_TICKS:
            self._stationary_ticks, self._takeover_until = 0, scene.tick + _TAKEOVER_TICKS
            return control
        return driver_control

    def _driver_control(self, scene: Scene, progress: float, offset: float) -> Control:
        """Return the other planner's control, which is held between its decisions."""
        driver = self._driver
        if self._control is None:
            driver.start()
        if self._control is None or driver.due(scene.tick):
            observation = driver.observe(scene, progress, offset, None)
            self._control = driver.decide(scene, observation).control
        return self._control
