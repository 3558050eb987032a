"""The geometry of a map: what follows from vertices and faces alone."""

import threading
from functools import cached_property, lru_cache, partial
from typing import Any, Callable, Dict, Optional, Tuple, TypeVar

import numpy as np
from mesh_msgs.checks.mesh_arrays import as_faces, as_vertices
from mesh_msgs.derived_mesh import DerivedMesh
from mesh_msgs.identity import geometry_uuid
from mesh_msgs.split_mesh import SplitMesh
from mesh_msgs.validation import check_geometry

from mesh_map import _kernels
from mesh_map.base.array_checks import read_only
from mesh_map.base.errors import MeshMapError
from mesh_map.base.query_arguments import checked_distance
from mesh_map.geometry.coordinates import check_rounding, checked_origin
from mesh_map.geometry.normals import (
    checked_up,
    corner_angles,
    face_normals,
    unit_normals,
    vertex_normals,
)
from mesh_map.geometry.orientation import Orientation, orient_faces
from mesh_map.geometry.radius_pass import KEPT, RadiusPass
from mesh_map.geometry.topology import Topology, edge_lengths, quantity
from mesh_map.geometry.walk import SurfaceWalker
from mesh_map.spatial.hits import NO_FACE, SurfacePoint
from mesh_map.spatial.spatial_index import SpatialIndex

Made = TypeVar("Made")


class MadeOnce:
    """Base of what is prepared for a geometry once, whatever number of layers and planners ask."""

    @classmethod
    def of(cls: Callable[["MeshGeometry"], Made], geometry: "MeshGeometry") -> Made:
        """That of a geometry."""
        return geometry.made(cls)


class MeshGeometry:
    """A triangle mesh and what follows from it, computed when it is first asked for.

    Any triangle soup will do: nothing is repaired, all oddities are counted. All arrays are
    read-only. Maps of several robots may share one, in several threads.

    Attributes:
        vertices: (V, 3) float32, meters in frame_id.
        origin: (3,) float64, meters; vertices + origin are the coordinates in the reference system
            that they were given in, such as a UTM zone. Zeros where they are the same.
        faces: (F, 3) uint32.
        frame_id: coordinate frame.
        up: (3,) float64 of length 1; heights and steepness are measured along it.
        orientation: which faces were turned; None where that was not asked for.
        derived: how it was made of another mesh, whose labels and layers it has; None for one that
            was not.
        split: the same faces with copies of vertices along the seams of textures, as it is shown,
            derived of this one; None where there are no seams. It has the identity of this one.
        split_derived: where both are refined, that mesh as one derived of the one with seams.
    """

    derived: Optional[DerivedMesh] = None
    split: Optional[SplitMesh] = None
    split_derived: Optional[DerivedMesh] = None

    def __init__(
        self,
        vertices: Any,
        faces: Any,
        vertex_normals: Optional[Any] = None,
        frame_id: str = "map",
        uuid: str = "",
        *,
        origin: Any = (0.0, 0.0, 0.0),
        up_direction: Any = (0.0, 0.0, 1.0),
        orient: bool = False,
        normals: str = "mean",
    ) -> None:
        """Checks the geometry.

        Args:
            vertices: (V, 3) finite numbers.
            faces: (F, 3) vertex indices; at least one face.
            vertex_normals: (V, 3) finite numbers; None to compute them.
            frame_id: coordinate frame.
            uuid: identity that the geometry already has; "" for that of its content.
            origin: (3,) meters, subtracted from the vertices before they are rounded to float32.
            up_direction: (3,) of any length.
            orient: True to turn faces so that neighbors agree, and most of each piece faces up (see
                mesh_map.geometry.orientation); faces are those then, in the same order.
            normals: how normals of vertices are computed: the "mean" of the faces around as in the
                released mesh_map, or weighted by "angle". With that, or orient, vertex_normals are
                not used.
        Raises:
            MeshMapError: what is wrong with it; coordinates that lose more by rounding than a
                millimeter and a millionth of the mesh: they need an origin.
        """
        if vertex_normals is not None and not len(vertex_normals):
            vertex_normals = None
        findings = check_geometry(vertices, faces, vertex_normals)
        if findings:
            more = " (and %d more faults)" % (len(findings) - 1) if len(findings) > 1 else ""
            raise MeshMapError("no usable mesh: %s%s" % (findings[0], more))
        self.origin = read_only(checked_origin(origin))
        self.vertices = read_only(_rounded(vertices, self.origin))
        self.faces = read_only(as_faces(faces))
        self.frame_id = frame_id
        self.up = read_only(checked_up(up_direction))
        if normals not in ("mean", "angle"):
            raise MeshMapError("normals is %r, but it has to be mean or angle" % (normals,))
        self._uuid = uuid
        self._pass = lru_cache(maxsize=KEPT)(partial(RadiusPass, self))
        self._made: Dict[Any, Any] = {}
        self._making = threading.RLock()
        self._given_faces = self.faces
        self._weighted = normals == "angle"
        self.orientation = self._oriented() if orient else None
        if vertex_normals is not None and not orient and not self._weighted:
            self.__dict__["vertex_normals"] = read_only(unit_normals(vertex_normals, self.up))

    def _oriented(self) -> Orientation:
        topology = self.topology
        orientation = orient_faces(self.vertices, self.faces, topology, self.up)
        if orientation.turned.any():
            self.faces = read_only(orientation.applied_to(self.faces))
            del self.__dict__["topology"]  # that of the faces as they were
        return orientation

    def radius_pass(self, radius: float) -> RadiusPass:
        """Statistics of what is around each vertex within a radius (meters, above 0).

        Those of the last few radii are kept, for all maps with this geometry.

        Raises:
            ValueError: a radius that is not above 0.
        """
        with self._making:
            return self._pass(float(radius))

    def made(self, make: Callable[["MeshGeometry"], Made]) -> Made:
        """make(geometry), once, whatever number of maps, layers and planners ask.

        Who asks meanwhile waits.
        """
        if make not in self._made:
            with self._making:
                if make not in self._made:
                    self._made[make] = make(self)
        return self._made[make]

    @cached_property
    def topology(self) -> Topology:
        """What is next to what."""
        return Topology(faces=self.faces, vertex_count=len(self.vertices))

    @cached_property
    def walker(self) -> SurfaceWalker:
        """Walks over the surface."""
        return SurfaceWalker(vertices=self.vertices, faces=self.faces, topology=self.topology)

    @cached_property
    def edge_lengths(self) -> np.ndarray:
        """(E,) float32 meters, of the edges of the topology."""
        return read_only(edge_lengths(self.vertices, self.topology.edges))

    @cached_property
    def content_uuid(self) -> str:
        """The version 5 UUID of vertices and faces: the same wherever the geometry is the same.

        It is that of the faces as they were given, before any was turned.
        """
        return geometry_uuid(self.vertices, self._given_faces)

    @property
    def uuid(self) -> str:
        """Identity: the one that was given, or the version 5 UUID of vertices and faces."""
        return self._uuid or self.content_uuid

    @cached_property
    def _face_normals(self) -> Tuple[np.ndarray, np.ndarray]:
        return face_normals(self.vertices, self.faces, self.up)

    @property
    def face_normals(self) -> np.ndarray:
        """(F, 3) float32 of length 1; that of up for faces without area."""
        return read_only(self._face_normals[0])

    @property
    def faces_without_area(self) -> np.ndarray:
        """(F,) bool."""
        return read_only(self._face_normals[1])

    @cached_property
    def vertex_normals(self) -> np.ndarray:
        """(V, 3) float32 of length 1: those that were given, or those of the faces around."""
        weights = corner_angles(self.vertices, self.faces) if self._weighted else None
        return read_only(
            vertex_normals(self.topology, *self._face_normals, self.faces, weights, self.up)
        )

    def report(self) -> str:
        """One line for people: what the mesh consists of, and its oddities."""
        derived = self.derived
        count = 0 if derived is None else derived.parent_face_count
        made = ", made of " + quantity(count, "faces") if count else ""
        without_area = int(self.faces_without_area.sum())
        copies = 0 if self.split is None else len(self.split.originals)
        made += ", shown with " + quantity(copies, "copies along seams") if copies else ""
        suffix = ", " + quantity(without_area, "faces without area") if without_area else ""
        turned = ", " + self.orientation.report() if self.orientation else ""
        return self.topology.report() + made + suffix + turned

    @property
    def spatial_index(self) -> SpatialIndex:
        """Rays, closest points and selections of faces; built when it is first asked for."""
        return self.made(_spatial_index)

    def closest_face(
        self,
        point: Any,
        max_distance: float,
        normal: Optional[Any] = None,
        max_angle: Optional[float] = None,
    ) -> Optional[SurfacePoint]:
        """The nearest point of the surface, exact over all faces.

        None if there is none within the distance.

        Args:
            point: (3,) meters in frame_id; one that is not finite finds nothing.
            max_distance: meters, on both sides of the surface.
            normal, max_angle: both or none: only faces count whose normal is within this angle
                (radians, 0 to pi) of this direction (3,), such as the upper of two storeys.
        Raises:
            ValueError: a distance that is negative or NaN, or a wrong shape or angle.
        """
        return self.spatial_index.closest(
            point=point,
            max_distance=checked_distance(max_distance),
            normal=normal,
            max_angle=max_angle,
        )

    def nearest_vertex(self, point: Any, max_distance: float) -> Optional[Tuple[int, float]]:
        """The nearest vertex and its distance; None if there is none within the distance (meters).

        Vertices without an edge do not count: no way leads there.
        """
        vertex, distance = _kernels._closest_vertex(
            self.vertices,
            (~self.topology.isolated_vertices).view(np.uint8),
            np.ascontiguousarray(point, np.float64),
            float(max_distance),
        )
        return None if vertex == NO_FACE else (int(vertex), float(distance))


def _rounded(vertices: Any, origin: np.ndarray) -> np.ndarray:
    given = np.asarray(vertices)
    if origin.any():
        given = given.astype(np.float64) - origin
    rounded = as_vertices(given)
    if given.dtype != np.float32:
        with np.errstate(invalid="ignore"):
            lost = float(np.abs(rounded - given.astype(np.float64)).max())
        check_rounding("no usable mesh", lost, rounded, origin)
    return rounded


def _spatial_index(geometry: MeshGeometry) -> SpatialIndex:
    return SpatialIndex(geometry.vertices, geometry.faces)
