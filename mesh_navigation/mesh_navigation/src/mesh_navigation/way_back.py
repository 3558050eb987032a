"""The way a robot came, to go back on it."""

from typing import List, Optional

import numpy as np

from mesh_navigation.pose import Pose

REACH = 0.5  # m; a trail that is farther away is not where the robot came from
_WINDOW = 1.0  # m, how far the way back is searched for where the robot is now


class WayBack:
    """The last poses of a robot, from where it is to the oldest; straight back from there.

    Where it is, is told by `gone`, which only ever grows.
    """

    def __init__(self, pose: Pose, trail: List[Pose]) -> None:
        """
        Args:
            pose: of the robot.
            trail: its last poses, the newest first. Those that are newer than the one at which it
                is (or were left in another direction) are not behind it.
        """
        self._newer = 0
        points = []
        begin = _nearest(pose, trail)
        if begin is not None:
            if (trail[begin].position - pose.position) @ pose.heading > 0.0:
                begin += 1
            self._newer = begin
            points = [pose.position] + [known.position for known in trail[begin:]]
        self._points = np.array(points).reshape(-1, 3)
        steps = np.linalg.norm(np.diff(self._points, axis=0), axis=1)
        self._lengths = np.concatenate([[0.0], np.cumsum(steps)])
        self._segment = 0
        self._straight: Optional[np.ndarray] = None
        self._gone = 0.0
        self._gone_straight = 0.0

    @property
    def passed(self) -> int:
        """How many of the newest poses of the trail are not behind the robot any more."""
        return self._newer + self._segment

    def gone(self, position: np.ndarray) -> float:
        """How far the robot has gone back (m): along the way, then straight from its end."""
        if self._straight is None and self._segment < len(self._points) - 1:
            self._gone = max(self._gone, self._project(position))
        elif self._straight is None:
            self._straight = np.array(position)
        if self._straight is not None:
            self._gone_straight = float(np.linalg.norm(position - self._straight))
        return self._gone + self._gone_straight

    def target(self, ahead: float) -> Optional[np.ndarray]:
        """(3,) m: where to go from where the robot was last, so far on; None: straight back."""
        if self._segment >= len(self._points) - 1:
            return None
        wanted = self._lengths[self._segment] + ahead
        index = int(np.searchsorted(self._lengths, wanted))
        return self._points[min(index, len(self._points) - 1)]

    def _project(self, position: np.ndarray) -> float:
        """m along the points, of the one nearest to a position; notes the segment it is on."""
        begin = self._segment
        end = int(np.searchsorted(self._lengths, self._lengths[begin] + _WINDOW)) + 1
        points = self._points[begin : end + 1]
        sides = np.diff(points, axis=0)
        squared = np.maximum(np.einsum("ij,ij->i", sides, sides), 1e-18)
        shares = np.einsum("ij,ij->i", position - points[:-1], sides) / squared
        clipped = np.clip(shares, 0.0, 1.0)
        away = np.linalg.norm(points[:-1] + clipped[:, None] * sides - position, axis=1)
        best = int(np.argmin(away))
        self._segment = begin + best
        if self._segment == len(self._points) - 2 and shares[best] >= 1.0:
            self._segment += 1  # all of it is done
        return float(self._lengths[begin + best] + clipped[best] * np.sqrt(squared[best]))


def _nearest(pose: Pose, trail: List[Pose]) -> Optional[int]:
    """The pose of the trail at which the robot is, looking as then; None if it is at none."""
    best, distance = None, REACH
    heading = pose.heading
    for index, known in enumerate(trail):
        away = float(np.linalg.norm(known.position - pose.position))
        if away < distance and float(known.heading @ heading) > 0.0:
            best, distance = index, away
    return best
