"""Whether a robot moves at all when it is told to."""

from typing import Optional

from mesh_navigation.controllers.standing import Standing
from mesh_navigation.controllers.vector3 import dot, minus
from mesh_navigation.robot import Velocity

MOVED = 0.05  # m that count as moving
TURNED = 0.1  # rad that count as moving


class StuckWatch:
    """Adds up what was commanded since the robot has last moved."""

    def __init__(self) -> None:
        self._since: Optional[Standing] = None
        self._forget()

    def _forget(self) -> None:
        self.seconds, self.length, self.angle = 0.0, 0.0, 0.0

    def look(self, standing: Standing) -> None:
        """Note where the robot is; once per cycle."""
        if self._since is None or _has_moved(self._since, standing):
            self._since = standing
            self._forget()

    def commanded(self, velocity: Velocity, period: float) -> None:
        """Note what it was told to do for one period (s)."""
        if velocity.x or velocity.yaw:
            self.seconds += period
            self.length += abs(velocity.x) * period
            self.angle += abs(velocity.yaw) * period

    def is_stuck(self, timeout: float) -> bool:
        """Whether it did not move, told to for this long (s; 0: never), far enough to see it."""
        enough = self.length > 2 * MOVED or self.angle > 2 * TURNED
        return 0.0 < timeout <= self.seconds and enough


def _has_moved(before: Standing, now: Standing) -> bool:
    step = minus(now.point, before.point)
    turned = dot(before.heading, now.heading) < 1.0 - TURNED * TURNED / 2
    return dot(step, step) > MOVED * MOVED or turned
