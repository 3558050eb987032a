"""From the carrot to speeds: the law of the released mesh_controller, completed."""

import math
from typing import Any, Mapping, NamedTuple

from mesh_navigation.controllers.carrot import Carrot
from mesh_navigation.controllers.speeds import braking_speed, limited
from mesh_navigation.robot import Velocity

SHARP = math.pi / 2  # rad; no arc leads to what is farther to the side
_DEAD_BEAT = 0.7  # of an angle is turned in one period at most: more would swing


def turning_speed(angle: float, values: Mapping[str, Any], period: float) -> float:
    """The fastest turn by an angle that stops there (rad/s)."""
    fastest = braking_speed(abs(angle), values["max_ang_acceleration"], period)
    fastest = min(fastest, _DEAD_BEAT * abs(angle) / period)
    return math.copysign(min(fastest, values["max_ang_velocity"]), angle)


def arc_to(angle: float, distance: float) -> float:
    """How much the arc bends (rad/m) that leads to what is straight so far away (m) at an angle of
    at least 0."""
    return 2 * math.sin(min(angle, SHARP)) / max(distance, 1e-6)


def speed_towards(angle: float, distance: float, values: Mapping[str, Any]) -> float:
    """The speed that the released law has for an angle of at least 0 to a carrot, at most that at
    which the robot can turn for the arc."""
    fastest, max_angle = values["max_lin_velocity"], math.radians(values["max_angle"])
    if angle > max_angle:
        return 0.0
    speed = min(fastest, fastest * (1 - angle / max_angle) * values["lin_vel_factor"])
    bend = arc_to(angle, distance)
    if not bend > 0.0:
        return speed
    # Within the time to the carrot the turn has to begin and to end, or it would weave.
    in_time = distance * math.sqrt(values["max_ang_acceleration"] / (2 * angle))
    return min(speed, values["max_ang_velocity"] / bend, in_time)


class Ahead(NamedTuple):
    """How far it is, in m along the way."""

    goal: float
    """To the goal; inf where that is beyond what is looked at."""
    stop: float
    """To where it has to stand because the way is blocked; inf where it is not."""
    bends: float = math.inf
    """The speed (m/s) from which it can still brake for the bends."""


def steer(carrot: Carrot, ahead: Ahead, values: Mapping[str, Any], period: float) -> Velocity:
    """The speeds that lead to the carrot, before accelerations are limited.

    The released law: speed falls from max_lin_velocity to 0 while the angle to the carrot grows
    from 0 to max_angle, and it turns by max_ang_velocity / pi for each radian; both times a factor,
    within their limits. Completed: it never turns more slowly than the arc to the carrot needs
    (pure pursuit: 2 v sin(angle) / distance) nor, with an angle that leaves it little speed, than
    nearly as on the spot; it drives only as fast as it can turn for that arc, and turns on the spot
    as fast as it may.

    Args:
        carrot: where to look.
        ahead: where to stop.
        values: of the parameters.
        period: of commands (s).
    """
    angle, max_angle = abs(carrot.angle), math.radians(values["max_angle"])
    bend = arc_to(angle, carrot.distance)
    speed = speed_towards(angle, carrot.distance, values)
    speed = min(speed, ahead.bends, _slowed_down(carrot, ahead, values, period))
    spot = abs(turning_speed(angle, values, period))
    if speed <= 0.0:
        return Velocity(yaw=math.copysign(spot, carrot.angle))
    law = angle * values["max_ang_velocity"] / math.pi * values["ang_vel_factor"]
    # The nearer to max_angle, the slower it drives, so the more it turns as on the spot: else it
    # would creep around corners with an angle just below max_angle.
    law = max(law, spot * angle / max_angle)
    turn = min(max(law, bend * speed), max(spot, bend * speed))
    return Velocity(
        x=speed, yaw=math.copysign(limited(turn, values["max_ang_velocity"]), carrot.angle)
    )


def _slowed_down(carrot: Carrot, ahead: Ahead, values: Mapping[str, Any], period: float) -> float:
    """The speed that arrival, what blocks the way and a carrot that is near allow."""
    brakes, slowest = values["max_lin_acceleration"], values["min_lin_velocity"]
    speed = values["max_lin_velocity"]
    if values["arrival_fading"] > 0.0:
        speed *= min(1.0, ahead.goal / values["arrival_fading"])
    if carrot.is_near:
        speed *= min(1.0, carrot.distance / values["lookahead_distance"])
    speed = max(speed, slowest)
    for distance in (ahead.goal, ahead.stop):
        speed = min(speed, braking_speed(distance, brakes, period))
    return speed
