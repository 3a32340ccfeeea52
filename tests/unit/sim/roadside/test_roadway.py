import numpy as np
import pytest

from plant_bench.geometry.polyline import resample
from plant_bench.sim.roadside import lane_distance as room
from plant_bench.sim.roadside.lane_distance import NEAR, SPACING, Roadway
from plant_bench.world.town import load_town


@pytest.mark.parametrize("reach", [0.5, 5.0, 15.0])
def test_clearance_is_the_distance_to_the_nearest_lane(reach, monkeypatch):
    town = load_town("town01")
    roadway, rng = Roadway(town), np.random.default_rng(0)
    lanes = list(town.lanes.values())
    lines = [resample(lane.points[:, :2], SPACING) for lane in lanes]
    for lane in lanes[::7]:
        middle = lane.points[len(lane.points) // 2, :2] + rng.uniform(-15.0, 15.0, 2)
        places = middle + rng.uniform(-reach, reach, (6, 2))

        every = [
            np.hypot(*(places[:, None] - line).transpose(2, 0, 1)).min(axis=1) - 0.5 * other.width
            for other, line in zip(lanes, lines, strict=True)
        ]

        found = roadway.clearance(places)
        assert found == pytest.approx(np.min(every, axis=0), abs=1e-9)
        with monkeypatch.context() as patch:
            patch.setattr(room, "BESIDE", -1e6)  # no lane counts as beside: all are considered
            assert roadway.clearance(places).tobytes() == found.tobytes()


def test_clearance_far_from_all_lanes_is_the_search_radius():
    roadway = Roadway(load_town("town01"))
    assert roadway.clearance(np.full((3, 2), 1e5)).tolist() == [NEAR] * 3
