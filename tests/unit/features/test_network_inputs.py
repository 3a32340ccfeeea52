"""An observation as numbers."""

import math

import pytest

from plant_bench.agent import NextLight, Observation
from plant_bench.errors import AgentError
from plant_bench.features.network_inputs import scene_input
from plant_bench.features.tokens import TokenSpec
from plant_bench.world.scene import Actors, Light
from tests.builders import make_ego, make_observation, straight_route_ahead

EGO = make_ego(4.0, y=2.0, yaw=-math.pi / 2)


def observation(light: NextLight | None = None, metres: int = 40) -> Observation:
    """The ego is 2 m to the left of an eastward route of so many points, and heads south."""
    return make_observation(
        ego=EGO,
        speed_limit=9.0,
        actors=Actors.none(),
        route=straight_route_ahead(metres - 1, speed_limits=9.0, offset=2.0),
        light=light,
    )


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
        scene_input(make_observation(ego=EGO), TokenSpec())
