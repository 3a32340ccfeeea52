"""An observation as numbers."""

import math

import numpy as np
import pytest

from plant_bench.agent import NextLight, Observation, RouteAhead
from plant_bench.errors import AgentError
from plant_bench.features.network_inputs import scene_input
from plant_bench.features.tokens import TokenSpec
from plant_bench.world.scene import Actors, EgoState, Light

POINTS = np.stack((np.arange(40.0), np.zeros(40)), axis=1)
EGO = EgoState(0.0, 2.0, -math.pi / 2, 4.0)


def observation(light: NextLight | None = None, metres: int = 40) -> Observation:
    points = POINTS[:metres]
    route = RouteAhead(0.0, 0.0, 2.0, points, np.zeros(metres), np.full(metres, 9.0))
    return Observation(0.0, EGO, 9.0, Actors.none(), route, light)


def test_target_point_is_on_the_route_in_the_ego_frame() -> None:
    assert scene_input(observation(), TokenSpec()).target == pytest.approx((2.0, 20.0))
    assert scene_input(observation(metres=6), TokenSpec()).target == pytest.approx((2.0, 5.0))


@pytest.mark.parametrize(
    ("light", "red"),
    [(None, 0.0), (Light.GREEN, 0.0), (Light.YELLOW, 1.0), (Light.RED, 1.0)],
)
def test_red_flag_is_set_for_red_and_yellow_lights(light: Light | None, red: float) -> None:
    seen = None if light is None else NextLight(light, 12.0)
    assert scene_input(observation(seen), TokenSpec()).red == red


def test_missing_inputs_raise_agent_error() -> None:
    with pytest.raises(AgentError, match="'objects' and 'route'"):
        scene_input(Observation(0.0, EGO, 9.0), TokenSpec())
