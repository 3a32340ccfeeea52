"""Another planner at the wheel while the expert only answers (DAgger; Ross et al., 2011).

What is recorded is what the expert would have done where the other planner got to, so that a
learner sees answers to its own mistakes. Nobody learns from standing at one place for minutes: who
stands while the expert would go is relieved by the expert for a few seconds.
"""

from plant_bench.agent import Control, decision_interval
from plant_bench.agents.control import follow_plan
from plant_bench.agents.registry import load_agent
from plant_bench.runner.observing import observe
from plant_bench.world.route import Route
from plant_bench.world.scene import TICK, Scene

STANDING = 0.1  # m/s
WANTED = 0.2  # m/s2 asked for by the expert that count as a wish to go
PATIENCE = 6.0  # s that the other planner may stand against the expert's wish
RELIEF = 5.0  # s that the expert drives then


class Takeover:
    """Drives one episode in the expert's place; mutable.

    Args:
        driver: The planner that drives, as `--agent` takes it; privileged inputs are not given.
        route: The route being driven.

    Raises:
        InputError: There is no such planner.
    """

    def __init__(self, driver: str, route: Route) -> None:
        self._agent = load_agent(driver)
        self._agent.reset(route.plan)
        self._route = route
        self._due = 0
        self._control = Control(0.0, 0.0)
        self._stood = 0.0
        self._relief = 0.0

    def executed(self, scene: Scene, progress: float, offset: float, control: Control) -> Control:
        """Return what is executed: the other planner's control most of the time."""
        if scene.tick >= self._due:
            inputs = self._agent.inputs
            seen = observe(scene, self._route, progress, offset, inputs, None)
            action = self._agent.act(seen)
            self._due = scene.tick + decision_interval(self._agent)
            self._control = action if isinstance(action, Control) else follow_plan(action, seen.ego)
        if self._relief > 0.0:
            self._relief -= TICK
            return control
        waits = scene.ego.speed < STANDING and control.acceleration > WANTED
        self._stood = self._stood + TICK if waits else 0.0
        if self._stood > PATIENCE:
            self._stood, self._relief = 0.0, RELIEF
        return self._control
