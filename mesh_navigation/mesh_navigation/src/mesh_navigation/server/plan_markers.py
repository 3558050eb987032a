"""Markers for looking into a plan: what it was asked for, and where it begins and ends."""

from functools import partial
from typing import Callable, Dict, Optional, Tuple

import genpy
import numpy as np
from visualization_msgs.msg import Marker

from mesh_map.io.markers import no_marker, sphere_marker, triangles_marker
from mesh_map.map.mesh_map import MeshMap

from mesh_navigation.base.pose import Pose
from mesh_navigation.body.robot_shape import MAX_DISTANCE
from mesh_navigation.plugins.planner import PlanResult

Color = Tuple[float, float, float]
GREEN, RED = (0.0, 1.0, 0.0), (1.0, 0.0, 0.0)


def plan_markers(
    mesh_map: MeshMap, ends: Optional[Tuple[Pose, Pose]], result: PlanResult, stamp: genpy.Time
) -> Dict[str, Callable[[], Marker]]:
    """Functions that make the markers, by their namespaces; green at the start, red at the goal.

    start_point and goal_point are spheres where the poses asked for are, start_face and goal_face
    the triangles below them, plan_start and plan_goal spheres where the path begins and ends. What
    this plan does not have is taken away.

    Args:
        mesh_map: the map.
        ends: start and goal, in its frame; None if they are not known.
        result: of the plan.
        stamp: of the markers.
    """
    frame = mesh_map.frame_id
    makers: Dict[str, Callable[[], Marker]] = {}
    path = [result.poses[index, :3] for index in (0, -1)] if len(result.poses) else [None, None]
    for number, (what, color) in enumerate((("start", GREEN), ("goal", RED))):
        asked = ends[number].position if ends and not ends[number].fault() else None
        for namespace, position in ((what + "_point", asked), ("plan_" + what, path[number])):
            makers[namespace] = partial(_sphere, namespace, position, frame, stamp, color)
        namespace = what + "_face"
        makers[namespace] = partial(_face, namespace, asked, mesh_map, stamp, color)
    return makers


def _sphere(
    namespace: str, position: Optional[np.ndarray], frame: str, stamp: genpy.Time, color: Color
) -> Marker:
    if position is None:
        return no_marker(namespace, frame, stamp)
    return sphere_marker(namespace, position, frame, stamp, (*color, 1.0))


def _face(
    namespace: str,
    position: Optional[np.ndarray],
    mesh_map: MeshMap,
    stamp: genpy.Time,
    color: Color,
) -> Marker:
    found = None if position is None else mesh_map.closest_face(position, MAX_DISTANCE)
    if found is None:
        return no_marker(namespace, mesh_map.frame_id, stamp)
    corners = mesh_map.vertices[mesh_map.faces[found.face]]
    normal = mesh_map.face_normals[found.face]
    return triangles_marker(namespace, corners, mesh_map.frame_id, stamp, (*color, 0.5), normal)
