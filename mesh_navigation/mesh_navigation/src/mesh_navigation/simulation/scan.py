"""A laser scanner that turns on a robot: what it measures of a mesh and of obstacles."""

import math
from typing import Any, Sequence

import numpy as np

from mesh_map.spatial.hits import NO_FACE
from mesh_map.spatial.spatial_index import SpatialIndex

from mesh_navigation.base.pose import Pose, rotate
from mesh_navigation.simulation.obstacles import Obstacle, ray_distances


class SimulatedScan:
    """Rings of rays around the z axis of the sensor; the same seed measures the same.

    Attributes:
        directions: (rings * columns, 3) float64 of length 1 in the sensor's frame, ring by ring
            from the lowest; each ring begins ahead (x) and turns left.
    """

    def __init__(
        self,
        surface: Any,
        *,
        rings: int = 16,
        columns: int = 360,
        lowest: float = -math.radians(35),
        highest: float = math.radians(15),
        min_range: float = 0.3,
        max_range: float = 30.0,
        noise: float = 0.0,
        seed: int = 0,
    ) -> None:
        """
        Args:
            surface: a `MeshMap`, `MeshGeometry` or `SpatialIndex`.
            rings, columns: number of rays.
            lowest, highest: elevations of the first and the last ring (rad); of a single one: the
                middle of both.
            min_range, max_range: m; what is nearer or farther is not measured.
            noise: standard deviation of ranges (m).
            seed: of the noise.

        Raises:
            ValueError: numbers that make no scan.
        """
        if rings < 1 or columns < 1:
            raise ValueError(f"a scan of {rings} rings and {columns} columns has no rays")
        if not -math.pi / 2 <= lowest <= highest <= math.pi / 2:
            raise ValueError(f"elevations from {lowest} to {highest} rad are not ascending")
        if not 0 <= min_range < max_range:
            raise ValueError(f"ranges from {min_range} to {max_range} m are not ascending")
        if not 0 <= noise < math.inf:
            raise ValueError(f"noise of ranges is {noise} m, but has to be >= 0 and finite")
        self._index: SpatialIndex = getattr(surface, "spatial_index", surface)
        self._ranges = min_range, max_range
        self._noise, self._random = noise, np.random.default_rng(seed)
        middle = [(lowest + highest) / 2]
        heights = np.array(middle) if rings == 1 else np.linspace(lowest, highest, rings)
        elevation = np.repeat(heights, columns)
        around = np.tile(np.arange(columns) * (2 * math.pi / columns), rings)
        flat = np.cos(elevation)
        self.directions = np.stack(
            [flat * np.cos(around), flat * np.sin(around), np.sin(elevation)], axis=1
        )

    def cloud(self, pose: Pose, obstacles: Sequence[Obstacle] = ()) -> np.ndarray:
        """(N,3) float32 points in the sensor's frame, of the rays that meet something.

        Args:
            pose: of the sensor in the map's frame.
            obstacles: that hide the mesh, and each other.
        """
        ranges = self.ranges(pose, obstacles)
        if self._noise:
            ranges = ranges + self._noise * self._random.standard_normal(len(ranges))
        seen = (ranges >= self._ranges[0]) & (ranges <= self._ranges[1])
        return np.float32(ranges[seen, None] * self.directions[seen])

    def ranges(self, pose: Pose, obstacles: Sequence[Obstacle] = ()) -> np.ndarray:
        """(rings * columns,) exact m along each ray; inf where it meets nothing."""
        axes = np.stack([rotate(pose.orientation, axis) for axis in np.eye(3)])
        directions = self.directions @ axes
        # Some thousand rays are not worth the way to a device, and are the same everywhere so.
        hits = self._index.cast_batch(
            origins=pose.position, directions=directions, back_end="native"
        )
        ranges = np.where(hits.faces == NO_FACE, np.inf, hits.distances)
        return np.minimum(ranges, ray_distances(obstacles, pose.position, directions))
