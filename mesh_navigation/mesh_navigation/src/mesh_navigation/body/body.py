"""One robot's body on one map, as planners and controllers need it."""

from functools import partial
from typing import Optional

import numpy as np

from mesh_map.geometry.mesh_geometry import MeshGeometry

from mesh_navigation.body.closed_ground import ClosedGround
from mesh_navigation.body.near_ground import NearGround
from mesh_navigation.body.near_obstacles import (
    NO_OBSTACLES,
    NearObstacles,
    obstacle_points,
)
from mesh_navigation.body.robot_shape import RobotShape


class Body:
    """Shared by all plugins of a map; from any thread. One of a point asks nothing of a map.

    Attributes:
        shape: of the robot.
        radius: m, that its middle keeps from what is lethal or unknown.
    """

    def __init__(
        self, geometry: Optional[MeshGeometry] = None, shape: RobotShape = RobotShape()
    ) -> None:
        """
        Args:
            geometry: of the map; None for a point alone.
            shape: of the robot.
        """
        self.shape, self.radius = shape, shape.inscribed_radius
        self._geometry, self._ground = geometry, None
        if geometry is not None:
            self._ground = ClosedGround(geometry, self.radius)
            self._near = NearGround(geometry, self.radius)

    def costs(self, costs: np.ndarray) -> np.ndarray:
        """(V,) costs of the map for the robot's middle, see `ClosedGround.costs`."""
        return costs if self._ground is None else self._ground.costs(costs)

    def distances(self, costs: np.ndarray) -> np.ndarray:
        """(V,) m from what is lethal or unknown, see `ClosedGround.distances`; +inf for a point."""
        if self._ground is None:
            return np.full(len(costs), np.inf, np.float32)
        return self._ground.distances(costs)

    def obstacles(
        self, costs: np.ndarray, place: np.ndarray, reach: float, clearance: float = 0.0
    ) -> NearObstacles:
        """What it must not touch; none for a point that needs no clearance.

        Args:
            costs: (V,) of the map.
            place: (3,) m, of its middle.
            reach: how far its middle may go from there (m).
            clearance: how far beyond the body obstacles still matter (m).
        """
        if self._geometry is None or (self.shape.is_point and not clearance > 0.0):
            return NO_OBSTACLES
        around = reach + self.shape.circumscribed_radius + clearance
        found = NearObstacles(obstacle_points(self._geometry, costs, place, around), self.radius)
        if not self.radius > 0.0:
            return found
        place = np.array(place, np.float64)
        least = partial(self._near.least_distances, costs, place, reach)
        return found._replace(radius=self.radius, least=least)


POINT = Body()
