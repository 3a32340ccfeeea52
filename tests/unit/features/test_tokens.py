"""Objects as tokens: which actors, in what order, in which frame."""

import math
from dataclasses import replace

import numpy as np
import pytest

from plant_bench.agent import NextLight, RouteAhead
from plant_bench.features.tokens import NO_ROW, TokenKind, TokenSpec, tokens_of
from plant_bench.world.scene import EGO_LENGTH, EGO_WIDTH, ActorKind, Actors, EgoState, Light
from tests.builders import make_actors

NORTH = EgoState(100.0, 50.0, math.pi / 2, 5.0)


def route_of(points: np.ndarray) -> RouteAhead:
    count = len(points)
    return RouteAhead(0.0, 0.0, 0.0, points, np.zeros(count), np.full(count, 10.0))


def straight_north(metres: int = 60) -> RouteAhead:
    ahead = np.arange(metres + 1.0)
    return route_of(np.stack((np.full_like(ahead, 100.0), 50.0 + ahead), axis=1))


def actors_at(*places: tuple[float, float], kinds: tuple[ActorKind, ...] = ()) -> Actors:
    """Actors that head north at 1, 2, 3, ... m/s."""
    count = len(places)
    return make_actors(
        [(x, y, math.pi / 2) for x, y in places],
        speeds=np.arange(count) + 1.0,
        kinds=kinds or ActorKind.CAR,
        ids=range(7, 7 + count),
    )


def test_actor_tokens_are_nearest_first_in_the_ego_frame() -> None:
    actors = actors_at((100.0, 70.0), (97.0, 50.0), (100.0, 90.0))
    tokens = tokens_of(NORTH, actors, straight_north(), TokenSpec())
    assert tokens.places.tolist() == [1, 0, NO_ROW, NO_ROW]
    assert tokens.kinds.tolist() == [TokenKind.VEHICLE] * 2 + [TokenKind.ROUTE] * 2
    assert tokens.attributes[0] == pytest.approx([2.0, 0.0, 3.0, 0.0, 1.8, 4.5], abs=1e-5)
    assert tokens.attributes[1] == pytest.approx([1.0, 20.0, 0.0, 0.0, 1.8, 4.5], abs=1e-5)


def test_horizon_adds_only_actors_that_will_come_near() -> None:
    ego = EgoState(0.0, 0.0, 0.5 * math.pi, 10.0)  # northwards
    actors = replace(
        actors_at((0.0, 90.0), (0.0, 95.0), (90.0, 0.0), (-90.0, 50.0)),
        poses=np.array(
            [
                [0.0, 90.0, -0.5 * math.pi],  # meets the ego in 4.5 s
                [0.0, 95.0, 0.5 * math.pi],  # drives on before it
                [90.0, 0.0, 0.0],  # goes away
                [-90.0, 50.0, 0.0],  # crosses before it
            ],
            np.float32,
        ),
        speeds=np.array([10.0, 10.0, 15.0, 15.0], np.float32),
    )

    seen = tokens_of(ego, actors, straight_north(), TokenSpec(horizon=5.0)).places.tolist()

    assert [place for place in seen if place != NO_ROW] == [0, 3]
    nearby = tokens_of(ego, actors, straight_north(), TokenSpec())
    assert (nearby.places == NO_ROW).all()


def test_straight_route_is_split_into_segments() -> None:
    tokens = tokens_of(NORTH, Actors.none(), straight_north(), TokenSpec(segments=3))
    expected = [[place, 5.0 + 10.0 * place, 0.0, 0.0, EGO_WIDTH, 10.0] for place in range(3)]
    assert tokens.attributes == pytest.approx(np.array(expected), abs=1e-5)


def test_corner_starts_a_new_segment() -> None:
    up = [(100.0, 50.0 + step) for step in range(7)]
    left = [(100.0 - step, 56.0) for step in range(1, 50)]
    tokens = tokens_of(NORTH, Actors.none(), route_of(np.array(up + left)), TokenSpec())
    assert tokens.attributes[0] == pytest.approx([0.0, 3.0, 0.0, 0.0, EGO_WIDTH, 6.0], abs=1e-5)
    assert tokens.attributes[1] == pytest.approx(
        [1.0, 6.0, 5.0, math.pi / 2, EGO_WIDTH, 10.0], abs=1e-5
    )


@pytest.mark.parametrize(("metres", "segments"), [(0, 0), (1, 1), (7, 1), (12, 2)])
def test_route_has_fewer_segments_near_its_end(metres: int, segments: int) -> None:
    tokens = tokens_of(NORTH, Actors.none(), straight_north(metres), TokenSpec())
    assert len(tokens) == segments
    assert tokens.attributes[:, 5].sum() == pytest.approx(metres)


def test_token_options_select_actors_and_attributes() -> None:
    kinds = (ActorKind.CAR, ActorKind.PEDESTRIAN, ActorKind.BICYCLE, ActorKind.STATIC)
    actors = actors_at((100.0, 40.0), (100.0, 55.0), (100.0, 60.0), (100.0, 65.0), kinds=kinds)
    route = straight_north()
    assert tokens_of(NORTH, actors, route, TokenSpec()).places[:-2].tolist() == [0, 2, 3]
    assert tokens_of(NORTH, actors, route, TokenSpec(rear=False)).places[:-2].tolist() == [2, 3]
    assert tokens_of(NORTH, actors, route, TokenSpec(reach=12.0)).places[:-2].tolist() == [0, 2]
    assert not tokens_of(NORTH, actors, route, TokenSpec(speed=False)).attributes[:3, 0].any()
    told = tokens_of(NORTH, actors, route, TokenSpec(vulnerable=True))
    assert told.places[:-2].tolist() == [1, 0, 2, 3]
    assert told.kinds[:-2].tolist() == [
        TokenKind.VULNERABLE,
        TokenKind.VEHICLE,
        TokenKind.VULNERABLE,
        TokenKind.VEHICLE,
    ]


def test_token_angles_are_wrapped() -> None:
    west = EgoState(0.0, 0.0, math.pi - 0.1, 0.0)
    actors = actors_at((-5.0, 0.0))
    actors.poses[0, 2] = -math.pi + 0.1
    route = route_of(np.stack((-np.arange(30.0), np.zeros(30)), axis=1))
    tokens = tokens_of(west, actors, route, TokenSpec())
    assert tokens.attributes[0, 3] == pytest.approx(0.2, abs=1e-5)
    assert tokens.attributes[1, 3] == pytest.approx(0.1, abs=1e-5)


@pytest.mark.parametrize(
    ("light", "told"),
    [
        (NextLight(Light.RED, 10.0), True),
        (NextLight(Light.YELLOW, 10.0), True),
        (NextLight(Light.GREEN, 10.0), False),
        (NextLight(Light.RED, -2.0), False),
        (None, False),
    ],
)
def test_stop_line_of_a_red_light_is_a_token_across_the_route(light, told) -> None:
    spec = TokenSpec(stop_line=True)
    route = replace(straight_north(), headings=np.full(61, math.pi / 2))
    tokens = tokens_of(NORTH, Actors.none(), route, spec, light)
    assert (tokens.kinds.tolist() == [TokenKind.ROUTE] * 2 + [TokenKind.STOP_LINE]) == told
    if told:
        front = 0.5 * EGO_LENGTH
        assert tokens.attributes[-1, 1] == pytest.approx(10.0 + front, abs=0.5)
        assert tokens.attributes[-1, 2:4] == pytest.approx([0.0, 0.0], abs=1e-5)
    assert len(tokens_of(NORTH, Actors.none(), route, TokenSpec(), light)) == 2
