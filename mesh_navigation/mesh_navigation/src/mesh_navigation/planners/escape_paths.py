"""Paths from a start on closed ground to ground that is open."""

from typing import Any, List, NamedTuple, Optional

import numpy as np

from mesh_map.base.cancel import CancelFlag
from mesh_map.distance.surface_path import FieldTracer, SurfacePath
from mesh_map.distance.wave_front import WaveFrontField, WaveFrontSolver
from mesh_map.map.mesh_map import MeshMap

from mesh_navigation.body.body import Body
from mesh_navigation.body.near_obstacles import TOLERANCE
from mesh_navigation.surface.face_points import FacePoint
from mesh_navigation.surface.slowness import CostSnapshot

_FIRST_REACH = 0.5  # m, how far open ground is looked for first; then ever farther
_FARTHER = 4.0  # times
_NEARER = 10.0  # what a meter counts that is nearer to lethal ground than the start is


class EscapePath(NamedTuple):
    """One of them."""

    vertex: int
    """Where it ends: may be passed."""
    path: SurfacePath
    """From the start to there."""


class _Field(NamedTuple):
    """What a way is traced down."""

    labels: np.ndarray
    limit: float
    slowness: np.ndarray
    goal_face: int
    goal_position: np.ndarray


class EscapePaths:
    """Of one start, whose ground is closed, but neither lethal nor unknown; for one plan.

    They lead over ground that only costs too much, or is only nearer to lethal ground than the
    robot's radius, and over open ground; what is lethal or unknown they never touch. They are the
    shortest; what is nearer to lethal ground than the start is counts tenfold where the robot has a
    body, so that they lead there only where there is no other way.

    Attributes:
        start: where it is.
    """

    def __init__(
        self,
        mesh_map: MeshMap,
        start: FacePoint,
        snapshot: CostSnapshot,
        body: Body,
        flag: CancelFlag,
    ) -> None:
        """
        Args:
            mesh_map: the map.
            start: its nearest corner is closed, and of finite cost.
            snapshot: what may be passed.
            body: of the robot on that map.
            flag: ends the search.
        """
        self.start = start
        self._map, self._snapshot = mesh_map, snapshot
        self._flag = flag
        self._solver = WaveFrontSolver.of(mesh_map.geometry)
        self._finite = np.isfinite(snapshot.costs)
        slowness = np.where(self._finite, np.float32(1.0), np.float32(np.inf))
        if body.radius > 0.0:
            distances = np.minimum(body.distances(snapshot.costs), body.radius)
            own = float(start.weights(mesh_map) @ distances[start.corners])
            slowness[self._finite & (distances < own - TOLERANCE)] = _NEARER
        self._field = self._begun(slowness)

    def to(self, exits: np.ndarray) -> Optional[EscapePath]:
        """The shortest way to one of these vertices; None where none of them can be reached.

        Args:
            exits: (V,) bool, of vertices that may be passed.

        Raises:
            Canceled: by the flag.
        """
        vertices, field = np.flatnonzero(exits), self._field
        reach = _FIRST_REACH
        while len(vertices):
            labels = field.labels[vertices]
            nearest = int(np.argmin(labels))
            if labels[nearest] <= field.limit and np.isfinite(labels[nearest]):
                return EscapePath(int(vertices[nearest]), self._path(int(vertices[nearest])))
            if np.isposinf(field.limit):
                return None
            field.extend(max_distance=reach, cancel=self._flag)
            reach *= _FARTHER
        return None

    def opened(self) -> np.ndarray:
        """(V,) float32: the costs, with 0 on all closed ground that can be reached from the start
        without crossing open ground.

        Raises:
            Canceled: by the flag.
        """
        closed = self._finite & ~self._snapshot.passable
        field = self._begun(np.where(closed, np.float32(1.0), np.float32(np.inf)))
        field.extend(cancel=self._flag)
        return np.where(np.isfinite(field.labels), np.float32(0.0), self._snapshot.costs)

    def _begun(self, slowness: np.ndarray) -> WaveFrontField:
        """A field from the start that has got nowhere yet."""
        start: Any = self.start
        if not np.isfinite(slowness[start.corners]).all():
            # Straight to the nearest corner no other one is nearer.
            vertex = int(start.corners[0])
            start = [(vertex, float(start.distances[0] * slowness[vertex]))]
        return self._solver.solve(start, slowness=slowness, max_distance=0.0, cancel=self._flag)

    def _path(self, vertex: int) -> SurfacePath:
        """From the start to a vertex that the field reaches."""
        start, field = self.start, self._field
        down = _Field(field.labels, field.limit, field.slowness, start.face, start.position)
        path = FieldTracer.of(self._map.geometry).path(down, self._place(vertex), cancel=self._flag)
        return SurfacePath(path.points[::-1], path.faces[::-1], path.potentials[::-1])

    def _place(self, vertex: int) -> FacePoint:
        """In a face that may be crossed, if there is one."""
        faces: List[int] = self._map.topology.faces_of(vertex).tolist()
        whole = self._finite[self._map.faces[faces]].all(axis=1)
        face = faces[int(np.argmax(whole))]
        return FacePoint.at(self._map, face, self._map.vertices[vertex])
