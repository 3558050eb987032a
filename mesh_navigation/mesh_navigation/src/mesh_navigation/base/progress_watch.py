"""Whether a robot gets on."""

import math
from typing import Optional

from mesh_navigation.base.pose import Pose, multiply


class ProgressWatch:
    """Tells how long a robot has not got on: a way or a turn from where it last did.

    Times may jump back, as those of a simulation do: then the time begins anew.
    """

    def __init__(self) -> None:
        self._reference: Optional[Pose] = None
        self._since = 0.0
        self._last: Optional[Pose] = None
        self._turned = 0.0

    def got_on(self, pose: Pose, now: float, distance: float, angle: float) -> bool:
        """Note where the robot is; returns whether it got on since it last did.

        Args:
            pose: of the robot; the first one is the first reference.
            now: time (s).
            distance: m that count as getting on.
            angle: rad to one side that count as getting on; more than pi is possible.
        """
        if self._reference is None or self._last is None or now < self._since:
            self._begin(pose, now)
            return False
        # Turns are summed up: those between two poses are never larger than pi.
        self._turned += _turn_about_z(self._last, pose)
        self._last = pose
        way = math.dist(pose.position, self._reference.position)
        if way < distance and abs(self._turned) < angle:
            return False
        self._begin(pose, now)
        return True

    def _begin(self, pose: Pose, now: float) -> None:
        self._reference, self._since = pose, now
        self._last, self._turned = pose, 0.0

    def seconds(self, now: float) -> float:
        """For how long it has not got on; 0 before the first pose."""
        return max(0.0, now - self._since) if self._reference is not None else 0.0


def _turn_about_z(first: Pose, second: Pose) -> float:
    """How far to the left the robot has turned (rad, -pi to pi), about its own z axis."""
    x, y, z, w = first.orientation.tolist()
    _, _, z, w = multiply((-x, -y, -z, w), second.orientation).tolist()
    return math.remainder(2.0 * math.atan2(z, w), 2.0 * math.pi)


def angle_between(first: Pose, second: Pose) -> float:
    """The angle of the shortest turn from one orientation to another (rad, 0 to pi)."""
    q1, q2 = first.orientation, second.orientation
    # atan2 of |q1 - q2| and |q1 + q2| is exact for small angles, where acos of the product is not.
    apart, along = math.dist(q1, q2), math.dist(q1, -q2)
    return 4.0 * math.atan2(min(apart, along), max(apart, along))
