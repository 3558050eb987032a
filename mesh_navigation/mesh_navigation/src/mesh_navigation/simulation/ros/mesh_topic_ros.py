"""The mesh that another node publishes."""

from typing import Callable

import rospy

from mesh_map.geometry.mesh_geometry import MeshGeometry
from mesh_map.map.mesh_map import MeshMap
from mesh_msgs import arrays, validation
from mesh_msgs.text import one_line


class MeshTopic:
    """Hands on each mesh that differs from the one before, as a map without layers."""

    def __init__(self, name: str, on_map: Callable[[MeshMap], None]) -> None:
        """
        Args:
            name: of a topic of mesh_msgs/MeshGeometryStamped.
            on_map: called in a thread of rospy.
        """
        self._on_map, self._uuid = on_map, ""
        self.name = rospy.resolve_name(name)
        self._subscriber = rospy.Subscriber(
            name, arrays.MeshGeometryStamped, self._receive, queue_size=1
        )

    def _receive(self, message: arrays.MeshGeometryStamped) -> None:
        try:
            findings = validation.mesh_geometry_stamped(message)
            if findings:
                raise ValueError(str(findings[0]))
            geometry = _geometry(message)
            if geometry.uuid == self._uuid:
                return
            geometry.spatial_index, geometry.walker  # made here, not while the robot drives
            self._uuid = geometry.uuid
            self._on_map(MeshMap.of(geometry))
        except Exception as error:  # whatever is published there
            rospy.logerr("the mesh on %s cannot be used: %s", self.name, one_line(str(error)))


def _geometry(message: arrays.MeshGeometryStamped) -> MeshGeometry:
    mesh = message.mesh_geometry
    return MeshGeometry(
        mesh.vertices,
        mesh.faces,
        frame_id=message.header.frame_id.lstrip("/"),
        uuid=message.uuid,
    )
