"""Observations as arrays: the numbers of `features`, of a fixed size, inside their spaces."""

from collections.abc import Callable

import numpy as np
import pytest

from plant_bench.agent import NextLight, Observation, RouteAhead
from plant_bench.errors import InputError
from plant_bench.features.network_inputs import scene_input
from plant_bench.features.raster import RasterSpec
from plant_bench.features.tokens import TokenKind, TokenSpec
from plant_bench.gym.encoders import RasterEncoder, encoder_of
from plant_bench.gym.object_encoder import ObjectEncoder
from plant_bench.gym.token_encoder import PLAIN_TOKENS, TokenEncoder
from plant_bench.world.scene import ActorKind, Actors, EgoState, Light
from plant_bench.world.town import load_town


def seen(count: int, light: NextLight | None = None) -> Observation:
    """An ego at (50, 20) heading north on its route, with others 3, 6, 9 ... m to the east."""
    points = np.stack((np.full(41, 50.0), 20.0 + np.arange(41.0)), axis=1)
    north = 0.5 * np.pi
    poses = [(50.0 + 3.0 * place, 20.0, north) for place in range(1, count + 1)]
    actors = Actors(
        np.arange(count) + 3,
        np.array(poses, np.float32).reshape(-1, 3),
        np.full(count, 4.0, np.float32),
        np.tile(np.array([[4.5, 1.8]], np.float32), (count, 1)),
        np.full(count, ActorKind.BICYCLE, np.uint8),
    )
    route = RouteAhead(7.0, 0.2, 0.1, points, np.full(41, north), np.full(41, 10.0))
    return Observation(1.0, EgoState(50.0, 20.0, north, 5.0), 10.0, actors, route, light)


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
