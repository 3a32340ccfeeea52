"""The reward of Roach (Zhang et al., ICCV 2021): desired speed, route following, smooth control.

The constants are from zhejz/carla-roach: carla_gym/core/task_actor/ego_vehicle/reward/
valeo_action.py, terminal/valeo_no_det_px.py and carla_gym/utils/hazard_actor.py. Differences:

- Roach ends an episode at a collision or a red light. Here the episode continues, and each
  infraction has a cost.
- Roach ignores pedestrians on sidewalks. Here those away from the route are ignored.
- Parked cars away from the route are ignored, too (Roach's towns have none); otherwise stopping
  beside them would maximise the reward.
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
ONCOMING = math.radians(150.0)  # relative heading beyond which a vehicle is no hazard
WALKER_CONE, WALKER_NEAR, WALKER_FAR = 162.0, 1.5, 10.5  # degrees x m; m (lbc_hazard_walker)
WALKER_EXTRA = 0.3  # m added to the distance in the cone's formula
LIGHT_AHEAD = 18.0  # m (dist_threshold)
STOP_AT = {"vehicle": 8.0, "walker": 6.0, "light": 5.0}  # m from the ego's centre
RAMP = 5.0  # m over which the desired speed falls to 0
STEERING_TOLERANCE = 0.01  # fraction of the steering range: smaller changes cost nothing
STEERING_COST = -0.1  # reward of a larger change
POSITION = 2.0  # m of lateral offset that cost 1
TERMINAL = -1.0  # reward of an event that would end Roach's episode
RELEVANT_DISTANCE = 2.0  # m from the route, for pedestrians and parked cars; not from Roach

FATAL = frozenset(  # cost 1 plus the ego's speed in m/s
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
        top_speed: Desired speed on a free road, m/s. Default: Roach's 6; speed limits here are 8 to
            25.
    """

    def __init__(self, top_speed: float = TOP_SPEED) -> None:
        self._top = top_speed

    def __call__(self, transition: Transition) -> dict[str, float]:
        """Return the five terms by name."""
        ego, route = transition.after.ego, transition.observation.route
        speed_error = abs(ego.speed - desired_speed(transition.observation, self._top))
        turned = abs(transition.control.steering - transition.last_control.steering)
        return {
            "speed": 1.0 - speed_error / self._top,
            "position": 0.0 if route is None else -abs(route.offset) / POSITION,
            "rotation": 0.0 if route is None else -abs(wrap_angle(ego.yaw - route.headings[0])),
            "action": STEERING_COST if turned > STEERING_TOLERANCE * STEERING_LIMIT else 0.0,
            "terminal": _terminal(transition),
        }


def desired_speed(observation: Observation, top_speed: float) -> float:
    """Return the speed that vehicles, walkers and the next light allow, m/s."""
    actors, route = observation.actors, observation.route
    gaps = [_light_gap(observation.light)]
    if actors is not None and route is not None and len(actors):
        gaps += _hazard_gaps(observation, actors, route)
    return top_speed * min(max(min(gaps), 0.0), RAMP) / RAMP


def _light_gap(light: NextLight | None) -> float:
    """Return the distance from the ego's centre to its stopping point at a light, metres."""
    if light is None or light.state not in STOPS or light.distance < -CROSSED:
        return math.inf
    distance = light.distance + 0.5 * EGO_LENGTH
    return distance - STOP_AT["light"] if distance < LIGHT_AHEAD else math.inf


def _hazard_gaps(observation: Observation, actors: Actors, route: RouteAhead) -> list[float]:
    """Return the distances to the stopping points at the nearest vehicle and pedestrian, metres."""
    ego = observation.ego
    x, y = to_frame(actors.poses[:, :2].astype(float), *ego.pose).T
    distance, angle = np.hypot(x, y), np.abs(np.arctan2(y, x))
    pedestrian = actors.kinds == ActorKind.PEDESTRIAN
    turned = np.abs(wrap_angles(actors.poses[:, 2].astype(float) - ego.yaw))
    cone = np.radians(WALKER_CONE / (distance.clip(WALKER_NEAR, WALKER_FAR) + WALKER_EXTRA))
    near = distance < HAZARD_RANGE
    vehicles = near & ~pedestrian & (angle < VEHICLE_ANGLE) & (turned <= ONCOMING)
    walkers = near & pedestrian & (angle < cone)
    relevant = _relevant(actors, route, vehicles | walkers)
    return [
        float(np.min(distance[chosen & relevant], initial=np.inf)) - STOP_AT[kind]
        for kind, chosen in (("vehicle", vehicles), ("walker", walkers))
    ]


def _relevant(
    actors: Actors, route: RouteAhead, candidates: Bool[np.ndarray, " actors"]
) -> Bool[np.ndarray, " actors"]:
    """Return a mask without the candidates that are pedestrians or parked cars off the route."""
    relevant = np.ones(len(actors), bool)
    off_road = (actors.kinds == ActorKind.PEDESTRIAN) | actors.parked
    rows = np.flatnonzero(off_road & candidates)
    if rows.size and len(route.points) > 1:
        relevant[rows] = distances_to(route.points, _centres(actors, rows)) < RELEVANT_DISTANCE
    return relevant


def _centres(actors: Actors, rows: np.ndarray) -> Float[np.ndarray, "actors 2"]:
    return actors.poses[rows, :2].astype(float)


def _terminal(transition: Transition) -> float:
    fatal = [item for item in transition.infractions if item.kind in FATAL]
    value = len(fatal) * (TERMINAL - transition.after.ego.speed)
    return value + (TERMINAL if transition.status in FAILED else 0.0)
