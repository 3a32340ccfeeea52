"""The ego's controller: pure pursuit on the route, and plan following."""

import math

from plant_bench.agent import PLAN_INTERVAL, Control, Plan, RouteAhead
from plant_bench.world.scene import WHEELBASE, EgoState

REAR_AXLE = 0.5 * WHEELBASE  # m behind the box centre

LOOKAHEAD_TIME = 0.45  # s
LOOKAHEAD_LEAST = 3.5  # m from the rear axle

PLAN_RESPONSE = 0.4  # s to reach the planned speed
PLAN_STANDSTILL = 0.4  # m/s of planned speed below which the ego stops (PlanT, PlanT_agent.py)


def follow_route(ego: EgoState, route: RouteAhead) -> float:
    """Return the steering angle that leads the rear axle onto the route (pure pursuit), radians."""
    reach = max(LOOKAHEAD_LEAST, LOOKAHEAD_TIME * ego.speed + 2.0)
    cos, sin = math.cos(ego.yaw), math.sin(ego.yaw)
    rear_x, rear_y = ego.x - REAR_AXLE * cos, ego.y - REAR_AXLE * sin
    points = route.points
    aim_x = aim_y = 0.0
    for index in range(max(int(reach - REAR_AXLE), 0), len(points)):
        aim_x, aim_y = points[index].tolist()
        if math.hypot(aim_x - rear_x, aim_y - rear_y) >= reach:
            break
    return _pursue(cos, sin, aim_x - rear_x, aim_y - rear_y)


def _pursue(cos: float, sin: float, dx: float, dy: float) -> float:
    forward, left = cos * dx + sin * dy, cos * dy - sin * dx
    square = forward * forward + left * left
    if square < 1.0:
        return 0.0
    return math.atan(2.0 * WHEELBASE * left / square)


def control_of(action: Plan | Control, ego: EgoState) -> Control:
    """Return the control that executes an action."""
    return action if isinstance(action, Control) else follow_plan(action, ego)


def follow_plan(plan: Plan, ego: EgoState) -> Control:
    """Return the control that drives a plan's waypoints.

    The target speed is that between the first two waypoints; the steering aims at the first
    waypoint beyond the lookahead distance (PlanT, PlanT_agent.py; pure pursuit instead of its PID
    controller, since the vehicle's geometry is known here).
    """
    waypoints = plan.waypoints.tolist()
    (x0, y0), (x1, y1) = waypoints[:2]
    speed = math.hypot(x1 - x0, y1 - y0) / PLAN_INTERVAL
    if speed < PLAN_STANDSTILL:
        return Control(-3.0 if ego.speed > 0.1 else -1.0, 0.0)
    reach = max(LOOKAHEAD_LEAST, LOOKAHEAD_TIME * ego.speed + 2.0)
    aim = next(
        ((x, y) for x, y in waypoints if math.hypot(x + REAR_AXLE, y) >= reach), waypoints[-1]
    )
    steering = _pursue(1.0, 0.0, aim[0] + REAR_AXLE, aim[1])
    return Control((speed - ego.speed) / PLAN_RESPONSE, steering)
