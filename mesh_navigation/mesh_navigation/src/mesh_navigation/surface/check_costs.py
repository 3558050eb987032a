"""What the map says about points, poses and paths of a robot."""

from typing import List, NamedTuple, Optional, Tuple

import numpy as np

from mesh_map.base.errors import MeshMapError
from mesh_map.geometry.mesh_geometry import MeshGeometry
from mesh_map.geometry.walk import WalkEnd
from mesh_map.map.footprint import Footprint, FootprintVertices
from mesh_map.map.mesh_map import MeshMap
from mesh_map.spatial.hits import NO_FACE, SurfacePoints

from mesh_navigation.base.pose import vector_text
from mesh_navigation.body.robot_shape import MAX_DISTANCE, RobotShape
from mesh_navigation.surface.cost_scale import Factors, State, states_of, total
from mesh_navigation.surface.surface_corners import corners_of_pieces, nearest_corners
from mesh_navigation.surface.up_normals import face_up_normals

_AT_ONCE = 1024  # poses, and fewer where a footprint is so large that it has many vertices
_VERTICES_AT_ONCE = 8_000_000  # 32 MB; a client may ask for any distance to keep
_SAME_PLACE = 0.01  # m


class Check(NamedTuple):
    """What a place is like."""

    state: int
    """The worst `State` of the ground there."""
    cost: int
    """The sum of scaled costs of the vertices there, see `mesh_navigation.surface.cost_scale`."""


class PathCheck(NamedTuple):
    """What a path is like, as far as it was looked at."""

    last_checked: int
    """Index of the last pose that was checked."""
    state: int
    """The worst `State` of all poses that were checked."""
    cost: int
    """The sum for all of them; each vertex counts once."""


class CostChecks:
    """Answers of one moment: all by the same costs.

    Ground is what the nearest corner of its face is, as for start and goal of plans. It is looked
    for within `MAX_DISTANCE` of a point; beyond, a point is OUTSIDE. Under a robot with a shape,
    each vertex counts that is the nearest corner to some of the ground under it; where one of the
    corners of the shape has no ground below or above it, it is OUTSIDE.
    """

    def __init__(
        self, mesh_map: MeshMap, shape: RobotShape = RobotShape(), cost_limit: float = 1.0
    ) -> None:
        """
        Args:
            mesh_map: the map; its costs of now count.
            shape: of the robot.
            cost_limit: vertices whose cost is higher are INSCRIBED.
        """
        self._map = mesh_map
        self._shape = shape
        self._limit = cost_limit
        self._costs = mesh_map.planning_costs().costs

    def point(self, position: np.ndarray) -> Check:
        """One point.

        Args:
            position: (3,) m.

        Raises:
            MeshMapError: it is not finite.
        """
        if not np.isfinite(position).all():
            raise MeshMapError(f"the point {vector_text(position)} is not finite")
        carried = self._map.queries.carry(np.asarray(position)[None], max_distance=MAX_DISTANCE)
        states, vertices = self._at(carried)
        return Check(int(states[0]), total(self._costs[vertices], self._limit, Factors()))

    def pose(self, pose: np.ndarray, distance: float = 0.0, factors: Factors = Factors()) -> Check:
        """The robot at one pose; arguments of `path`, for one row (7,)."""
        found = self.path(np.asarray(pose)[None], distance, factors)
        return Check(found.state, found.cost)

    def path(
        self,
        poses: np.ndarray,
        distance: float = 0.0,
        factors: Factors = Factors(),
        return_on: int = 0,
        skip_poses: int = 0,
        path_only: bool = False,
    ) -> PathCheck:
        """The robot along a path.

        Args:
            poses: (N,7) in the map's frame: position (m) and quaternion x, y, z, w.
            distance: to keep around the robot (m).
            factors: for costs that are not free.
            return_on: ends at the first pose of this state or a worse one; 0: checks all.
            skip_poses: so many are left out after each one that is checked.
            path_only: checks only the ground under the path itself: at each pose that is checked,
                and straight on from the pose before it where the surface leads there.

        Raises:
            MeshMapError: no poses, one that is none, or a distance or factor that is negative.
        """
        poses = np.asarray(poses, np.float64).reshape(-1, 7)
        _check_poses(poses)
        if not 0.0 <= distance < np.inf:
            raise MeshMapError(f"the distance to keep is {distance} m, not 0 or more")
        factors = factors.checked()
        footprint = None if path_only else self._shape.footprint(distance)
        indices = np.arange(0, len(poses), skip_poses + 1)
        worst, last, seen = State.FREE, 0, np.zeros(len(self._costs), np.bool_)
        begin, size = 0, _batch(len(self._costs))
        while begin < len(indices):
            chosen = indices[begin : begin + size]
            begin += len(chosen)
            states, rows = self._along(poses, chosen, footprint, path_only)
            size = min(8 * size, _batch(len(rows.vertices) / len(chosen)))
            ends = np.flatnonzero(states >= return_on) if return_on > 0 else chosen[:0]
            count = int(ends[0]) + 1 if len(ends) else len(chosen)
            worst, last = max(worst, State(states[:count].max())), int(chosen[count - 1])
            seen[rows.vertices[: rows.offsets[count]]] = True
            if len(ends):
                break
        return PathCheck(last, int(worst), total(self._costs[seen], self._limit, factors))

    def _along(
        self, poses: np.ndarray, chosen: np.ndarray, footprint: Optional[Footprint], path_only: bool
    ) -> Tuple[np.ndarray, FootprintVertices]:
        """States of the chosen poses, and the vertices of each."""
        carried = self._map.queries.carry(poses[chosen, :3], max_distance=MAX_DISTANCE)
        if footprint is not None:
            return self._under(poses[chosen], carried, footprint)
        states, vertices = self._at(carried)
        owners = np.flatnonzero(carried.faces != NO_FACE)
        if path_only:
            on_way, of = self._vertices_between(poses, chosen, carried)
            np.maximum.at(states, of, self._states(on_way))
            order = np.argsort(np.concatenate([owners, of]), kind="stable")
            vertices = np.concatenate([vertices, on_way])[order]
            owners = np.concatenate([owners, of])[order]
        offsets = np.searchsorted(owners, np.arange(len(chosen) + 1))
        return states, FootprintVertices(offsets, vertices)

    def _at(self, carried: SurfacePoints) -> Tuple[np.ndarray, np.ndarray]:
        """States (N,) at points, and the nearest corners of those on the map."""
        states = np.full(len(carried.faces), State.OUTSIDE, np.uint8)
        found = carried.faces != NO_FACE
        faces, positions = carried.faces[found], carried.positions[found]
        vertices = nearest_corners(self._map.geometry, faces, positions)
        states[found] = self._states(vertices)
        return states, vertices

    def _states(self, vertices: np.ndarray) -> np.ndarray:
        return states_of(self._costs[vertices], self._limit)

    def _under(
        self, poses: np.ndarray, carried: SurfacePoints, footprint: Footprint
    ) -> Tuple[np.ndarray, FootprintVertices]:
        matrices = poses_on_surface(self._map.geometry, poses[:, 3:], carried)
        rows = self._map.queries.vertices_under(footprint, matrices)
        states = np.full(len(poses), State.FREE, np.uint8)
        begins, ends = rows.offsets[:-1].astype(np.int64), rows.offsets[1:].astype(np.int64)
        covers = begins < ends
        if covers.any():
            states[covers] = np.maximum.reduceat(self._states(rows.vertices), begins[covers])
        states[self._is_beyond(matrices, footprint)] = State.OUTSIDE
        return states, rows

    def _is_beyond(self, matrices: np.ndarray, footprint: Footprint) -> np.ndarray:
        """(N,) bool: off the map, or one of the corners without ground."""
        corners = footprint.polygon
        tops = np.column_stack([corners, np.full(len(corners), footprint.above)])
        origins = np.einsum("nij,cj->nci", matrices[:, :3, :3], tops) + matrices[:, None, :3, 3]
        directions = np.repeat(-matrices[:, None, :3, 2], len(corners), axis=1)
        hits = self._map.spatial_index.any_hit_batch(
            origins=origins.reshape(-1, 3),
            directions=directions.reshape(-1, 3),
            max_distance=footprint.above + footprint.below,
        )
        return ~hits.reshape(len(matrices), len(corners)).all(axis=1)

    def _vertices_between(
        self, poses: np.ndarray, chosen: np.ndarray, carried: SurfacePoints
    ) -> Tuple[np.ndarray, np.ndarray]:
        """What lies on the ways from the poses before, where the surface leads straight on: (K,)
        vertices, and (K,) to which of the chosen poses each way leads."""
        later = np.flatnonzero((chosen > 0) & (carried.faces != NO_FACE))
        before = self._map.queries.carry(poses[chosen[later] - 1, :3], max_distance=MAX_DISTANCE)
        on_map = before.faces != NO_FACE
        later, before = later[on_map], SurfacePoints(*(row[on_map] for row in before))
        geometry = self._map.geometry
        ups = face_up_normals(geometry, before.faces.astype(np.int64))
        targets = carried.positions[later]
        walks = geometry.walker.line_batch(starts=before, targets=targets, ups=ups, paths=True)
        gaps = np.linalg.norm(walks.positions - targets, axis=1)
        there = np.flatnonzero((walks.ends == WalkEnd.ARRIVED) & (gaps < _SAME_PLACE))
        ways = [walks.paths[index] for index in there]
        none = np.zeros((0, 3))
        corners, _ = corners_of_pieces(
            geometry,
            np.concatenate([none[:, 0]] + [way.faces for way in ways]),
            np.concatenate([none] + [way.points[:-1] for way in ways]),
            np.concatenate([none] + [way.points[1:] for way in ways]),
        )
        owners = np.repeat(later[there], [3 * len(way.faces) for way in ways])
        return corners.ravel(), owners


def _batch(vertices: float) -> int:
    """How many poses to look at at once, of so many vertices each."""
    return int(np.clip(_VERTICES_AT_ONCE / max(vertices, 1.0), 1, _AT_ONCE))


def _check_poses(poses: np.ndarray) -> None:
    if not len(poses):
        raise MeshMapError("the path has no poses")
    with np.errstate(over="ignore"):
        lengths = np.linalg.norm(poses[:, 3:], axis=1)
    faults: List[Tuple[np.ndarray, str]] = [
        (~np.isfinite(poses).all(axis=1), "not finite"),
        (~((lengths > 1e-6) & (lengths < 1e6)), "without an orientation (none at all: w = 1)"),
    ]
    for wrong, what in faults:
        if wrong.any():
            first = int(np.argmax(wrong))
            where = vector_text(poses[first])
            raise MeshMapError(
                f"{wrong.sum()} of {len(poses)} poses are {what}, first {first} {where}"
            )


_NO_DIRECTION = 1e-6


def poses_on_surface(
    geometry: MeshGeometry, orientations: np.ndarray, carried: SurfacePoints
) -> np.ndarray:
    """(N,4,4) matrices from the frame of a robot that stands there to that of the map.

    Its z axis is the normal of the surface, turned up; its x axis is that of the pose, along the
    surface. Of one that looks straight up or down, the y axis tells where it heads. So roll and
    pitch of poses make no difference. NaN off the map.

    Args:
        geometry: of the map.
        orientations: (N,4) quaternions x, y, z, w of any length but 0.
        carried: where it stands.
    """
    matrices = np.full((len(orientations), 4, 4), np.nan)
    found = carried.faces != NO_FACE
    up = face_up_normals(geometry, carried.faces[found].astype(np.int64))
    x_axes, y_axes = _axes(orientations[found])
    ahead, left = _along_surface(x_axes, up), _along_surface(y_axes, up)
    steep = np.linalg.norm(ahead, axis=1) < _NO_DIRECTION
    ahead[steep] = np.cross(left[steep], up[steep])
    ahead /= np.linalg.norm(ahead, axis=1, keepdims=True)
    left = np.cross(up, ahead)
    matrices[found, :3] = np.stack([ahead, left, up, carried.positions[found]], axis=2)
    matrices[found, 3] = 0.0, 0.0, 0.0, 1.0
    return matrices


def _axes(orientations: np.ndarray) -> np.ndarray:
    """(2,N,3): the first two columns of the rotation matrices of quaternions."""
    x, y, z, w = (orientations / np.linalg.norm(orientations, axis=1, keepdims=True)).T
    return np.stack(
        [
            np.stack([1 - 2 * (y * y + z * z), 2 * (x * y + z * w), 2 * (x * z - y * w)], axis=1),
            np.stack([2 * (x * y - z * w), 1 - 2 * (x * x + z * z), 2 * (y * z + x * w)], axis=1),
        ]
    )


def _along_surface(vectors: np.ndarray, normals: np.ndarray) -> np.ndarray:
    """What of vectors (N,3) is at right angles to normals (N,3)."""
    return vectors - np.einsum("ni,ni->n", vectors, normals)[:, None] * normals
