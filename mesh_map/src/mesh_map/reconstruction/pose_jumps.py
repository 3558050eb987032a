"""Poses that jump from one scan to the next, as bad odometry and loops that close make them."""

from collections import deque
from typing import Deque, Optional

import numpy as np

from mesh_map.scans.left_out import LeftOutCounts
from mesh_map.scans.scan import Scan

_LEAST = 2.0  # m
_FASTEST = 50.0  # m/s: no robot
_RECENT, _FEW = 9, 3
_TIMES = 1.8  # the longest of the last steps


class PoseJumps:
    """Counts steps of 2 m or more that are faster than 50 m/s, or nearly twice as long as the
    longest of the last nine; scans behind such a step are used as all others.

    Args:
        left_out: takes what is found.
    """

    def __init__(self, left_out: LeftOutCounts) -> None:
        self._left_out = left_out
        self._before: Optional[Scan] = None
        self._lengths: Deque[float] = deque(maxlen=_RECENT)

    def add(self, scan: Scan) -> None:
        """The next scan; its points are not kept."""
        before, self._before = self._before, Scan(
            np.zeros((0, 3), np.float32), scan.pose, time=scan.time, name=scan.name
        )
        if before is None:
            return
        length = float(np.linalg.norm(scan.pose[:3, 3] - before.pose[:3, 3]))
        fast = False
        if scan.time is not None and before.time is not None and scan.time > before.time:
            fast = length > _FASTEST * (scan.time - before.time)
        unusual = len(self._lengths) >= _FEW and length > _TIMES * max(self._lengths)
        if length >= _LEAST and (fast or unusual):
            text = "%.3g m from the pose of %s; are the poses right, or of several drives?"
            self._left_out.add("jump", scan.name, reason=text % (length, before.name))
        else:
            self._lengths.append(length)
