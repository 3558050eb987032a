"""Statistics of what is around each vertex, in one pass for all that is wanted."""

import threading
from typing import TYPE_CHECKING, Dict, Set

import numpy as np

from mesh_map import _kernels
from mesh_map.base.array_checks import read_only

if TYPE_CHECKING:
    from mesh_map.geometry.mesh_geometry import MeshGeometry

_BITS = {  # radius_statistics.h
    "height_difference": 1,
    "roughness": 2,
    "ridge": 4,
    "height_difference_around": 8,
    "roughness_around": 16,
    "surface_height_difference": 32,
    "surface_height_difference_around": 64,
}

KEPT = 4  # passes of the last radii of a geometry


class RadiusPass:
    """Height difference, roughness and ridge over each vertex and those around it.

    "Around" means: reached over edges through vertices whose Euclidean distance from the vertex is
    below the radius.

    Whoever will ask for something requests it first, so that what is asked for first computes all
    of it. Threads may share one.
    """

    def __init__(self, geometry: "MeshGeometry", radius: float, search: str = "automatic") -> None:
        """For MeshGeometry.radius_pass().

        Args:
            geometry: the mesh; its normals are read only where they are wanted.
            radius: meters, above 0.
            search: "automatic", along "edges" for each vertex, or in the order of a "grid", with
                the same results.
        Raises:
            ValueError: a radius that is not above 0, or another search.
        """
        self._radius = float(radius)
        if not self._radius > 0.0:
            raise ValueError("the radius is %s, but it has to be above 0" % radius)
        if search not in ("automatic", "edges", "grid"):
            raise ValueError("search is %r, but it has to be automatic, edges or grid" % (search,))
        self._geometry = geometry
        self._search = search
        self._wanted: Set[str] = set()
        self._results: Dict[str, np.ndarray] = {}
        self._lock = threading.Lock()

    def request(self, *wanted: str) -> None:
        """Names of methods below that will be called.

        Raises:
            ValueError: another name.
        """
        for name in wanted:
            if name not in _BITS:
                raise ValueError("%r is none of %s" % (name, ", ".join(_BITS)))
        with self._lock:
            self._wanted.update(wanted)

    def height_difference(self) -> np.ndarray:
        """(V,) float32, the largest minus the smallest height (along up) in meters."""
        return self._result("height_difference")

    def roughness(self) -> np.ndarray:
        """(V,) float32, in radians: the mean of the mean edge angles of the vertices.

        The mean edge angle of a vertex is that between its normal and those of its neighbors.
        """
        return self._result("roughness")

    def height_difference_around(self) -> np.ndarray:
        """(V,) float32, height_difference() without the vertex itself; NaN where none is around."""
        return self._result("height_difference_around")

    def surface_height_difference(self) -> np.ndarray:
        """(V,) float32, height_difference() over the surface of large faces, too.

        Of the faces with a side longer than the radius, at the vertex and at those around it: their
        surface as far as it is within the radius. Nowhere less than height_difference().
        """
        return self._result("surface_height_difference")

    def surface_height_difference_around(self) -> np.ndarray:
        """(V,) float32, the same without the vertex itself; NaN where there is nothing else.

        At a large face it counts, as the surface right beside it does.
        """
        return self._result("surface_height_difference_around")

    def roughness_around(self) -> np.ndarray:
        """(V,) float32, roughness() without the vertex itself; 0 where none is around.

        As calcVertexRoughness of lvr2 20.11 does for the released mesh_map.
        """
        return self._result("roughness_around")

    def ridge(self) -> np.ndarray:
        """(V,) float32, in meters: the mean distance of position + normal from that of the vertex.

        The mean is over the other vertices; 0 where there are none.
        """
        return self._result("ridge")

    def _result(self, name: str) -> np.ndarray:
        with self._lock:
            if name not in self._results:
                self._compute((self._wanted | {name}) - set(self._results))
            return self._results[name]

    def _compute(self, wanted: Set[str]) -> None:
        geometry, topology = self._geometry, self._geometry.topology
        nothing = np.zeros((0, 3), np.float32)
        angles = nothing[:, 0].copy()
        if not wanted.isdisjoint(("roughness", "roughness_around")):
            angles = _kernels._mean_edge_angles(
                geometry.vertex_normals,
                topology.edges,
                topology.neighbor_offsets,
                topology.neighbor_edges,
            )
        found = _kernels._radius_statistics(
            geometry.vertices,
            topology.neighbor_offsets,
            topology.neighbors,
            geometry.faces,
            topology.vertex_face_offsets,
            topology.vertex_faces,
            angles,
            geometry.vertex_normals if "ridge" in wanted else nothing,
            geometry.up,
            self._radius,
            sum(_BITS[name] for name in wanted),
            self._search,
        )
        for name, result in zip(_BITS, found):
            if name in wanted:
                self._results[name] = read_only(result)
