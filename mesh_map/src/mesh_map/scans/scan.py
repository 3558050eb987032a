"""One scan of a sensor, with its pose in the map."""

from dataclasses import dataclass, field
from typing import Optional

import numpy as np


@dataclass(frozen=True)
class Scan:
    """Points that a sensor measured, and from where.

    Attributes:
        points: (N, 3) float32 m in the sensor's frame at `time`; the motion of the robot while it
            measured is undone. All finite.
        pose: (4, 4) float64 from the sensor's frame into the map's.
        origins: (N, 3) float32 m where the sensor was when it measured each point, in the frame of
            `points`; None: at its origin.
        colors: (N, 3) uint8 red, green, blue; None: no colors.
        intensities: (N,) float32 in the sensor's own unit; None: none.
        time: s since the epoch; None where the source does not say.
        name: for messages: file and number, or topic and number.
    """

    points: np.ndarray
    pose: np.ndarray = field(default_factory=lambda: np.eye(4))
    origins: Optional[np.ndarray] = None
    colors: Optional[np.ndarray] = None
    intensities: Optional[np.ndarray] = None
    time: Optional[float] = None
    name: str = "scan"

    def in_map(self) -> np.ndarray:
        """(N, 3) float32 points in the map's frame."""
        return self._placed(self.points)

    def origins_in_map(self) -> np.ndarray:
        """Where the sensor was in the map's frame: (3,) float32 for all, or (N, 3)."""
        if self.origins is None:
            return np.float32(self.pose[:3, 3])
        return self._placed(self.origins)

    def _placed(self, points: np.ndarray) -> np.ndarray:
        """(N, 3) float32 in the map's frame; by coordinates, which is four times as fast as by
        points."""
        x, y, z = np.ascontiguousarray(points.T, np.float64)
        placed = np.zeros((len(points), 3), np.float32)
        for k, (of_x, of_y, of_z, shift) in enumerate(self.pose[:3]):
            placed[:, k] = of_x * x + of_y * y + of_z * z + shift
        return placed
