"""The wave front: distances and potentials over the surface from a point, across faces."""

import operator
from typing import Any, Iterable, List, Optional, Tuple

import numpy as np

from mesh_map import _kernels
from mesh_map.base.array_checks import read_only, vertex_indices
from mesh_map.base.cancel import CancelFlag, kernel_flag
from mesh_map.base.errors import Canceled, Cancelled  # noqa: F401
from mesh_map.distance.obstacle_distance import SurfaceFront
from mesh_map.distance.potential_field import PotentialField, pairs_of
from mesh_map.geometry.mesh_geometry import MadeOnce, MeshGeometry
from mesh_map.geometry.surface import barycentric_coordinates

# Weights of a point below this are none: it lies on an edge, or at a vertex.
_NO_WEIGHT = 1e-9
# A goal may be this far off its face, in parts of the size of the face and its coordinates.
_OFF_FACE = 1e-6


class WaveFrontGoal:
    """Where a field starts: a point in a face, at a vertex, or only potentials of vertices."""

    def __init__(
        self, solver: "WaveFrontSolver", goal: Any, slowness: Optional[np.ndarray]
    ) -> None:
        self.face: Optional[int] = None
        self.position: Optional[np.ndarray] = None
        self._corners = np.zeros(0, np.uint32)
        self._weights = np.zeros(0)
        self._distances = np.zeros(0)
        self._pairs: List[Tuple[int, float]] = []
        if hasattr(goal, "face") and hasattr(goal, "position"):
            self._set_point(solver, goal)
        elif hasattr(goal, "__index__"):
            self._set_vertex(solver, operator.index(goal), slowness)
        else:
            kinds = "a point with face and position, a vertex, or pairs of a vertex and a potential"
            self._pairs = pairs_of(goal, "goal", kinds)
            solver._indices([vertex for vertex, _ in self._pairs], "goal ")

    def seeds(self, slowness: Optional[np.ndarray]) -> Tuple[np.ndarray, np.ndarray]:
        """(N,) uint32 vertices and (N,) float64 potentials there."""
        if self._pairs:
            vertices, labels = zip(*self._pairs)
            return np.array(vertices, np.uint32), np.array(labels, np.float64)
        if slowness is None or slowness.shape != (slowness.size,) or not len(self._corners):
            return self._corners, self._distances
        if self._corners.max() >= len(slowness):
            return self._corners, self._distances  # the kernel says what is wrong
        slow = slowness[self._corners].astype(np.float64)
        is_open = slow < np.inf
        if not is_open.all():
            # The face is not crossed; what is left is the edge or the vertex that the goal is on.
            if self._weights[~is_open].max() > _NO_WEIGHT or not is_open.any():
                return np.zeros(0, np.uint32), np.zeros(0)
            slow = np.where(is_open, slow, 0.0)
        here = self._weights @ slow
        labels = self._distances * 0.5 * (slow + here)
        return self._corners[is_open], labels[is_open]

    def _set_point(self, solver: "WaveFrontSolver", goal: Any) -> None:
        self.face = operator.index(goal.face)
        if not 0 <= self.face < len(solver._faces):
            raise ValueError(
                "goal face %d does not exist: there are %d faces" % (self.face, len(solver._faces))
            )
        self.position = read_only(np.array(goal.position, np.float64))
        if self.position.shape != (3,) or not np.isfinite(self.position).all():
            raise ValueError("the position of the goal has to be three finite numbers")
        self._corners = np.ascontiguousarray(solver._faces[self.face])
        corners = solver._vertices[self._corners].astype(np.float64)
        self._distances = np.linalg.norm(corners - self.position, axis=1)
        self._weights = _weights(corners, self.position)
        off = float(np.linalg.norm(self._weights @ corners - self.position))
        size = float(np.linalg.norm(corners - corners[0], axis=1).max())
        is_flat = self._weights.max() == 1.0  # at a corner, or the face has no area
        if off > _OFF_FACE * (size + np.abs(corners).max()) + is_flat * size:
            raise ValueError("the goal is %.3g m from its face %d" % (off, self.face))

    def _set_vertex(
        self, solver: "WaveFrontSolver", vertex: int, slowness: Optional[np.ndarray]
    ) -> None:
        solver._indices([vertex], "goal ")
        self._corners = np.array([vertex], np.uint32)
        self._weights = np.ones(1)
        self._distances = np.zeros(1)
        self.position = read_only(solver._vertices[vertex].astype(np.float64))
        faces = solver._topology.faces_of(vertex)
        if len(faces):
            self.face = int(faces[0])
            if slowness is not None and slowness.shape == (len(solver._vertices),):
                is_open = (slowness[solver._faces[faces]] < np.inf).all(1)
                self.face = int(faces[np.argmax(is_open)])


def _weights(corners: np.ndarray, point: np.ndarray) -> np.ndarray:
    """(3,) weights of the corners of a face at a point of it; all at the nearest corner where the
    face has no area."""
    weights = np.maximum(barycentric_coordinates(point, *corners), 0)
    if not np.isfinite(weights).all():
        return np.eye(3)[np.argmin(np.linalg.norm(corners - point, axis=1))]
    return weights / weights.sum()


class WaveFrontField(PotentialField):
    """The potential of one goal: time to it over the surface, or meters where slowness is 1.

    It may end before the mesh does, and go on later. One writer at a time, others wait; readers
    are not to read while it is written.

    Attributes:
        goal_face: a face that the goal lies in; None if it is no point, or a vertex without faces.
        goal_position: (3,) float64 meters; None if it is no point.
        slowness: (V,) float32, the time that a meter takes; None for 1 everywhere.
        labels: (V,) float64, the potential in full: a view of what the kernel computes with. +inf
            where not reached; what is above `limit` may still become less.
    """

    def __init__(
        self, solver: "WaveFrontSolver", goal: Any, slowness: Optional[np.ndarray]
    ) -> None:
        """Private: see WaveFrontSolver.solve()."""
        self._solver = solver
        self._goal = WaveFrontGoal(solver, goal, slowness)
        self.goal_face = self._goal.face
        self.goal_position = self._goal.position
        self.slowness = slowness
        sources, distances = self._goal.seeds(slowness)
        kernel = _kernels._FastMarchingField(solver._pool, sources, distances, slowness)
        super().__init__(kernel, len(solver._vertices))
        self.labels: np.ndarray = self._kernel._labels()

    def update(
        self, slowness: Optional[Any], changed: Any, *, cancel: Optional[CancelFlag] = None
    ) -> int:
        """Mends the field after the slowness at some vertices has changed.

        Labels are then those of a new solve, within a relative 1e-5, as far as the field reached
        before; where that became farther, less is final. The time depends on how much changes.
        Not where most triangles are slivers and costs jump between neighbors, see README, Limits.

        Args:
            slowness: (V,), as for solve(): all values as they are now.
            changed: (K,) the vertices where they are other than before.
        Returns:
            how many labels were computed anew.
        Raises:
            ValueError: a wrong number of values, a negative one, or a vertex that does not exist.
            Canceled: `cancel` was set. Nothing is final then; extend() and update() finish it.
        """
        slowness = self._solver._slowness(slowness)
        vertices = self._solver._indices(changed, "changed ")
        flag = kernel_flag(cancel)
        with self._lock:
            sources, distances = self._goal.seeds(slowness)
            count, cancelled = self._kernel._update(sources, distances, slowness, vertices, flag)
            self.slowness = slowness
            self._forget_arrays()
        if cancelled:
            raise Canceled("the update of the wave front was cancelled")
        return count


class WaveFrontSolver(MadeOnce):
    """Wave fronts over one mesh, any triangle soup; any number of threads may solve at once.

    Fast marching for the eikonal equation, |grad potential| = slowness: Kimmel and Sethian,
    Computing geodesic paths on manifolds, 1998; Pütz et al., 5.3. Across a triangle, distances are
    those from the unfolded source: Novotni and Klein, Computing geodesic distances on triangular
    meshes, 2002.

    Exact on planes, whatever their triangulation; about 0.15 % too long on rough terrain, 0.1 % on
    a sphere (beyond ten edges from the goal). Faces with a closed corner are never crossed.

    The memory of fields that nobody has any more is used again: a solve costs what it reaches.
    """

    def __init__(self, geometry: MeshGeometry) -> None:
        """Prepares the mesh."""
        self._vertices = geometry.vertices
        self._faces = geometry.faces
        self._topology = geometry.topology
        self._pool = _kernels._FastMarchingPool(SurfaceFront.of(geometry)._mesh)

    def solve(
        self,
        goal: Any,
        *,
        slowness: Optional[Any] = None,
        targets: Optional[Iterable[int]] = None,
        offset: float = 0.0,
        max_distance: float = float("inf"),
        cancel: Optional[CancelFlag] = None,
    ) -> WaveFrontField:
        """The potential of a goal.

        Args:
            goal: a point of the surface (anything with `face` and `position`, such as
                SurfacePoint), a vertex, or pairs (vertex, potential to start with) of one place
                that the front comes from. Of several places solve each, and take the least: where
                their fronts meet head on, one field of both is too low, and takes long.
            slowness: (V,) >= 0, the time that a meter takes, linear within faces; +inf or NaN
                closes a vertex. None for 1. A float32 array is used as it is, and has to stay so.
            targets: vertices; once all are final, the field ends `offset` beyond the farthest.
                None for the whole field; so do targets that cannot be reached.
            offset: >= 0, in the unit of the potential.
            max_distance: what lies beyond is not reached.
            cancel: ends this when it is set.
        Raises:
            ValueError: a goal or a target that does not exist, a wrong number of values, or one out
                of its range (the first is named).
            Canceled: `cancel` was set.
        """
        field = WaveFrontField(self, goal, self._slowness(slowness))
        field.extend(targets, offset=offset, max_distance=max_distance, cancel=cancel)
        return field

    def _slowness(self, slowness: Optional[Any]) -> Optional[np.ndarray]:
        if slowness is None:
            return None
        return np.ascontiguousarray(slowness, np.float32)

    def _indices(self, vertices: Any, what: str) -> np.ndarray:
        return vertex_indices(vertices, len(self._vertices), what)
