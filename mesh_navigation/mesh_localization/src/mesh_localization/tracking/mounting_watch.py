"""Whether sensors sit on the robot where it is said: what is always off is no noise."""

from typing import Dict

import numpy as np

_FORGOTTEN = 0.02  # of the means, by each scan
_LEAST = 50  # scans until something is always so
_MOST_HEIGHT = 0.06  # m that the base may be above or below the ground
_MOST_APART = 0.03  # m that a sensor may always pull to its side


class _Mean:
    """That of the last scans: shift, (3,) m by which they moved the pose; height, m of the base
    above the ground."""

    def __init__(self) -> None:
        self.count, self.shift, self.height = 0, np.zeros(3), 0.0

    def add(self, shift: np.ndarray, height: float) -> None:
        self.count += 1
        rate = max(_FORGOTTEN, 1 / self.count)
        self.shift += rate * (shift - self.shift)
        if np.isfinite(height):
            self.height += rate * (height - self.height)


class MountingWatch:
    """Looks at what scans of each sensor do to the pose."""

    def __init__(self) -> None:
        self._means: Dict[str, _Mean] = {}

    def add(self, sensor: str, shift: np.ndarray, height: float) -> None:
        """A scan that was believed.

        Args:
            sensor: its name.
            shift: (3,) m in the frame of the base, by which it moved the pose from where odometry
                and the scans before had it.
            height: m of the base above the ground at the pose, above what it should be; NaN where
                that is not known.
        """
        self._means.setdefault(sensor, _Mean()).add(shift, height)

    @property
    def fault(self) -> str:
        """What is always off, as a sentence; empty: nothing is known to be."""
        for name, mean in self._means.items():
            if mean.count >= _LEAST and abs(mean.height) > _MOST_HEIGHT:
                text = (
                    "by the scans of %s the base is always %.2f m %s the ground on which it "
                    "stands: correct base_height, or where the sensor sits"
                )
                side = "above" if mean.height > 0 else "below"
                return text % (name or "the sensor", abs(mean.height), side)
        if len(self._means) > 1:
            for name, mean in self._means.items():
                if mean.count >= _LEAST and np.linalg.norm(mean.shift) > _MOST_APART:
                    text = (
                        "scans of %s always pull the base by (%.2f, %.2f, %.2f) m: "
                        "correct where its sensor sits, or where the others do"
                    )
                    return text % (name or "the sensor", *mean.shift)
        return ""
