"""Ways down a potential over the surface, and the directions of them."""

import math
import operator
from dataclasses import dataclass
from typing import Any, Optional

import numpy as np

from mesh_map import _kernels
from mesh_map.base.array_checks import read_only
from mesh_map.base.cancel import CancelFlag, kernel_flag
from mesh_map.base.errors import Canceled
from mesh_map.base.query_arguments import number, vector
from mesh_map.distance.obstacle_distance import SurfaceFront
from mesh_map.geometry.mesh_geometry import MadeOnce, MeshGeometry


@dataclass(frozen=True, eq=False)
class SurfacePath:
    """A way over the surface, straight from point to point.

    Attributes:
        points: (N, 3) float64 meters, from the start to the goal; one where the start is the goal.
        faces: (N - 1,) uint32, the face in which point i to i + 1 lies, with both its ends (any of
            those at an edge, for a way along it).
        potentials: (N,) float64, what is left to the goal: strictly decreasing.
    """

    points: np.ndarray
    faces: np.ndarray
    potentials: np.ndarray

    @property
    def length(self) -> float:
        """Meters."""
        return float(np.linalg.norm(np.diff(self.points, axis=0), axis=1).sum())


class FieldTracer(MadeOnce):
    """Follows potentials over one mesh, any triangle soup, down to their goals.

    Down the gradient, as Kimmel and Sethian 1998, and Pütz et al., 5.3.

    A way crosses faces straight, from where it enters one to exactly where it leaves it, as the
    front that made the potential came through the faces ahead. It stays on the surface, goes
    through vertices and around closed faces where the front did, always arrives where the front
    came from the goal, and ends exactly there. The same numbers give the same way.

    Any thread may ask at any time; the GIL is released meanwhile.

    Argument of all methods:
        field: a WaveFrontField or DijkstraField, or anything with labels ((V,) float64, not finite
            where nothing came), limit (labels up to it are final), slowness ((V,) float32 or None;
            what is not finite is closed), goal_face and goal_position (both None where the front
            came from vertices: a way then ends at the one it comes from). It must not change
            meanwhile.
    """

    def __init__(self, geometry: MeshGeometry) -> None:
        """Prepares the mesh."""
        topology = geometry.topology
        self.kernel = _kernels._FieldTracer(
            geometry.vertices,
            geometry.faces,
            topology.vertex_face_offsets,
            topology.vertex_faces,
            topology.face_flags,
        )
        self._marching_mesh = SurfaceFront.of(geometry)
        self._normals = geometry.vertex_normals

    def path(
        self,
        field: Any,
        start: Any,
        *,
        max_length: float = math.inf,
        cancel: Optional[CancelFlag] = None,
    ) -> Optional[SurfacePath]:
        """The way from a point to the goal; None where no corner of its face is reached.

        Along the way the potential falls. Where the labels leave no way down (noise; ridges where
        fronts from two sides met), the way climbs along edges to the nearest lower vertex, and the
        potentials there are interpolated between the two points around. Where the slowness is 0,
        potentials are, too.

        Args:
            field: see the class.
            start: anything with face and position, such as a SurfacePoint. Its face may be left
                even if a corner is closed, and that of the goal may be entered; no other such.
            max_length: meters, after which the way is cut off: what lies ahead of a robot.
            cancel: ends this when it is set.
        Raises:
            ValueError: a start or goal that is not on its face, a field of another mesh, or a
                length that is not >= 0.
            Canceled: `cancel` was set.
        """
        face, position = _point(start)
        bound, flag = _bound(self.kernel, field), kernel_flag(cancel)
        limit = () if max_length == math.inf else (number(max_length, "max_length"),)
        found = self.kernel._path(bound, face, position, flag, *limit)
        if isinstance(found, bool):
            if found:
                raise Canceled("the way down the potential was cancelled")
            return None
        return SurfacePath(*(read_only(array) for array in found))

    def value(self, field: Any, point: Any) -> float:
        """The potential at a point of the surface; +inf where no corner of its face is reached.

        Args:
            field: see the class.
            point: anything with face and position.
        Raises:
            ValueError: a point that is not on its face, or a field of another mesh.
        """
        face, position = _point(point)
        return self.kernel._value(_bound(self.kernel, field), face, position)

    def vertex_directions(self, field: Any) -> np.ndarray:
        """(V, 3) float32 unit vectors down the potential, in the plane across the vertex normal.

        Zeros where there is none: at what is closed or not final, and at a vertex that is the goal.

        Raises:
            ValueError: a field of another mesh.
        """
        bound = _bound(self.kernel, field)
        return self.kernel._vertex_directions(bound, self._marching_mesh._mesh, self._normals)

    def face_directions(self, field: Any) -> np.ndarray:
        """(F, 3) float32 unit vectors down the potential at the middle of each face, in its plane.

        Zeros where there is none: faces without area, or with a corner that is closed or not final.

        Raises:
            ValueError: a field of another mesh.
        """
        return self.kernel._face_directions(_bound(self.kernel, field))


def _point(point: Any) -> Any:
    return operator.index(point.face), vector(point.position, "position")


def _bound(kernel: Any, field: Any) -> Any:
    face, position = field.goal_face, field.goal_position
    slowness = field.slowness
    return kernel._bind(
        np.ascontiguousarray(field.labels, np.float64),
        float(field.limit),
        None if slowness is None else np.ascontiguousarray(slowness, np.float32),
        None if face is None else operator.index(face),
        None if face is None else vector(position, "goal_position"),
    )
