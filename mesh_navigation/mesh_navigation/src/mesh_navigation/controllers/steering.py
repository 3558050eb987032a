"""From the carrot to speeds: the law of the released mesh_controller, completed."""

import math
from typing import Any, Mapping, NamedTuple

import numpy as np

from mesh_navigation.base.outcomes import ExePathOutcome
from mesh_navigation.base.pose import vector_text
from mesh_navigation.base.robot import Velocity
from mesh_navigation.controllers.carrot import Carrot
from mesh_navigation.controllers.sight import Sight
from mesh_navigation.controllers.vector3 import Vector3
from mesh_navigation.controllers.local_path import LocalPath
from mesh_navigation.plugins.controller import ControlFailure


def braking_speed(distance: float, deceleration: float, period: float) -> float:
    """The highest speed at which one still stops within a distance.

    The speed holds for one period, then falls by ``deceleration * period`` each period until it is
    0: m speeds v, v - a T, v - 2 a T and so on lead m v T - a T^2 m (m - 1) / 2 far. The same for
    angles.

    Args:
        distance: m, or rad.
        deceleration: m/s^2, or rad/s^2, above 0.
        period: of commands, s, above 0.
    """
    if not distance > 0.0:
        return 0.0
    if math.isinf(distance):
        return math.inf
    step = deceleration * period
    count = max(math.ceil((math.sqrt(1 + 8 * distance / (step * period)) - 1) / 2), 1)
    return (distance / period + step * count * (count - 1) / 2) / count


def stopping_distance(speed: float, deceleration: float, period: float) -> float:
    """What is driven until it stands: one period at this speed, then braking (m)."""
    return speed * period + speed * speed / (2 * deceleration)


def limited(value: float, limit: float) -> float:
    """Within -limit to limit."""
    return max(-limit, min(limit, value))


def approached(target: float, present: float, step: float) -> float:
    """As near to a target as one step from the present value allows."""
    return present + limited(target - present, step)


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


_MOST = 32  # places that are looked at


def speed_before_bends(
    way: LocalPath, up: Vector3, farthest: float, values: Mapping[str, Any], period: float
) -> float:
    """The highest speed from which one can brake to that of each bend of the way (m/s).

    Those nearer than lookahead_distance are left out: the angle to the carrot tells of them.

    Args:
        way: ahead of the robot.
        up: from the surface.
        farthest: m, to where bends count: the robot can stop before all others.
        values: of the parameters.
        period: of commands (s).
    """
    look = values["lookahead_distance"]
    farthest = min(farthest, way.length - look / 2)
    if farthest <= look:
        return math.inf
    places = np.linspace(look, farthest, min(math.ceil((farthest - look) / (look / 4)) + 1, _MOST))
    before = _level(way, places - look / 2, places, up)
    behind = _level(way, places, places + look / 2, up)
    angles = np.arccos(np.clip(np.einsum("ij,ij->i", before, behind), -1.0, 1.0))
    brakes = values["max_lin_acceleration"]
    return min(
        math.hypot(speed_towards(angle, look, values), braking_speed(place, brakes, period))
        for place, angle in zip(places.tolist(), angles.tolist())
    )


def _level(way: LocalPath, starts: np.ndarray, ends: np.ndarray, up: Vector3) -> np.ndarray:
    """(N,3) directions of length 1 between points of the way, as seen from above."""
    chords = _at(way, ends) - _at(way, starts)
    chords -= (chords @ np.array(up))[:, None] * np.array(up)
    return chords / np.maximum(np.linalg.norm(chords, axis=1, keepdims=True), 1e-9)


def _at(way: LocalPath, lengths: np.ndarray) -> np.ndarray:
    columns = (np.interp(lengths, way.travelled, way.points[:, axis]) for axis in range(3))
    return np.stack(list(columns), axis=1)


CLEARANCE = 0.05  # m that an arc has to be free beyond where the robot would stand
_SHARES = 1.0, 0.7, 0.4, 0.2, 0.1  # of a speed, until its arc is free
_STRAIGHT = 0.02  # rad; an arc to what is less to the side is the straight line to it


def on_free_ground(
    wanted: Velocity, sight: Sight, carrot: Carrot, values: Mapping[str, Any], period: float
) -> Velocity:
    """The fastest share of a velocity whose arc is free until the robot could stand; a turn on the
    spot where there is none.

    Args:
        wanted: that velocity, towards the carrot.
        sight: from where the robot is.
        carrot: beyond it, nothing is looked at.
        values: of the parameters.
        period: of commands (s).

    Raises:
        ControlFailure: BLOCKED_PATH, the robot cannot turn either.
    """
    is_straight = abs(carrot.angle) < _STRAIGHT
    if is_straight and not sight.has_obstacles:
        return wanted
    if wanted.x > 0.0:
        for share in _SHARES:
            speed = share * wanted.x
            length = stopping_distance(speed, values["max_lin_acceleration"], period) + CLEARANCE
            length = min(length, _arc_length(carrot))
            if sight.free_arc(wanted.yaw / speed, length) is None:
                return wanted._replace(x=speed)
        if is_straight:
            raise touching(sight)
        wanted = Velocity(yaw=turning_speed(carrot.angle, values, period))
    return free_turn(wanted, sight, values, period)


def free_turn(wanted: Velocity, sight: Sight, values: Mapping[str, Any], period: float) -> Velocity:
    """A turn on the spot, until it could stand.

    Raises:
        ControlFailure: BLOCKED_PATH, the footprint would touch something.
    """
    angle = stopping_distance(abs(wanted.yaw), values["max_ang_acceleration"], period)
    if not sight.can_turn(math.copysign(angle, wanted.yaw)):
        raise touching(sight)
    return wanted


def touching(sight: Sight) -> ControlFailure:
    """That the robot cannot get on, for its footprint."""
    return ControlFailure(
        ExePathOutcome.BLOCKED_PATH,
        f"the robot at {vector_text(sight.surface_pose.position)} cannot get on: its footprint "
        "would touch lethal or unknown ground, ahead and in a turn",
    )


def _arc_length(carrot: Carrot) -> float:
    """From the robot to the carrot (m)."""
    angle = min(abs(carrot.angle), SHARP)
    return carrot.distance * angle / math.sin(angle) if angle > 0.0 else carrot.distance
