"""Where a robot has been, to go back there."""

import threading
from collections import deque
from typing import Deque, List

import numpy as np

from mesh_navigation.pose import Pose

SPACING = 0.05  # m, from one pose to the next
LENGTH = 20.0  # m, that are remembered
JUMP = 1.0  # m; a robot that was put elsewhere did not drive there


class Trail:
    """The robot's last poses, `SPACING` apart. From any thread."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._poses: Deque[Pose] = deque(maxlen=int(LENGTH / SPACING))

    def add(self, pose: Pose) -> None:
        """Note where the robot is."""
        with self._lock:
            if self._poses:
                step = float(np.linalg.norm(pose.position - self._poses[-1].position))
                if step < SPACING:
                    return
                if step > JUMP:
                    self._poses.clear()
            self._poses.append(pose)

    def back(self) -> List[Pose]:
        """The poses, the last one first."""
        with self._lock:
            return list(reversed(self._poses))

    def forget_last(self, count: int) -> None:
        """The robot went back: its last poses are not behind it any more."""
        with self._lock:
            for _ in range(min(count, len(self._poses))):
                self._poses.pop()

    def clear(self) -> None:
        """Forget all: the robot was put elsewhere, or there is another map."""
        with self._lock:
            self._poses.clear()
