"""Another planner at the wheel while the expert only answers (DAgger; Ross et al., 2011).

What is recorded is what the expert would have done where the other planner got to, so that a
learner sees answers to its own mistakes. Nobody learns from standing at one place for minutes: who
stands while the expert would go is relieved by the expert for a few seconds.
"""

from plant_bench.agent import Control
from plant_bench.agents.loading.registry import load_agent
from plant_bench.errors import InputError
from plant_bench.runner.decisions import PlannerSession
from plant_bench.sensing.inputs import DRIVER_ONLY
from plant_bench.world.route import Route
from plant_bench.world.scene import TICK, Scene

STANDING = 0.1  # m/s
WANTED = 0.2  # m/s2 asked for by the expert that count as a wish to go
PATIENCE = 6.0  # s that the other planner may stand against the expert's wish
RELIEF = 5.0  # s that the expert drives then

_PATIENCE_TICKS, _RELIEF_TICKS = round(PATIENCE / TICK), round(RELIEF / TICK)


def check_driver(driver: str) -> None:
    """Check that a planner can drive in the expert's place.

    Raises:
        InputError: There is no such planner, or it wants what it cannot be given.
    """
    inputs = load_agent(driver).inputs
    if refused := inputs & DRIVER_ONLY:
        message = (
            f"'{driver}' cannot drive while the expert answers: it asks for "
            f"{' and '.join(sorted(refused))}. A planner that drives by what it sees is wanted, "
            "as plant@models/mine."
        )
        raise InputError(message)


class DaggerOverride:
    """Drives one episode in the expert's place; mutable.

    Args:
        driver: The planner that drives, as `--agent` takes it; see `check_driver`.
        route: The route being driven.
        seed: The scenario's.

    Raises:
        InputError: There is no such planner.
    """

    def __init__(self, driver: str, route: Route, seed: int) -> None:
        self._driver = PlannerSession(load_agent(driver), route, seed, "the driver's ")
        self._control: Control | None = None  # None until it was asked
        self._stood = 0  # ticks
        self._relieved_until = 0  # tick

    def executed(self, scene: Scene, progress: float, offset: float, control: Control) -> Control:
        """Return what is executed: the other planner's control most of the time.

        Raises:
            AgentError: The other planner fails.
        """
        answer = self._answer(scene, progress, offset)
        if scene.tick < self._relieved_until:
            return control
        waits = scene.ego.speed < STANDING and control.acceleration > WANTED
        self._stood = self._stood + 1 if waits else 0
        if self._stood > _PATIENCE_TICKS:
            self._stood, self._relieved_until = 0, scene.tick + _RELIEF_TICKS
            return control
        return answer

    def _answer(self, scene: Scene, progress: float, offset: float) -> Control:
        """Return the other planner's control, which it holds between its decisions."""
        driver = self._driver
        if self._control is None:
            driver.start()
        if self._control is None or driver.due(scene.tick):
            seen = driver.observe(scene, progress, offset, None)
            self._control = driver.decide(scene, seen).control
        return self._control
