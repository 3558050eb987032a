"""How sure a pose still is after the robot has moved by its odometry."""

import math
from dataclasses import dataclass
from typing import Tuple

import numpy as np
from mesh_map.registration.rigid import adjoint, inverse

_LEVEL = 1e-9  # m, and 1 - cosine of a tilt: what is less is rounding
_SLOPE, _TILT = 0.4, 0.5  # m and rad after 1 m, of ground that planar odometry does not know
_LEVER = 0.3  # m of a base above the wheels, which a tilt moves aside


@dataclass(frozen=True)
class OdometryModel:
    """What odometry is off, as a share of the motion.

    The four alphas mean what those of amcl do (S. Thrun, W. Burgard and D. Fox: Probabilistic
    Robotics, 2005, chapter 5.4): shares of squares. Errors of one drive are alike, so that
    deviations grow with the distance, not with its root, until scans have told all of the pose.

    Attributes:
        rotation_by_rotation: odom_alpha1, rad^2 of each rad^2 turned.
        rotation_by_translation: odom_alpha2, rad^2 of each m^2 driven.
        translation_by_translation: odom_alpha3, m^2 of each m^2 driven.
        translation_by_rotation: odom_alpha4, m^2 of each rad^2 turned.
        walk: m^2 and rad^2 for each m driven and rad turned, of errors that differ from step to
            step, as those of wheels on gravel do.
    """

    rotation_by_rotation: float = 0.0025
    rotation_by_translation: float = 0.0004
    translation_by_translation: float = 0.0025
    translation_by_rotation: float = 0.0004
    walk: Tuple[float, float] = (0.001, 0.0006)

    def variances(self, driven: float, turned: float) -> np.ndarray:
        """(6,) m^2 and rad^2 by which a pose is less sure after so many m and rad."""
        translation = self.translation_by_translation * driven**2
        translation += self.translation_by_rotation * turned**2
        rotation = self.rotation_by_rotation * turned**2
        rotation += self.rotation_by_translation * driven**2
        way = driven + turned
        return np.repeat([translation + self.walk[0] * way, rotation + self.walk[1] * way], 3)


class OdometryMotion:
    """The motion since a moment, by odometry.

    Attributes:
        step: (4, 4) of the robot now in the frame of the robot then.
        driven, turned: m and rad on the way, back and forth, with those before.
    """

    def __init__(self, odometry: np.ndarray, driven: float = 0.0, turned: float = 0.0) -> None:
        """
        Args:
            odometry: (4, 4), the robot in the frame of the odometry then.
            driven, turned: m and rad before that, whose errors are still in the pose.
        """
        self.first = self.newest = odometry
        self.driven, self.turned = driven, turned
        self._before = driven, turned
        self._is_planar = bool(odometry[2, 2] >= 1 - _LEVEL)

    @property
    def step(self) -> np.ndarray:
        return inverse(self.first) @ self.newest

    def add(self, odometry: np.ndarray) -> None:
        """Where the robot is now, (4, 4)."""
        step = inverse(self.newest) @ odometry
        rose = abs(odometry[2, 3] - self.newest[2, 3]) > _LEVEL
        self._is_planar &= not rose and bool(odometry[2, 2] >= 1 - _LEVEL)
        self.newest = odometry
        self.driven += float(np.linalg.norm(step[:3, 3]))
        self.turned += turn_of(step)

    @property
    def is_planar(self) -> bool:
        """Whether the odometry knows no slopes: its frame saw neither height nor tilt change."""
        return self._is_planar

    def grown(self, covariance: np.ndarray, model: OdometryModel) -> np.ndarray:
        """(6, 6) of the pose now, of (6, 6) then; each in the frame of the robot."""
        moved = adjoint(inverse(self.step))
        new = model.variances(self.driven, self.turned) - model.variances(*self._before)
        if self._is_planar:
            way = self.driven - self._before[0]
            new[2] += (_SLOPE * way) ** 2
            new[3:5] += (_TILT * way) ** 2
            new[:2] += (_LEVER * _TILT * way) ** 2
        return moved @ covariance @ moved.T + np.diag(new)


def turn_of(pose: np.ndarray) -> float:
    """rad by which a pose (4, 4) is turned."""
    sine = pose[:3, :3] - pose[:3, :3].T
    length = math.sqrt(sine[2, 1] ** 2 + sine[0, 2] ** 2 + sine[1, 0] ** 2) / 2
    return math.atan2(length, (float(np.trace(pose[:3, :3])) - 1) / 2)
