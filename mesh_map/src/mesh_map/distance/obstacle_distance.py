"""Distances along the surface from obstacles, and the mesh that all fronts share."""

from typing import Any, Optional

import numpy as np

from mesh_map import _kernels
from mesh_map.base.cancel import CancelFlag, kernel_flag
from mesh_map.base.errors import Canceled
from mesh_map.base.query_arguments import one_each
from mesh_map.geometry.mesh_geometry import MadeOnce, MeshGeometry


class SurfaceFront(MadeOnce):
    """One mesh, any triangle soup, prepared for fronts; for many, from any number of threads.

    Fronts from a point are mesh_map.distance.wave_front.WaveFrontSolver's.
    """

    def __init__(self, geometry: MeshGeometry) -> None:
        """Prepares the mesh, on all cores."""
        topology = geometry.topology
        self._vertex_count = topology.vertex_count
        self._mesh = _kernels._FastMarchingMesh(
            geometry.vertices,
            geometry.faces,
            topology.vertex_face_offsets,
            topology.vertex_faces,
            0,
        )


class ObstacleDistance:
    """Distances along the surface from obstacles, and directions away from them.

    Obstacles are lethal vertices, edges between two of them, and faces between three. Distances are
    those of the shortest ways over the faces, whatever these are like, up to the rounding of 32-bit
    floats: windows of straight ways are propagated (Mitchell, Mount and Papadimitriou, The discrete
    geodesic problem, 1987), as far as no other way is shorter (Xin and Wang, Improving Chen and
    Han's algorithm on the discrete geodesic problem, 2009).

    One call at a time.
    """

    def __init__(self, *, front: SurfaceFront, max_distance: float) -> None:
        """
        Args:
            front: of the mesh.
            max_distance: meters, above 0; distances beyond are infinite.
        Raises:
            ValueError: a distance that is not above 0.
        """
        self._vertex_count = front._vertex_count
        self.kernel = _kernels._ObstacleDistance(front._mesh, float(max_distance))

    def compute(self, lethal: Any, cancel: Optional[CancelFlag] = None) -> None:
        """From everything.

        Args:
            lethal: (V,) bool.
            cancel: ends this when it is set.
        Raises:
            ValueError: a wrong number of vertices.
            Canceled: `cancel` was set.
        """
        if not self.kernel._compute(self._flags(lethal), kernel_flag(cancel)):
            raise Canceled("the distances from obstacles were cancelled")

    def update(self, lethal: Any) -> np.ndarray:
        """The same as compute(), bit for bit, by looking only at what is around changes.

        Where that is more than a few percent of the mesh, everything is computed.

        Returns:
            (K,) uint32, ascending: the vertices where a distance or a direction may have changed.
        Raises:
            ValueError: a wrong number of vertices.
        """
        return self.kernel._update(self._flags(lethal))

    def distances(self) -> np.ndarray:
        """(V,) float32 meters: 0 for what is lethal, +inf beyond the maximum. A copy."""
        return self.kernel._distances()

    def _flags(self, lethal: Any) -> np.ndarray:
        lethal = np.ascontiguousarray(lethal, np.bool_)
        return one_each(lethal, "lethal", self._vertex_count, "vertex").view(np.uint8)
