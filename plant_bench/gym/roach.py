"""Roach's reward (Zhang et al., ICCV 2021): drive as fast as what is near allows, on the route.

Constants are of zhejz/carla-roach, carla_gym/core/task_actor/ego_vehicle/reward/valeo_action.py,
terminal/valeo_no_det_px.py and carla_gym/utils/hazard_actor.py. What differs: Roach ends an episode
at a collision or a red light, here it goes on and each one costs; it knows who walks on a sidewalk,
here walkers beside the route are left out; parked cars beside the route, which its towns have not,
are left out as well, or standing beside them would be best.
"""

import math

import numpy as np
from jaxtyping import Bool, Float

from plant_bench.agent import NextLight, Observation, RouteAhead
from plant_bench.features.tokens import CROSSED, STOPS
from plant_bench.geometry.polyline import distances_to
from plant_bench.geometry.pose import to_frame, wrap_angle, wrap_angles
from plant_bench.gym.transition import Transition
from plant_bench.scoring.infractions import InfractionKind, Status
from plant_bench.sim.ego import STEERING_LIMIT
from plant_bench.world.scene import EGO_LENGTH, ActorKind, Actors

TOP_SPEED = 6.0  # m/s (_maxium_speed)
HAZARD_RANGE = 9.5  # m between centres (proximity_threshold)
VEHICLE_ANGLE = math.radians(45.0)  # to either side of the ego's heading (up_angle_th)
ONCOMING = math.radians(150.0)  # of relative heading, beyond which a vehicle is no hazard
WALKER_CONE, WALKER_NEAR, WALKER_FAR = 162.0, 1.5, 10.5  # degrees x m; m (lbc_hazard_walker)
WALKER_EXTRA = 0.3  # m added to the distance there
LIGHT_AHEAD = 18.0  # m (dist_threshold)
STOP_AT = {"vehicle": 8.0, "walker": 6.0, "light": 5.0}  # m from the ego's centre
RAMP = 5.0  # m over which the desired speed falls to 0
SMOOTH = 0.01  # of the steering range, a change that is not held against the driver
ROUGH = -0.1  # for a greater one
POSITION = 2.0  # m beside the route that cost 1
TERMINAL = -1.0  # for what would end Roach's episode
BESIDE = 2.0  # m from the route: own choice, see above

FATAL = frozenset(  # cost the speed as well
    {
        InfractionKind.COLLISION_PEDESTRIAN,
        InfractionKind.COLLISION_VEHICLE,
        InfractionKind.COLLISION_STATIC,
        InfractionKind.RED_LIGHT,
    }
)
FAILED = frozenset({Status.BLOCKED, Status.DEVIATED})


class RoachReward:
    """Speed, position, rotation, action and terminal terms.

    Args:
        top_speed: m/s wanted on a free road. Roach's 6; limits here are 8 to 25.
    """

    def __init__(self, top_speed: float = TOP_SPEED) -> None:
        self._top = top_speed

    def __call__(self, transition: Transition) -> dict[str, float]:
        """Return the five terms."""
        ego, route = transition.after.ego, transition.observation.route
        speed_error = abs(ego.speed - desired_speed(transition.observation, self._top))
        turned = abs(transition.control.steering - transition.last_control.steering)
        return {
            "speed": 1.0 - speed_error / self._top,
            "position": 0.0 if route is None else -abs(route.offset) / POSITION,
            "rotation": 0.0 if route is None else -abs(wrap_angle(ego.yaw - route.headings[0])),
            "action": ROUGH if turned > SMOOTH * STEERING_LIMIT else 0.0,
            "terminal": _terminal(transition),
        }


def desired_speed(observation: Observation, top_speed: float) -> float:
    """Return the speed that vehicles, walkers and the next light allow, m/s."""
    actors, route = observation.actors, observation.route
    rooms = [_light_room(observation.light)]
    if actors is not None and route is not None and len(actors):
        rooms += _hazard_rooms(observation, actors, route)
    return top_speed * min(max(min(rooms), 0.0), RAMP) / RAMP


def _light_room(light: NextLight | None) -> float:
    """Return the metres to where the ego's centre should stop."""
    if light is None or light.state not in STOPS or light.distance < -CROSSED:
        return math.inf
    distance = light.distance + 0.5 * EGO_LENGTH
    return distance - STOP_AT["light"] if distance < LIGHT_AHEAD else math.inf


def _hazard_rooms(observation: Observation, actors: Actors, route: RouteAhead) -> list[float]:
    ego = observation.ego
    x, y = to_frame(actors.poses[:, :2].astype(float), *ego.pose).T
    away, angle = np.hypot(x, y), np.abs(np.arctan2(y, x))
    walks = actors.kinds == ActorKind.PEDESTRIAN
    turned = np.abs(wrap_angles(actors.poses[:, 2].astype(float) - ego.yaw))
    cone = np.radians(WALKER_CONE / (away.clip(WALKER_NEAR, WALKER_FAR) + WALKER_EXTRA))
    near = away < HAZARD_RANGE
    vehicles = near & ~walks & (angle < VEHICLE_ANGLE) & (turned <= ONCOMING)
    walkers = near & walks & (angle < cone)
    counts = _counts(actors, route, vehicles | walkers)
    return [
        float(np.min(away[chosen & counts], initial=np.inf)) - STOP_AT[kind]
        for kind, chosen in (("vehicle", vehicles), ("walker", walkers))
    ]


def _counts(
    actors: Actors, route: RouteAhead, candidates: Bool[np.ndarray, " actors"]
) -> Bool[np.ndarray, " actors"]:
    """Return who is in the way or moves by road: walkers and parked cars only near the route."""
    counts = np.ones(len(actors), bool)
    beside = (actors.kinds == ActorKind.PEDESTRIAN) | actors.parked
    asked = np.flatnonzero(beside & candidates)
    if asked.size and len(route.points) > 1:
        counts[asked] = distances_to(route.points, _places(actors, asked)) < BESIDE
    return counts


def _places(actors: Actors, rows: np.ndarray) -> Float[np.ndarray, "actors 2"]:
    return actors.poses[rows, :2].astype(float)


def _terminal(transition: Transition) -> float:
    fatal = [item for item in transition.infractions if item.kind in FATAL]
    value = len(fatal) * (TERMINAL - transition.after.ego.speed)
    return value + (TERMINAL if transition.status in FAILED else 0.0)
