"""Every registered planner satisfies the contract, and violations are detected."""

import numpy as np
import pytest

from plant_bench.agent import Cause, Control, Input, Observation, Plan, Reason
from plant_bench.agent_check import check_agent
from plant_bench.agents.loading.planner_spec import AGENTS
from plant_bench.agents.loading.registry import load_agent
from plant_bench.errors import AgentError
from plant_bench.sensing.observe import Sensors
from plant_bench.sim.simulation import Simulation
from plant_bench.world.route import Route, Scenario, load_suite
from plant_bench.world.route_progress import RouteProgress

pytestmark = pytest.mark.sumo


@pytest.fixture(scope="module")
def episode() -> tuple[Route, list[Observation]]:
    """A route and some ticks of driving straight ahead from its start."""
    route = load_suite("longest6")[6]
    observations = []
    sensors, place = Sensors(route, 1, frozenset(Input)), RouteProgress(route)
    with Simulation(Scenario(route, 1)) as simulation:
        for tick in range(60):
            scene = simulation.step(Control(1.0, 0.0))
            place.follow(scene.ego.x, scene.ego.y)
            if tick % 10 == 0:
                facts = simulation.privileged()
                observations.append(sensors.observe(scene, place.progress, place.offset, facts))
    return route, observations


@pytest.mark.parametrize("name", list(AGENTS))
def test_registered_agents_satisfy_the_contract(
    name: str, episode: tuple[Route, list[Observation]]
) -> None:
    check_agent(load_agent(name), *episode)


class Good:
    inputs = frozenset({Input.OBJECTS})

    def reset(self, route: Route | None) -> None:
        assert route is None

    def act(self, observation: Observation) -> Plan | Control:
        return Plan(np.ones((4, 2)))


class Forgetless(Good):
    ticks = 0

    def act(self, observation: Observation) -> Plan | Control:
        self.ticks += 1
        return Control(float(self.ticks), 0.0)


class Vandal(Good):
    def act(self, observation: Observation) -> Plan | Control:
        assert observation.actors is not None
        observation.actors.speeds[:] += 1.0
        return Control(0.0, 0.0)


class NotANumber(Good):
    def act(self, observation: Observation) -> Plan | Control:
        return Control(float("nan"), 0.0)


class WrongShape(Good):
    def act(self, observation: Observation) -> Plan | Control:
        return Plan(np.zeros((3, 2)))


class Nothing(Good):
    def act(self, observation: Observation) -> Plan | Control:
        return None  # type: ignore[return-value]


class Hasty(Good):
    interval = 0


class BadRanks(Good):
    def rank(self, observation: Observation) -> np.ndarray:
        return np.zeros(3 + len(observation.actors or []))


class Talker(Good):
    def explain(self) -> Reason:
        return "because"  # type: ignore[return-value]


class Accuser(Good):
    def explain(self) -> Reason:
        return Reason(Cause.LEADER, 10**9)


class Incomplete:
    inputs = frozenset()


def test_valid_agent_passes_the_check(episode: tuple[Route, list[Observation]]) -> None:
    check_agent(Good(), *episode)


@pytest.mark.parametrize(
    ("agent", "message"),
    [
        (Forgetless(), "reset must clear state"),
        (Vandal(), "must not modify its observation|read-only"),
        (NotANumber(), "finite numbers"),
        (WrongShape(), r"shape \(3, 2\)"),
        (Nothing(), "expected a Plan or a Control"),
        (Hasty(), "got 0"),
        (BadRanks(), "rank: expected"),
        (Talker(), "expected a Reason or None"),
        (Accuser(), "got 1000000000"),
        (Incomplete(), "is not a planner"),
    ],
    ids=lambda value: type(value).__name__ if not isinstance(value, str) else "",
)
def test_broken_agents_fail_with_the_reason(
    agent: object, message: str, episode: tuple[Route, list[Observation]]
) -> None:
    with pytest.raises((AgentError, ValueError), match=message):
        check_agent(agent, *episode)
