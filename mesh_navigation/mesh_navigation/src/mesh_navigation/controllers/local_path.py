"""The way ahead of the robot."""

from typing import NamedTuple, Optional

import numpy as np


class LocalPath(NamedTuple):
    """A way over the surface, straight from point to point, from the robot or from near it."""

    points: np.ndarray
    """(N,3) m, N at least 1."""
    faces: np.ndarray
    """(N - 1,) the face in which point i to i + 1 lies; NO_FACE where there is none."""
    travelled: np.ndarray
    """(N,) m from the first point."""
    arrives: bool
    """Whether it ends at the goal, and not where it was cut off."""

    @classmethod
    def through(cls, points: np.ndarray, faces: np.ndarray, arrives: bool) -> "LocalPath":
        """From points and faces."""
        steps = points[1:] - points[:-1]
        travelled = np.zeros(len(points))
        np.sqrt(np.einsum("ij,ij->i", steps, steps)).cumsum(out=travelled[1:])
        return cls(points, faces, travelled, arrives)

    @property
    def length(self) -> float:
        """m."""
        return float(self.travelled[-1])

    def at(self, length: float) -> np.ndarray:
        """(3,) the point after this length (m), at most the last one."""
        after = self._after(length)
        if after == 0:
            return self.points[0]
        before = self.travelled[after - 1]
        step = self.travelled[after] - before
        share = min(max((length - before) / step, 0.0), 1.0) if step > 0.0 else 1.0
        return self.points[after - 1] + share * (self.points[after] - self.points[after - 1])

    def segment_at(self, length: float) -> Optional[int]:
        """The index of the segment that leads there; None where the way is a point."""
        return max(self._after(length) - 1, 0) if len(self.faces) else None

    def _after(self, length: float) -> int:
        return min(int(self.travelled.searchsorted(length)), len(self.points) - 1)
