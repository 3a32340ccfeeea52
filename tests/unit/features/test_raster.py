"""The bird's-eye view: what is drawn where, and that it turns with the ego."""

import math
from dataclasses import replace

import numpy as np
import pytest

from plant_bench.agent import NextLight, Observation, RouteAhead
from plant_bench.errors import AgentError, InputError
from plant_bench.features.raster import ROACH, Rasteriser, RasterSpec
from plant_bench.features.raster_layers import Layer, brightness
from plant_bench.world.route import load_suite
from plant_bench.world.scene import ActorKind, Actors, EgoState, Light
from plant_bench.world.town import Town, load_town
from tests.builders import make_actors, make_ego, make_lane, make_observation, straight_route_ahead

SPEC = RasterSpec(size=100, scale=2.0, below=20)
EGO_ROW, EGO_COLUMN = 80, 50


def straight_town() -> Town:
    """Two lanes to the east side by side, from x = 0 to 200 at y = 0 and 3.5."""
    lanes = [
        make_lane("a_0", [(0.0, 0.0), (200.0, 0.0)], speed_limit=10.0, left="a_1"),
        make_lane("a_1", [(0.0, 3.5), (200.0, 3.5)], speed_limit=10.0, right="a_0"),
    ]
    return Town("straight", {lane.id: lane for lane in lanes}, (), {}, {})


def seen(
    *cars: tuple[float, float],
    kind: ActorKind = ActorKind.CAR,
    speed: float = 10.0,
    light: NextLight | None = None,
    time: float = 0.0,
) -> Observation:
    """The observation of an ego at (100, 0) that heads east on its route."""
    return make_observation(
        time=time,
        ego=make_ego(5.0, x=100.0),
        actors=make_actors(cars, speeds=speed, extents=(4.0, 2.0), kinds=kind),
        route=straight_route_ahead(60, start=(100.0, 0.0)),
        light=light,
    )


def drawn(observation: Observation, layer: Layer, spec: RasterSpec = SPEC) -> np.ndarray:
    return Rasteriser(straight_town(), replace(spec, layers=(layer,))).draw(observation)[-1]


def test_car_ahead_on_the_left_is_drawn_above_on_the_left() -> None:
    rows, columns = np.nonzero(drawn(seen((110.0, 5.0)), Layer.VEHICLES))
    assert rows.mean() == pytest.approx(EGO_ROW - 20 - 0.5, abs=0.5)
    assert columns.mean() == pytest.approx(EGO_COLUMN - 10 - 0.5, abs=0.5)
    assert len(rows) == pytest.approx(8 * 4, rel=0.5)  # 4 m x 2 m at 2 pixels a metre


def test_ego_is_drawn_at_the_specified_pixel() -> None:
    rows, columns = np.nonzero(drawn(seen(), Layer.EGO))
    assert rows.mean() == pytest.approx(EGO_ROW - 0.5, abs=0.5)
    assert columns.mean() == pytest.approx(EGO_COLUMN - 0.5, abs=0.5)


def test_road_and_markings_are_drawn_at_the_lanes() -> None:
    road = drawn(seen(), Layer.ROAD)[EGO_ROW] > 0  # from 1.75 m right to 5.25 m left of the ego
    assert np.flatnonzero(road).tolist() == list(range(EGO_COLUMN - 11, EGO_COLUMN + 4)) or (
        np.flatnonzero(road)[[0, -1]] == pytest.approx([EGO_COLUMN - 11, EGO_COLUMN + 3], abs=1)
    )
    lines = drawn(seen(), Layer.LANE_LINES)[EGO_ROW]
    assert set(lines[EGO_COLUMN - 5 : EGO_COLUMN - 2]) == {0, 120}  # between the two lanes
    assert lines[EGO_COLUMN + 2 : EGO_COLUMN + 5].max() == 255  # the kerb


def test_raster_rotates_with_the_ego() -> None:
    town = load_town("town03")
    route = load_suite("longest6")[14]
    assert route.town == "town03"
    for index in (50, 200, 400, 800):
        points = route.points[index : index + 60]
        x, y = points[0].tolist()
        ego = EgoState(x, y, float(route.headings[index]), 5.0)
        headings = route.headings[index : index + 60]
        ahead = RouteAhead(0.0, 0.0, 0.0, points, headings, np.full(60, 9.0))
        observation = Observation(0.0, ego, 9.0, Actors.none(), ahead)
        road, way = Rasteriser(town, RasterSpec(layers=(Layer.ROAD, Layer.ROUTE))).draw(observation)
        assert np.count_nonzero(way) > 1000
        assert np.mean(road[way > 0] > 0) > 0.99  # the route lies on the road


def test_pedestrians_are_drawn_as_vulnerable_not_as_vehicles() -> None:
    walker = seen((105.0, 0.0), kind=ActorKind.PEDESTRIAN)
    assert drawn(walker, Layer.VULNERABLE).any()
    assert not drawn(walker, Layer.VEHICLES).any()


def test_speed_is_encoded_as_brightness() -> None:
    assert drawn(seen((110.0, 0.0), speed=10.0), Layer.SPEEDS).max() == brightness(10.0) == 155


@pytest.mark.parametrize(("state", "value"), [(Light.GREEN, 80), (Light.YELLOW, 170)])
def test_next_light_is_drawn_as_a_coloured_stop_line(state: Light, value: int) -> None:
    line = drawn(seen(light=NextLight(state, 7.55)), Layer.LIGHTS)  # 10 m from the ego's centre
    rows, _ = np.nonzero(line)
    assert line.max() == value
    assert rows.mean() == pytest.approx(EGO_ROW - 20 - 0.5, abs=1.0)
    assert not drawn(seen(), Layer.LIGHTS).any()


def test_past_layers_show_earlier_positions() -> None:
    spec = replace(SPEC, layers=(Layer.VEHICLES,), past=(0.5,))
    rasteriser = Rasteriser(straight_town(), spec)
    for time, x in ((0.0, 105.0), (0.25, 107.0), (0.5, 109.0), (0.75, 111.0)):
        before, now = rasteriser.draw(seen((x, 0.0), time=time))
    assert np.nonzero(now)[0].mean() == pytest.approx(EGO_ROW - 22 - 0.5, abs=0.5)
    assert np.nonzero(before)[0].mean() == pytest.approx(EGO_ROW - 14 - 0.5, abs=0.5)


def test_roach_raster_has_15_channels() -> None:
    assert len(ROACH.channels) == 15
    assert ROACH.channels[3:7] == ("vehicles-1.5", "vehicles-1", "vehicles-0.5", "vehicles")
    assert Rasteriser(straight_town(), ROACH).draw(seen()).shape == (15, 192, 192)


def test_invalid_raster_specs_are_refused() -> None:
    with pytest.raises(InputError, match="positive"):
        RasterSpec(scale=0.0)
    with pytest.raises(InputError, match="past"):
        RasterSpec(past=(0.0,))
    with pytest.raises(AgentError, match="objects"):
        drawn(replace(seen(), actors=None), Layer.EGO)


def test_full_turn_gives_the_same_raster() -> None:
    one = seen((110.0, 5.0))
    turned = replace(one, ego=replace(one.ego, yaw=2.0 * math.pi))
    assert np.array_equal(drawn(one, Layer.VEHICLES), drawn(turned, Layer.VEHICLES))
