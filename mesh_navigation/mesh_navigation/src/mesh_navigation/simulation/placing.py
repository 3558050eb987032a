"""Where to put a robot that somebody points at from above."""

import math
from typing import Any, Optional, Sequence

import numpy as np

from mesh_map.base.errors import MeshMapError
from mesh_map.geometry.topology import Topology
from mesh_map.map.mesh_map import MeshMap

from mesh_navigation.base.pose import Pose
from mesh_navigation.execution.planning import surface_heights
from mesh_navigation.surface.slowness import passable

ON_SURFACE = 0.05  # m
COST_LIMIT = 1.0  # of free ground; that of the planners, unless they are told another one
_ABOVE = 1.0  # m above the highest point


def put_down(mesh_map: MeshMap, pose: Pose) -> Pose:
    """The pose on the surface: where it is, if it is there; else straight above or below, at the
    height that differs least; else as near as it can be.

    RViz tells poses at the height 0, whatever the ground.
    """
    if mesh_map.closest_face(pose.position, ON_SURFACE) is not None:
        return pose
    x, y, z = pose.position
    heights = surface_heights(mesh_map, x, y)
    if heights:
        best = min(heights, key=lambda height: abs(height - z))
        return pose._replace(position=np.array([x, y, best]))
    found = mesh_map.closest_face(pose.position, math.inf)
    return pose if found is None else pose._replace(position=found.position)


def initial_pose(
    mesh_map: MeshMap, given: Sequence[Any] = (), costs: Optional[np.ndarray] = None
) -> Pose:
    """Where a robot begins.

    Args:
        mesh_map: the map.
        given: x, y, z (m) and yaw (rad); without yaw, or without z and yaw; nothing: on the largest
            region of free ground, as near as that is to the uppermost surface in the middle of the
            map (to the surface that is nearest to there); on that itself where no ground is free.
        costs: (V,) of planners, which say what is free; None: the map's own.

    Raises:
        MeshMapError: other numbers.
    """
    if not len(given):
        low, high = mesh_map.vertices.min(axis=0), mesh_map.vertices.max(axis=0)
        middle = (low.astype(np.float64) + high) / 2
        pose = put_down(mesh_map, Pose.at([*middle[:2], high[2] + _ABOVE]))
        return _on_free_ground(mesh_map, pose, mesh_map.costs if costs is None else costs)
    try:
        numbers = np.asarray(given, dtype=np.float64)
    except (TypeError, ValueError):
        numbers = np.zeros(0)
    if numbers.shape not in ((2,), (3,), (4,)) or not np.all(np.isfinite(numbers)):
        text = f"initial_pose is {list(given)!r}"
        raise MeshMapError(text, "[x, y], [x, y, z] or [x, y, z, yaw] is needed, m and rad")
    height: Optional[float] = numbers[2] if len(numbers) > 2 else None
    if height is None:
        height = float(mesh_map.vertices[:, 2].max()) + _ABOVE
    yaw = float(numbers[3]) if len(numbers) > 3 else 0.0
    return put_down(mesh_map, Pose.at([*numbers[:2], height], yaw))


def _on_free_ground(mesh_map: MeshMap, pose: Pose, costs: np.ndarray) -> Pose:
    """The pose itself, or that in the middle of the nearest face of the largest free region."""
    region = _largest_region(mesh_map, passable(costs, COST_LIMIT))
    found = mesh_map.closest_face(pose.position, math.inf)
    if found is None or not len(region) or found.face in region:
        return pose
    centers = mesh_map.vertices[mesh_map.faces[region]].mean(axis=1, dtype=np.float64)
    away = np.linalg.norm(centers - pose.position, axis=1)
    return pose._replace(position=centers[away.argmin()])


def _largest_region(mesh_map: MeshMap, free: np.ndarray) -> np.ndarray:
    """Faces whose corners are free (V,) and that hang together, of the largest area."""
    indices = np.flatnonzero(free[mesh_map.faces].all(axis=1))
    if not len(indices):
        return indices
    faces = mesh_map.faces[indices]
    a, b, c = (mesh_map.vertices[faces[:, k]].astype(np.float64) for k in range(3))
    areas = np.linalg.norm(np.cross(b - a, c - a), axis=1)  # twice
    regions = Topology(faces=faces, vertex_count=len(free)).components[faces[:, 0]]
    return indices[regions == np.bincount(regions, weights=areas).argmax()]
