"""What a drive has to be, looked at from outside: in NumPy, from the track and the costs alone."""

from typing import NamedTuple, Optional

import numpy as np
from mesh_map.map.mesh_map import MeshMap
from mesh_navigation.base.pose import Pose

from mesh_tools_test.driving.lethal_ground import LethalGround


class Track(NamedTuple):
    """What was found on a track of N poses."""

    off_surface: float
    """m, of the pose farthest from the surface."""
    blocked: np.ndarray
    """(K,) numbers of poses on blocked ground: lethal, unknown, or no ground at all."""
    lethal_distance: float
    """m along the surface, of the pose nearest to lethal or unknown ground, see `LethalGround`."""
    nearest: int
    """Number of that pose; -1 where no ground is lethal or unknown."""
    length: float
    """m."""
    longest_step: float
    """m, from one pose to the next."""


def on_the_map(
    track: np.ndarray, mesh_map: MeshMap, costs: np.ndarray, faces: Optional[np.ndarray] = None
) -> Track:
    """Where a track leads.

    A pose is on blocked ground where the nearest corner of its face (that of the largest
    barycentric coordinate) is lethal or unknown.

    Args:
        track: (N,7) poses.
        mesh_map: where.
        costs: (V,) when it was driven.
        faces: (N,) on which the robot was, as it says itself. They count where they are as near to
            the poses as the nearest ones: the bottom of a thing lies on the floor. None: the
            nearest.
    """
    points = np.ascontiguousarray(track[:, :3], np.float64)
    found = mesh_map.spatial_index.closest_batch(points=points)
    under = found.faces.astype(np.int64)
    if faces is not None:
        gaps = _gaps(points, mesh_map.vertices[mesh_map.faces[faces]].astype(np.float64))
        under = np.where(gaps <= found.distances + _SAME, faces, under)
    corners = mesh_map.faces[under].astype(np.int64)
    weights = barycentric(points, mesh_map.vertices[corners].astype(np.float64))
    nearest = corners[np.arange(len(points)), np.argmax(weights, axis=1)]
    closed = ~np.isfinite(costs)
    near = LethalGround(mesh_map, costs).nearest(points, under)
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    return Track(
        float(found.distances.max()),
        np.flatnonzero(closed[nearest]),
        near.distance,
        near.number,
        float(steps.sum()),
        float(steps.max()) if len(steps) else 0.0,
    )


_SAME = 1e-4  # m


def _gaps(points: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """(N,) m from points (N,3) to triangles (N,3,3); at least, where they are beside them."""
    weights = np.clip(barycentric(points, corners), 0.0, 1.0)
    weights /= weights.sum(axis=1, keepdims=True)
    return np.linalg.norm(np.einsum("ni,nid->nd", weights, corners) - points, axis=1)


def barycentric(points: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """(N,3) coordinates of points (N,3) in the planes of triangles (N,3,3)."""
    a, u, v = corners[:, 0], corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    w = points - a
    normal = np.cross(u, v)
    square = np.maximum(np.einsum("nd,nd->n", normal, normal), 1e-300)
    gamma = np.einsum("nd,nd->n", np.cross(u, w), normal) / square
    beta = np.einsum("nd,nd->n", np.cross(w, v), normal) / square
    return np.stack([1.0 - beta - gamma, beta, gamma], axis=1)


class Arrival(NamedTuple):
    """How far the last pose is from the goal."""

    distance: float
    """m."""
    angle: float
    """rad, between the headings within the ground."""


def arrival(pose: np.ndarray, goal: Pose, mesh_map: MeshMap) -> Arrival:
    """Of a pose (7,), which lies on the surface. The goal's heading is brought onto the ground
    there, then onto that of the robot, as no robot can look up or down from it."""
    wanted = _along_ground(goal.heading, goal.position, mesh_map)
    ends = Pose(pose[:3], pose[3:])
    found, wanted = (_along_ground(x, ends.position, mesh_map) for x in (ends.heading, wanted))
    angle = float(np.arccos(np.clip(found @ wanted, -1.0, 1.0)))
    return Arrival(float(np.linalg.norm(ends.position - goal.position)), angle)


def _along_ground(direction: np.ndarray, position: np.ndarray, mesh_map: MeshMap) -> np.ndarray:
    """(3,) of length 1, in the plane of the face that is nearest to a position."""
    found = mesh_map.spatial_index.closest(point=position)
    a, b, c = mesh_map.vertices[mesh_map.faces[found.face]].astype(np.float64)
    normal = np.cross(b - a, c - a)
    normal /= np.linalg.norm(normal)
    along = direction - (direction @ normal) * normal
    return along / np.linalg.norm(along)
