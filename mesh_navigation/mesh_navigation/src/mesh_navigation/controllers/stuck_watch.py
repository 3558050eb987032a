"""Whether a robot does what it is told to."""

import math
from typing import Optional

from mesh_navigation.base.robot import Velocity
from mesh_navigation.controllers.surface_pose import SurfacePose
from mesh_navigation.controllers.vector3 import dot, minus

MOVED = 0.05  # m that count as moving
TURNED = 0.1  # rad that count as moving
ROUND_AND_ROUND = 4 * math.pi  # rad on one spot; no goal needs more than half a turn


class StuckWatch:
    """Adds up what was commanded since the robot has last moved."""

    def __init__(self) -> None:
        self._since: Optional[SurfacePose] = None
        self._spot: Optional[SurfacePose] = None
        self.turned = 0.0
        self._forget()

    def _forget(self) -> None:
        self.seconds, self.length, self.angle = 0.0, 0.0, 0.0

    def take_new_goal(self) -> None:
        """Turns on the spot for other goals do not count."""
        self.turned = 0.0

    def look(self, surface_pose: SurfacePose) -> None:
        """Note where the robot is; once per cycle."""
        if self._since is None or _has_moved(self._since, surface_pose):
            self._since = surface_pose
            self._forget()
        if self._spot is None or math.dist(self._spot.position, surface_pose.position) > 2 * MOVED:
            self._spot = surface_pose
            self.turned = 0.0

    def commanded(self, velocity: Velocity, period: float) -> None:
        """Note what it was told to do for one period (s)."""
        if velocity.x or velocity.yaw:
            self.seconds += period
            self.length += abs(velocity.x) * period
            self.angle += velocity.yaw * period  # to both sides it has turned, but stays
            self.turned += abs(velocity.yaw) * period

    def is_stuck(self, timeout: float) -> bool:
        """Whether it did not move, told to for this long (s), far enough to see it; or turned
        round and round on one spot. Never with a timeout of 0."""
        enough = self.length > 2 * MOVED or abs(self.angle) > 2 * TURNED
        stands = timeout <= self.seconds and enough
        return timeout > 0.0 and (stands or self.turned > ROUND_AND_ROUND)

    def text(self) -> str:
        """What was seen, as the end of a sentence."""
        if self.turned > ROUND_AND_ROUND:
            return f"turns without getting on: {self.turned:.1f} rad within {2 * MOVED:.2f} m"
        return (
            f"does not move: in {self.seconds:.1f} s it was told to drive {self.length:.2f} m and "
            f"to turn {abs(self.angle):.2f} rad"
        )


def _has_moved(before: SurfacePose, now: SurfacePose) -> bool:
    step = minus(now.point, before.point)
    turned = dot(before.heading, now.heading) < 1.0 - TURNED * TURNED / 2
    return dot(step, step) > MOVED * MOVED or turned
