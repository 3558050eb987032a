"""Where a wave front starts."""

import operator
from typing import TYPE_CHECKING, Any, List, Optional, Tuple

import numpy as np

from mesh_map.array_checks import read_only
from mesh_map.surface import barycentric_coordinates

if TYPE_CHECKING:
    from mesh_map.wave_front import WaveFrontSolver

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
            try:
                self._pairs = [(operator.index(v), float(distance)) for v, distance in goal]
            except (TypeError, ValueError):
                raise ValueError(
                    "the goal has to be a point with face and position, a vertex, or pairs of a "
                    "vertex and a potential"
                ) from None
            if not self._pairs:
                raise ValueError("there is no goal")
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
        offsets = solver._topology.vertex_face_offsets
        faces = solver._topology.vertex_faces[offsets[vertex] : offsets[vertex + 1]]
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
