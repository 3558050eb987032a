"""Odometry that drifts away from the truth, as that of wheels and a gyroscope."""

import math
from dataclasses import dataclass

import numpy as np

from mesh_map.base.errors import MeshMapError
from mesh_map.scans.trajectory import Trajectory, quaternion_product


@dataclass(frozen=True)
class OdometryDrift:
    """What odometry counts wrong. A level keeps roll and pitch; the heading drifts about the map's
    z axis.

    Attributes:
        slip: share of the motion that wheels count too much (below 0: too little).
        yaw: rad to the left after 1 m.
        height: m upwards after 1 m.
        noise: m after 1 m, and rad after 1 m (standard deviation; it grows with the square root of
            the distance).
    """

    slip: float = 0.0
    yaw: float = 0.0
    height: float = 0.0
    noise: float = 0.0

    def __post_init__(self) -> None:
        """
        Raises:
            MeshMapError: numbers that are not finite, or noise below 0.
        """
        numbers = self.slip, self.yaw, self.height, self.noise
        if not all(map(math.isfinite, numbers)) or self.noise < 0:
            text = "odometry that drifts by %s (slip, yaw, height, noise)" % (numbers,)
            raise MeshMapError(text, "finite numbers are needed, and noise >= 0")

    def of(self, truth: Trajectory, seed: int = 0) -> Trajectory:
        """What odometry tells of a trajectory: its first pose is the true one.

        Args:
            truth: of the robot, in the map's frame.
            seed: of the noise.
        """
        random = np.random.default_rng([seed, 2])
        steps = np.diff(truth.positions, axis=0)
        lengths = np.linalg.norm(steps, axis=1)
        scatter = self.noise * np.sqrt(lengths) * random.standard_normal((2, len(lengths)))
        # The heading that is wrong on a step is that of its middle.
        turned = self.yaw * lengths + scatter[1]
        heading = np.concatenate([[0.0], np.cumsum(turned)])
        middle = heading[:-1] + turned / 2
        factor = 1.0 + self.slip + scatter[0] / np.where(lengths > 0, lengths, 1.0)
        counted = np.stack(
            [
                factor * (np.cos(middle) * steps[:, 0] - np.sin(middle) * steps[:, 1]),
                factor * (np.sin(middle) * steps[:, 0] + np.cos(middle) * steps[:, 1]),
                factor * steps[:, 2] + self.height * lengths,
            ],
            axis=1,
        )
        positions = truth.positions[:1] + np.concatenate(
            [np.zeros((1, 3)), np.cumsum(counted, axis=0)]
        )
        zeros = np.zeros(len(heading))
        turn = np.stack([zeros, zeros, np.sin(heading / 2), np.cos(heading / 2)], axis=1)
        if not (turned.any() or (counted != steps).any()):
            return truth
        return Trajectory(truth.times, positions, quaternion_product(turn, truth.orientations))
