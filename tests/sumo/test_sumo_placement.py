"""Placed vehicles neither vanish nor crash SUMO, wherever they are placed."""

import math
import subprocess
import sys

import numpy as np
import pytest

from plant_bench.data_files import networks_dir, town_dir
from plant_bench.sim.entry_lanes import StreetGrid
from plant_bench.sim.roadside.sumo_proxies import SumoProxies
from plant_bench.sim.sumo import Sumo
from plant_bench.sim.sumo_placement import Placements
from plant_bench.sim.traffic import Traffic
from plant_bench.sim.vehicle_types import CAR
from plant_bench.world.actor_ids import EGO, SUMO_PROXIES
from plant_bench.world.town import Lane, Town

pytestmark = pytest.mark.sumo

MOTORWAY = ("inner_on_s_end", "inner_off_w_begin")  # of town04, with three lanes

# An ego that crosses the lanes at the start of an edge, and leaves the road there. Two cars overlap
# the edge before. Without `refresh`, SUMO 1.28 ends with SIGSEGV.
ACROSS_LANES = """
import math
import sys
import libsumo
from plant_bench.data_files import networks_dir
from plant_bench.sim.sumo import Sumo
from plant_bench.sim.sumo_placement import Placements
from plant_bench.sim.vehicle_types import CAR

if sys.argv[1] == "unpatched":
    Placements.refresh = lambda self, lanes: None
POSES = [
    (220.38, 506.35, 0.44), (220.84, 506.87, 0.6), (221.22, 507.44, 0.74), (221.55, 508.03, 0.87),
    (221.81, 508.65, 0.98), (222.03, 509.29, 1.08), (222.21, 509.93, 1.16), (222.35, 510.58, 1.24),
    (222.47, 511.23, 1.29), (222.57, 511.88, 1.34), (222.65, 512.54, 1.38), (222.74, 513.19, 1.4),
    (222.83, 513.84, 1.41), (222.93, 514.48, 1.41), (223.05, 515.13, 1.4),
]
with Sumo(networks_dir() / "town06" / "town.net.xml", 1) as sumo:
    sumo.add_ego(("inner_off_n_begin", "inner_off_n"), *POSES[0])
    sumo.watch(80.0)
    x, y = libsumo.simulation.convert2D("inner_off_n", 0.5, 3)
    yaw = math.radians(90.0 - libsumo.lane.getAngle("inner_off_n_3", 0.5))
    for car in (1, 2):
        sumo.commands.add_scripted(car, CAR.name, "inner_off_n")
    for pose in POSES + [(223.1 + 0.2 * tick, 515.1 + 0.63 * tick, 1.4) for tick in range(1, 20)]:
        sumo.move_ego(*pose, 13.1)
        for car in (1, 2):
            back = (0.8 - 0.3 * car) * CAR.length
            sumo.commands.place(
                car, CAR.length, x - back * math.cos(yaw), y - back * math.sin(yaw), yaw, 0.0
            )
        sumo.step()
        sumo.watched()
"""


def end_of_a_lane() -> tuple[Town, Lane, tuple[float, float, float]]:
    """Return town01, one of its lanes, and the pose of that lane's end."""
    town = Town.from_json((town_dir("town01") / "town.json").read_text())
    lane = next(each for each in town.lanes.values() if each.junction is None and each.length > 50)
    (from_x, from_y), (x, y) = lane.points[-2:, :2].tolist()
    return town, lane, (x, y, math.atan2(y - from_y, x - from_x))


def test_pedestrian_walking_over_the_end_of_a_lane_stays_visible_to_sumo():
    town, lane, (x, y, yaw) = end_of_a_lane()
    with Sumo(networks_dir() / "town01" / "town.net.xml", 1) as sumo:
        proxies = SumoProxies(sumo.commands, Traffic(sumo, StreetGrid(town), 0.0, 0), lane.edge)
        for tick in range(1, 40):
            at = -0.8 + 1.3 * 0.05 * tick
            pose = (x + at * math.cos(yaw), y + at * math.sin(yaw), yaw)
            proxies.show(tick, 4, pose, 1.3)
            sumo.step()
            assert sumo.exists(SUMO_PROXIES.start)


def test_ego_that_drives_past_the_end_of_its_route_is_kept():
    _, lane, (x, y, yaw) = end_of_a_lane()
    with Sumo(networks_dir() / "town01" / "town.net.xml", 1) as sumo:
        sumo.add_ego((lane.edge,), x - 20.0 * math.cos(yaw), y - 20.0 * math.sin(yaw), yaw)
        sumo.watch(80.0)
        sumo.commands.add_scripted(1, CAR.name, lane.edge)
        for tick in range(60):
            at = -20.0 + 0.5 * tick
            sumo.commands.place(
                1, CAR.length, x - 40.0 * math.cos(yaw), y - 40.0 * math.sin(yaw), yaw, 0.0
            )
            sumo.move_ego(x + at * math.cos(yaw), y + at * math.sin(yaw), yaw, 10.0)
            sumo.step()
            assert sumo.exists(EGO)
            assert 1 in sumo.watched()


@pytest.mark.parametrize(("version", "status"), [("unpatched", -11), ("patched", 0)])
def test_ego_leaving_the_road_across_several_lanes_does_not_crash_sumo(version, status):
    """If the first case fails, SUMO has mended its fault and `_reseat` can be removed."""
    done = subprocess.run([sys.executable, "-c", ACROSS_LANES, version], check=False)
    assert done.returncode == status


def test_command_to_a_vehicle_that_has_left_has_no_effect():
    with Sumo(networks_dir() / "town01" / "town.net.xml", 1) as sumo:
        commands = sumo.commands
        commands.keep_lane(5)
        commands.drive(5, 3.0, ignores_rules=True)
        commands.brake(5, 4.0)
        commands.release(5)
        commands.withdraw(5)
        commands.place(5, 4.0, 0.0, 0.0, 0.0, 0.0)
        assert not commands.is_centred(5)
        sumo.step()


def on_motorway() -> tuple[float, float, float]:
    """Return the pose of a place on the middle lane of `MOTORWAY`."""
    town = Town.from_json((town_dir("town04") / "town.json").read_text())
    lane = town.lanes[f"{MOTORWAY[0]}_1"]
    (x, near_x), (y, near_y) = (
        np.interp((120.0, 121.0), lane.along, column).tolist() for column in lane.points[:, :2].T
    )
    return x, y, math.atan2(near_y - y, near_x - x)


@pytest.mark.parametrize("shown", [True, False])
def test_driver_in_the_next_lane_stops_behind_an_ego_that_stands_half_in_it(shown, monkeypatch):
    """If the second case fails, SUMO shows the ego itself and the jumps can be removed."""
    if not shown:
        monkeypatch.setattr(Placements, "refresh", lambda self, lanes: None)
    x, y, yaw = on_motorway()
    with Sumo(networks_dir() / "town04" / "town.net.xml", 1) as sumo:
        sumo.add_ego(MOTORWAY, x, y, yaw)
        sumo.watch(150.0)
        for tick in range(300):
            aside = min(1.6, 0.05 * tick)  # to the left, across the lane's edge
            sumo.move_ego(x - aside * math.sin(yaw), y + aside * math.cos(yaw), yaw, 0.0)
            sumo.step()
            sumo.watched()
            if tick == 60:
                sumo.add_vehicle(1, CAR.name, MOTORWAY, 2, 40.0, 10.0)
            if tick > 60:
                sumo.commands.keep_lane(1)
        passed = sumo.state_of(1)
        assert passed is not None
        assert (passed.lane_position < 125.0) is shown
        assert (passed.speed < 0.1) is shown


def test_drivers_go_on_when_the_ego_has_returned_to_its_lane():
    x, y, yaw = on_motorway()
    with Sumo(networks_dir() / "town04" / "town.net.xml", 1) as sumo:
        sumo.add_ego(MOTORWAY, x, y, yaw)
        sumo.watch(150.0)
        for tick in range(400):
            aside = min(1.6, 0.05 * tick) if tick < 60 else max(0.0, 1.6 - 0.05 * (tick - 60))
            sumo.move_ego(x - aside * math.sin(yaw), y + aside * math.cos(yaw), yaw, 0.0)
            sumo.step()
            sumo.watched()
            if tick == 120:
                sumo.add_vehicle(1, CAR.name, MOTORWAY, 2, 40.0, 10.0)
            if tick > 120:
                sumo.commands.keep_lane(1)
        passed = sumo.state_of(1)
        assert passed is None or passed.lane != f"{MOTORWAY[0]}_2" or passed.lane_position > 130.0
