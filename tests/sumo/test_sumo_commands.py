"""Commands to vehicles that a hazard script places, and to those around them."""

import math

import pytest

from plant_bench.data_files import networks_dir
from plant_bench.sim.sumo import Sumo
from plant_bench.sim.vehicle_types import CAR

pytestmark = pytest.mark.sumo

EDGES = ("inner_on_s_end", "inner_off_w_begin")  # a motorway of three lanes


@pytest.mark.parametrize("keep", [True, False])
def test_only_a_vehicle_told_to_keep_its_lane_stays_centred(keep):
    """SUMO crashes if a vehicle is placed while it changes lanes."""
    with Sumo(networks_dir() / "town04" / "town.net.xml", 1) as sumo:
        sumo.add_vehicle(1, CAR.name, EDGES, 1, 50.0, 10.0)
        if keep:
            sumo.commands.keep_lane(1)
        centred = []
        for _ in range(300):  # the lane to its right is free
            sumo.step()
            centred.append(sumo.commands.is_centred(1))
    assert all(centred) is keep


def test_sumo_lane_order_is_stale_until_a_placed_vehicle_is_reseated():
    """If the first assertion fails, SUMO sorts its lanes itself and `reseat` can be removed."""
    with Sumo(networks_dir() / "town04" / "town.net.xml", 1) as sumo:
        commands = sumo.commands
        sumo.add_vehicle(1, CAR.name, EDGES, 1, 50.0, 10.0)
        sumo.step()
        commands.keep_lane(1)
        state = sumo.state_of(1)
        assert state is not None
        commands.add_scripted(2, CAR.name, EDGES[0])
        for ahead in (30.0, 30.0, -15.0):  # m from the front of 1 to the middle of 2
            x = state.x + ahead * math.cos(state.yaw)
            y = state.y + ahead * math.sin(state.yaw)
            commands.place(2, CAR.length, x, y, state.yaw, 0.0)
            sumo.step()
        assert commands.is_out_of_order(2)
        commands.reseat(2)
        assert not commands.is_out_of_order(2)
        placed = sumo.state_of(2)
        assert placed is not None
        assert placed.lane == state.lane
