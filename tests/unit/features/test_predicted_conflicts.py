"""Predicted conflicts in hand-made scenes: the ego drives east along the x axis."""

import math

import numpy as np
import pytest

from plant_bench.features.motion import Rates
from plant_bench.features.predicted_conflicts import MAX_ARRIVAL, NEVER, VIEW, predicted_conflicts
from plant_bench.features.tokens import NO_ROW, TokenSpec, tokens_of
from tests.builders import cars, make_ego, straight_route_ahead

EGO = make_ego(8.0, x=0.5)
ROUTE = straight_route_ahead(progress=0.5, past=0.5)
NORTH, SOUTH = 0.5 * math.pi, -0.5 * math.pi


def met(
    x: float, y: float, yaw: float, speed: float, pull: float = 0.0, turn: float = 0.0
) -> list[float]:
    """Return the predicted conflict with a car of the given acceleration and turn rate."""
    actors = cars((x, y, yaw, speed))
    rates = Rates(np.array([pull], np.float32), np.array([turn], np.float32))
    return predicted_conflicts(EGO, actors, np.array([0]), ROUTE, rates)[0].tolist()


def test_crossing_actor_conflicts_where_and_while_it_crosses() -> None:
    along, first, last, ego = met(40.5, -30.0, NORTH, 10.0)

    assert along == pytest.approx(40.0, abs=3.0)
    # Its front is 2.7 m from the axis after (30 - 2.25 - 2.7) / 10 = 2.5 s, its rear after 3.5 s.
    assert first == pytest.approx(2.5, abs=0.5)
    assert last == pytest.approx(3.75, abs=0.5)
    assert ego == pytest.approx(along / 8.0)


def test_actor_stationary_on_the_route_conflicts_permanently() -> None:
    along, first, last, _ = met(20.5, 0.5, 0.0, 0.0)

    assert along == pytest.approx(20.0 - 2.25 - 2.7, abs=2.0)
    assert (first, last) == (0.0, NEVER)


@pytest.mark.parametrize(
    "car",
    [
        (40.0, -30.0, SOUTH, 10.0),  # drives away
        (40.0, -30.0, NORTH, 2.0),  # comes too late
        (40.0, 4.0, 0.0, 10.0),  # in the next lane
        (-20.0, 0.0, 0.0, 0.0),  # behind
    ],
)
def test_actor_without_a_conflict_has_the_maximum_values(car) -> None:
    assert met(*car) == [VIEW, NEVER, NEVER, MAX_ARRIVAL]


def test_acceleration_advances_a_conflict_and_braking_avoids_it() -> None:
    steady, starting = met(40.5, -20.0, NORTH, 2.5), met(40.5, -20.0, NORTH, 2.5, pull=2.5)

    assert steady == [VIEW, NEVER, NEVER, MAX_ARRIVAL]
    assert starting[1] == pytest.approx(2.5, abs=0.5)  # 2.5 t + 1.25 t^2 = 15 m
    assert met(40.5, -20.0, NORTH, 8.0, pull=-3.0) == [VIEW, NEVER, NEVER, MAX_ARRIVAL]


def test_turning_actor_conflicts_along_its_curve() -> None:
    oncoming = (60.0, 4.0, math.pi, 8.0)

    assert met(*oncoming) == [VIEW, NEVER, NEVER, MAX_ARRIVAL]
    along, *_ = met(*oncoming, turn=0.3)  # to its left, across the ego's lane
    assert 35.0 < along < 60.0


def test_only_actor_tokens_have_predicted_conflicts() -> None:
    actors = cars((20.0, 0.0, 0.0, 0.0))
    spec = TokenSpec(conflicts=True)

    tokens = tokens_of(EGO, actors, ROUTE, spec)

    assert tokens.attributes.shape[1] == spec.attributes == 10
    assert tokens.attributes[tokens.places != NO_ROW, 6:].any()
    assert not tokens.attributes[tokens.places == NO_ROW, 6:].any()
