"""A box around the robot in which nothing may be while it drives."""

import math
from typing import Sequence

import numpy as np

_BOX = "zone_box has to be [x_min, x_max, y_min, y_max, z_min, z_max] (m, in the robot's frame)"


class CollisionZone:
    """What a sensor sees in the box. A sensor that does not see, or not now, closes the way."""

    def __init__(self, box: Sequence[float], min_points: int, timeout: float) -> None:
        """
        Args:
            box: (x_min, x_max, y_min, y_max, z_min, z_max), m, in the robot's frame; anything else
                is an obstruction for ever.
            min_points: so many points in it are one.
            timeout: how old a cloud may be (s).
        """
        self._fault = _fault_of(box)
        self._low, self._high = np.array(box[0::2]), np.array(box[1::2])
        self._min_points, self._timeout = min_points, timeout
        self._stamp, self._count, self._unusable = -math.inf, 0, "none has come yet"

    def see(self, points: np.ndarray, stamp: float) -> None:
        """A cloud.

        Args:
            points: (N, 3), in the robot's frame; those that are not finite are nowhere.
            stamp: when that was (s).
        """
        if self._fault:
            return
        inside = np.all((points >= self._low) & (points <= self._high), axis=1)
        self._count = int(np.count_nonzero(inside))
        self._stamp, self._unusable = stamp, ""

    def miss(self, why: str) -> None:
        """A cloud came that cannot be used."""
        self._unusable = why

    def obstruction(self, now: float) -> str:
        """Why the robot has to stand at that time (s); empty: it need not."""
        if self._fault:
            return self._fault
        if self._unusable:
            return f"the collision zone has no cloud: {self._unusable}"
        age = abs(now - self._stamp)  # One ahead of time says as little.
        if age > self._timeout:
            return (
                f"the last cloud of the collision zone is {age:.2f} s old or ahead of time, "
                f"{self._timeout:.2f} s are allowed (zone_timeout)"
            )
        if self._count >= self._min_points:
            return f"{self._count} points are in the collision zone"
        return ""


def _fault_of(box: Sequence[float]) -> str:
    numbers = [type(value) in (int, float) and math.isfinite(value) for value in box]
    if len(box) != 6 or not all(numbers):
        return f"{_BOX}, but is {list(box)}"
    if any(low >= high for low, high in zip(box[0::2], box[1::2])):
        return f"{_BOX}, each minimum below its maximum, but is {list(box)}"
    return ""
