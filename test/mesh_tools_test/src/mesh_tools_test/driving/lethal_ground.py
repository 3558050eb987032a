"""How far a pose is from what is lethal, along the surface."""

from typing import Any, NamedTuple, Optional

import numpy as np
from mesh_map.distance.obstacle_distance import ObstacleDistance, SurfaceFront
from mesh_map.geometry.mesh_geometry import MeshGeometry
from mesh_map.map.mesh_map import MeshMap
from mesh_map.spatial.spatial_index import SpatialIndex

FARTHEST = 0.5  # m; what is farther away does not matter, and is measured straight


class Nearest(NamedTuple):
    """Of some points the one nearest to what is lethal."""

    distance: float
    """m; inf where nothing is lethal."""
    number: int
    """Of the point; -1 where nothing is lethal."""


class LethalGround:
    """Lethal and unknown vertices of a map, edges between two of them, and faces between three.

    Two distances: straight through space, and along the surface, which is never shorter. Behind a
    wall, or on another storey, they differ much.
    """

    def __init__(self, mesh_map: MeshMap, costs: np.ndarray) -> None:
        """
        Args:
            mesh_map: the map.
            costs: (V,) of it.
        """
        self._geometry = mesh_map.geometry
        self._lethal = ~np.isfinite(costs)
        self._index: Any = None
        if self._lethal.any():
            self._index = SpatialIndex(mesh_map.vertices, self._pieces(), device="off")

    def _pieces(self) -> np.ndarray:
        """(K, 3) as faces; those of vertices and edges have no area."""
        lethal, edges = self._lethal, self._geometry.topology.edges.astype(np.int64)
        vertices = np.flatnonzero(lethal)
        edges = edges[lethal[edges].all(axis=1)]
        faces = self._geometry.faces.astype(np.int64)
        return np.concatenate(
            [
                np.repeat(vertices[:, None], 3, axis=1),
                edges[:, [0, 1, 1]],
                faces[lethal[faces].all(axis=1)],
            ]
        ).astype(np.uint32)

    def straight(self, points: np.ndarray) -> np.ndarray:
        """(N,) m, of points (N, 3); inf where nothing is lethal."""
        if self._index is None:
            return np.full(len(points), np.inf)
        found = self._index.closest_batch(points=np.ascontiguousarray(points, np.float64))
        return np.asarray(found.distances, np.float64)

    def nearest(self, points: np.ndarray, faces: Optional[np.ndarray] = None) -> Nearest:
        """Which of points (N, 3) on the surface is nearest to it along the surface, exactly, as far
        as that is less than `FARTHEST`; else straight. They are on faces (N,), else the nearest."""
        straight = self.straight(points)
        best = Nearest(np.inf, -1)
        for number in np.argsort(straight, kind="stable"):
            if not straight[number] < best.distance:
                break  # as none of those to come is nearer
            distance = self.along_surface(
                points[number], None if faces is None else int(faces[number])
            )
            distance = max(distance if distance < FARTHEST else FARTHEST, straight[number])
            if distance < best.distance:
                best = Nearest(float(distance), int(number))
        return best

    def along_surface(self, point: np.ndarray, face: Optional[int] = None) -> float:
        """m from a point (3,) of a face, else of the nearest one: 0 on a lethal piece, inf from
        `FARTHEST` on.

        The point becomes a vertex of the faces around it, where the distances are exact.
        """
        geometry = self._geometry
        index = geometry.spatial_index
        near = index.in_sphere(center=point, radius=FARTHEST).astype(np.int64)
        if face is None:
            face = int(index.closest(point=point).face)
        corners = geometry.faces[face].astype(np.int64)
        if self._lethal[corners].all():
            return 0.0
        used = np.union1d(geometry.faces[near].ravel(), corners).astype(np.int64)
        others = np.searchsorted(used, geometry.faces[near[near != face]].astype(np.int64))
        a, b, c = np.searchsorted(used, corners)
        middle = len(used)
        faces = np.concatenate([others, [[a, b, middle], [b, c, middle], [c, a, middle]]])
        vertices = np.concatenate([geometry.vertices[used], [point]]).astype(np.float32)
        front = SurfaceFront.of(MeshGeometry(vertices, faces.astype(np.uint32)))
        distance = ObstacleDistance(front=front, max_distance=FARTHEST)
        distance.compute(np.append(self._lethal[used], False))
        return float(distance.distances()[middle])
