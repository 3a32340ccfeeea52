"""The ego vehicle's dynamics: a kinematic bicycle model with actuator limits."""

import math

from plant_bench.agent import Control
from plant_bench.geometry.pose import wrap_angle
from plant_bench.world.scene import TICK, WHEELBASE, EgoState

REAR_AXLE = 0.5 * WHEELBASE  # m behind the box centre
STEERING_LIMIT = math.radians(35.0)  # rad; turns in a radius of 4.1 m
STEERING_RATE = 1.0  # rad/s at the wheels: lock to lock in 1.2 s
ACCELERATION_LIMIT = 3.5  # m/s2
BRAKING_LIMIT = 8.0  # m/s2, a full stop on dry asphalt
ACCELERATION_RATE = 40.0  # m/s3: full braking after 0.2 s


def advance(ego: EgoState, control: Control, duration: float = TICK) -> EgoState:
    """Return the ego's state after `duration` seconds of a control.

    The rear axle follows the heading, which turns at speed / wheelbase * tan(steering); heading and
    speed of the middle of the interval are used, so that a circle stays a circle.
    """
    target = min(max(control.steering, -STEERING_LIMIT), STEERING_LIMIT)
    turn = STEERING_RATE * duration
    steering = ego.steering + min(max(target - ego.steering, -turn), turn)
    acceleration = min(max(control.acceleration, -BRAKING_LIMIT), ACCELERATION_LIMIT)
    ramp = ACCELERATION_RATE * duration
    acceleration = ego.acceleration + min(max(acceleration - ego.acceleration, -ramp), ramp)
    speed = max(ego.speed + acceleration * duration, 0.0)
    distance = 0.5 * (ego.speed + speed) * duration
    bend = distance / WHEELBASE * math.tan(steering)
    middle = ego.yaw + 0.5 * bend
    rear_x = ego.x - REAR_AXLE * math.cos(ego.yaw) + distance * math.cos(middle)
    rear_y = ego.y - REAR_AXLE * math.sin(ego.yaw) + distance * math.sin(middle)
    yaw = ego.yaw + bend
    return EgoState(
        x=rear_x + REAR_AXLE * math.cos(yaw),
        y=rear_y + REAR_AXLE * math.sin(yaw),
        yaw=wrap_angle(yaw),
        speed=speed,
        acceleration=(speed - ego.speed) / duration,
        steering=steering,
    )
