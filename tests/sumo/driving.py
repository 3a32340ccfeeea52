"""The loop of an episode, tick by tick, for tests that look inside."""

from collections.abc import Iterator

from plant_bench.agent import Control, Input
from plant_bench.agent_check import decision_interval
from plant_bench.agents.loading.registry import load_agent
from plant_bench.scoring.referee import Referee
from plant_bench.sensing.observe import Sensors
from plant_bench.sim.simulation import Simulation
from plant_bench.world.route import Route


def drive(simulation: Simulation, route: Route, agent: str) -> Iterator[Referee]:
    """Let an agent drive endlessly; yield the referee after it has judged each scene."""
    driver = load_agent(agent)
    driver.reset(route)
    sensors = Sensors(route, 0, driver.inputs)
    referee = Referee(simulation.town, route)
    control, due = Control(0.0, 0.0), 0
    while True:
        scene = simulation.scene
        referee.judge(scene)
        yield referee
        if scene.tick == due:
            facts = simulation.privileged() if Input.PRIVILEGED in driver.inputs else None
            seen = sensors.observe(scene, referee.progress, referee.offset, facts)
            action = driver.act(seen)
            assert isinstance(action, Control)
            control, due = action, due + decision_interval(driver)
        simulation.step(control)
