"""How far a robot may go straight on before the ground ends or is blocked."""

from typing import NamedTuple, Optional

import numpy as np

from mesh_map.hits import SurfacePoint
from mesh_map.mesh_map import MeshMap
from mesh_map.walk import WalkEnd

from mesh_navigation.anchors import obstacle_at
from mesh_navigation.pose import vector_text
from mesh_navigation.slowness import passable
from mesh_navigation.surface_corners import corners_along


class FreeWay(NamedTuple):
    """The ground in one direction."""

    length: float
    """m that are free; as much as was looked at where nothing is in the way."""
    obstacle: str
    """What is in the way, as a phrase; empty if nothing is."""


def free_way(
    mesh_map: MeshMap, start: SurfacePoint, direction: np.ndarray, length: float
) -> FreeWay:
    """Look straight on over the surface.

    Ground is blocked where the nearest corner of its face is lethal or unknown. Blocked ground at
    the start itself does not count as long as free ground follows: who stands on it may leave it.

    Args:
        mesh_map: the map, with its costs of now.
        start: where the robot stands.
        direction: (3,), what of it is along the surface counts.
        length: how far to look (m).
    """
    costs = mesh_map.planning_costs().costs
    walk = mesh_map.geometry.walker.walk(start=start, direction=direction, length=length, path=True)
    if walk.end == WalkEnd.NOWHERE or walk.path is None:
        return FreeWay(0.0, f"there is no way on from {vector_text(start.position)}")
    along = corners_along(mesh_map.geometry, walk.path)
    free = passable(costs[along.vertices], np.inf)
    first = _first_blocked(free)
    if first is not None:
        vertex = int(along.vertices[first])
        what = obstacle_at(mesh_map, vertex, float(costs[vertex]), np.inf)
        where = vector_text(mesh_map.vertices[vertex])
        return FreeWay(float(along.entered[first]), f"vertex {vertex} at {where} is {what}")
    if walk.end != WalkEnd.ARRIVED:
        return FreeWay(walk.length, f"the surface ends at {vector_text(walk.position)}")
    return FreeWay(walk.length, "")


def _first_blocked(free: np.ndarray) -> Optional[int]:
    """Of (K,) bool, the first False that is not of a beginning which free ground follows."""
    begin = int(np.argmax(free)) if free.any() else 0
    blocked = np.flatnonzero(~free[begin:])
    return begin + int(blocked[0]) if len(blocked) else None
