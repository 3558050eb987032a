"""What a robot's footprint would touch along the poses of a command."""

from typing import NamedTuple, Optional, Sequence, Tuple

import numpy as np

from mesh_navigation.body.near_obstacles import NO_OBSTACLES, NearObstacles, rises
from mesh_navigation.body.robot_shape import MAX_DISTANCE, RobotShape
from mesh_navigation.controllers.vector3 import Vector3, cross

Stand = Tuple[np.ndarray, Vector3, Vector3]  # position (m), normal, heading of length 1


class Sweep(NamedTuple):
    """At one moment."""

    shape: RobotShape = RobotShape()
    obstacles: NearObstacles = NO_OBSTACLES

    @property
    def is_empty(self) -> bool:
        """Whether nothing is near that could be touched by more than what is around its middle."""
        return self.shape.is_round or not len(self.obstacles.points)

    def first_touch(self, stands: Sequence[Stand]) -> Optional[int]:
        """The first of poses at which an obstacle gets under the footprint, or farther under it
        than at those before; None: at none.

        What is farther above or below than `MAX_DISTANCE` is on another storey.

        Args:
            stands: on the surface, the first one where the robot is.
        """
        if self.is_empty:
            return None
        return rises(np.array([self._depth(*stand) for stand in stands]))

    def _depth(self, position: np.ndarray, normal: Vector3, heading: Vector3) -> float:
        axes = np.array([heading, cross(normal, heading), normal])
        local = (self.obstacles.points - position) @ axes.T
        under = local[np.abs(local[:, 2]) <= MAX_DISTANCE, :2]
        return float(self.shape.depths(under).max(initial=-np.inf))
