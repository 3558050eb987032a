"""Obstacles from and to markers. No rospy: messages are plain data."""

from typing import Any, Dict, List, Sequence, Tuple

import numpy as np
from std_msgs.msg import ColorRGBA
from visualization_msgs.msg import Marker, MarkerArray

from mesh_map.base.errors import MeshMapError

from mesh_navigation.base.messages import bare_pose, pose_from_message
from mesh_navigation.simulation.obstacles import BOX, CYLINDER, MAX_OBSTACLES, SPHERE, Obstacle

_SHAPES = {Marker.CUBE: BOX, Marker.CYLINDER: CYLINDER, Marker.SPHERE: SPHERE}
_TYPES = {shape: kind for kind, shape in _SHAPES.items()}
_COLOR = ColorRGBA(0.9, 0.45, 0.1, 0.9)
_ROBOT_COLOR = ColorRGBA(0.1, 0.4, 0.9, 0.9)
_AHEAD_COLOR = ColorRGBA(1.0, 1.0, 1.0, 1.0)
_ROBOT_SIZE = (0.6, 0.4, 0.25)  # m


class ObstacleMarkers:
    """The obstacles that markers have told of, by namespace and id."""

    def __init__(self, obstacles: Sequence[Obstacle] = ()) -> None:
        """Args:
        obstacles: that are there at first; in the namespace "obstacles", numbered.
        """
        self._known: Dict[Tuple[str, int], Obstacle] = {
            ("obstacles", index): obstacle for index, obstacle in enumerate(obstacles)
        }

    @property
    def obstacles(self) -> List[Obstacle]:
        """All of them."""
        return list(self._known.values())

    def change(self, message: MarkerArray, frame_id: str) -> List[str]:
        """Add, replace and delete as RViz does.

        Args:
            message: markers of the types CUBE, CYLINDER and SPHERE.
            frame_id: the map's; others are refused.

        Returns:
            One sentence for each marker that could not be used.
        """
        complaints = []
        for marker in message.markers:
            key = (marker.ns, marker.id)
            if marker.action == Marker.DELETEALL:
                self._known.clear()
            elif marker.action == Marker.DELETE:
                self._known.pop(key, None)
            else:
                try:
                    self._known[key] = self._obstacle(marker, key, frame_id)
                except MeshMapError as error:
                    complaints.append(f"marker '{marker.ns}' {marker.id} is no obstacle: {error}")
        return complaints

    def _obstacle(self, marker: Marker, key: Tuple[str, int], frame_id: str) -> Obstacle:
        frame = marker.header.frame_id.lstrip("/")
        if frame != frame_id:
            raise MeshMapError(f"its frame is '{frame}'", f"'{frame_id}' is needed")
        if marker.type not in _SHAPES:
            raise MeshMapError(f"its type is {marker.type}", "CUBE, CYLINDER and SPHERE are known")
        if key not in self._known and len(self._known) >= MAX_OBSTACLES:
            raise MeshMapError(f"there are {MAX_OBSTACLES} already", "delete some")
        size = np.array([marker.scale.x, marker.scale.y, marker.scale.z])
        return Obstacle.checked(_SHAPES[marker.type], pose_from_message(marker.pose), size)

    def message(self, frame_id: str, base_frame: str) -> MarkerArray:
        """What RViz shows: all of them, and the robot as a box with an arrow ahead."""
        markers = [Marker(action=Marker.DELETEALL)]
        for (namespace, number), obstacle in self._known.items():
            marker = _marker(_TYPES[obstacle.shape], namespace, number, obstacle.size, _COLOR)
            marker.header.frame_id, marker.pose = frame_id, bare_pose(obstacle.pose)
            markers.append(marker)
        length, _, height = _ROBOT_SIZE
        for number, (kind, size, color, z) in enumerate(
            (
                (Marker.CUBE, _ROBOT_SIZE, _ROBOT_COLOR, height / 2),
                (Marker.ARROW, (length, 0.12, 0.12), _AHEAD_COLOR, height + 0.1),
            )
        ):
            robot = _marker(kind, "robot", number, size, color)
            robot.header.frame_id, robot.frame_locked = base_frame, True
            robot.pose.position.z, robot.pose.orientation.w = z, 1.0
            markers.append(robot)
        return MarkerArray(markers)


def _marker(kind: int, namespace: str, number: int, size: Any, color: ColorRGBA) -> Marker:
    marker = Marker(type=kind, action=Marker.ADD, ns=namespace, id=number, color=color)
    marker.scale.x, marker.scale.y, marker.scale.z = map(float, size)
    return marker
