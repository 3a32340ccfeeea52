"""Observations as arrays: the numbers of `features`, of a fixed size, inside their spaces."""

import math
from collections.abc import Callable

import numpy as np
import pytest

from plant_bench.agent import NextLight, Observation
from plant_bench.errors import InputError
from plant_bench.features.network_inputs import scene_input
from plant_bench.features.raster import RasterSpec
from plant_bench.features.tokens import TokenKind, TokenSpec
from plant_bench.gym.encoders import RasterEncoder, encoder_of
from plant_bench.gym.object_encoder import ObjectEncoder
from plant_bench.gym.token_encoder import PLAIN_TOKENS, TokenEncoder
from plant_bench.world.scene import ActorKind, Light
from plant_bench.world.town import load_town
from tests.builders import make_actors, make_ego, make_observation, straight_route_ahead


def seen(count: int, light: NextLight | None = None) -> Observation:
    """An ego at (50, 20) heading north on its route, with others 3, 6, 9 ... m to the east."""
    north = 0.5 * math.pi
    poses = [(50.0 + 3.0 * place, 20.0, north) for place in range(1, count + 1)]
    return make_observation(
        time=1.0,
        ego=make_ego(5.0, x=50.0, y=20.0, yaw=north),
        actors=make_actors(poses, speeds=4.0, kinds=ActorKind.BICYCLE, ids=range(3, 3 + count)),
        route=straight_route_ahead(
            40, start=(50.0, 20.0), heading=north, progress=7.0, past=0.2, offset=0.1
        ),
        light=light,
    )


def test_token_observation_equals_the_input_of_plant() -> None:
    red = NextLight(Light.RED, 12.0)
    given = scene_input(seen(4, red), PLAIN_TOKENS)
    encoded = TokenEncoder().encode(seen(4, red))
    count = len(given.tokens)
    assert np.array_equal(encoded["tokens"][:count], given.tokens.attributes)
    assert np.array_equal(encoded["kinds"][:count], given.tokens.kinds)
    assert encoded["mask"].sum() == count
    assert not encoded["tokens"][count:].any()
    assert (encoded["red"][0], encoded["speed"][0]) == (1.0, 5.0)
    assert encoded["target"] == pytest.approx(given.target)


def test_farthest_actors_are_dropped_when_tokens_do_not_fit() -> None:
    encoded = TokenEncoder(most=6).encode(seen(9, NextLight(Light.RED, 12.0)))
    kinds = [TokenKind.VULNERABLE] * 3 + [TokenKind.ROUTE] * 2 + [TokenKind.STOP_LINE]
    assert encoded["kinds"].tolist() == kinds
    assert encoded["tokens"][:3, 2] == pytest.approx([-3.0, -6.0, -9.0], abs=1e-5)  # to the right


def test_object_observation_is_nearest_first_in_the_ego_frame() -> None:
    encoded = ObjectEncoder(most=2).encode(seen(3, NextLight(Light.RED, 12.0)))
    assert encoded["actors"][0] == pytest.approx([0.0, -3.0, 0.0, 4.0, 4.5, 1.8], abs=1e-5)
    assert encoded["actors"][1, 1] == pytest.approx(-6.0, abs=1e-5)
    assert encoded["route"][10] == pytest.approx([10.0, 0.0, 0.0, 10.0], abs=1e-5)
    assert encoded["route_mask"].sum() == 41
    assert encoded["light"] == Light.RED
    assert encoded["light_distance"] == pytest.approx([12.0])


@pytest.mark.parametrize("count", [0, 1, 200])
@pytest.mark.parametrize(
    "make",
    [
        TokenEncoder,
        lambda: TokenEncoder(TokenSpec(horizon=5.0, conflicts=True, motion=True)),
        ObjectEncoder,
        lambda: RasterEncoder(RasterSpec(size=48, scale=1.0, below=12)),
    ],
    ids=["tokens", "all tokens", "objects", "raster"],
)
def test_encoded_observation_is_in_its_space(make: Callable, count: int) -> None:
    encoder = make()
    encoder.reset(load_town("town03"))
    encoded = encoder.encode(seen(count))
    assert encoder.space.contains(encoded)


def test_unusable_encoders_and_observations_are_refused() -> None:
    with pytest.raises(InputError, match="tokens, objects, raster"):
        encoder_of("pixels")
    with pytest.raises(InputError, match="space, reset and encode"):
        encoder_of(3)
    with pytest.raises(InputError, match="more than 3"):
        TokenEncoder(most=3)
    with pytest.raises(InputError, match="reset"):
        RasterEncoder().encode(seen(0))
