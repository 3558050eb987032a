"""Maps that a robot is localized on, from a file or a topic, made ready in their own thread."""

import threading
from typing import Any, Callable, Mapping, NamedTuple, Optional

import rospy
from mesh_map.base.errors import MeshMapError, error_line
from mesh_map.geometry.mesh_geometry import MeshGeometry
from mesh_map.geometry.seams import stitched_faces
from mesh_map.geometry.topology import quantity
from mesh_map.io.map_source import MapSource
from mesh_map.registration.point_to_plane import PlaneTarget
from mesh_msgs import arrays, validation
from mesh_msgs_hdf5.files.probe import check_node_path
from mesh_msgs_hdf5.model.errors import MapFileError
from mesh_msgs.text import one_line


class LocalizationMap(NamedTuple):
    """target: what scans are laid onto; geometry: of which mesh; frame: of the map."""

    target: PlaneTarget
    geometry: MeshGeometry
    frame: str


class MapWatch:
    """Waits for maps. `fault` says why there is none, or why the newest one cannot be used; it is
    empty where that is in use."""

    def __init__(self, values: Mapping[str, Any], take: Callable[[LocalizationMap], None]) -> None:
        """
        Args:
            values: parameters of the node.
            take: gets each map that differs from the one before, in the thread of this class.
        """
        self._values, self._take = values, take
        self._uuid = ""
        self._newest: Optional[arrays.MeshGeometryStamped] = None
        self._condition = threading.Condition()
        if values["mesh_file"]:
            self.fault = "the map %s is being read" % values["mesh_file"]
            run = self._read
        else:
            topic = rospy.resolve_name(values["mesh_topic"])
            self.fault = "there is no map on %s yet (or set mesh_file)" % topic
            self._subscriber = rospy.Subscriber(
                values["mesh_topic"],
                arrays.MeshGeometryStamped,
                self._on_mesh,
                queue_size=1,
                buff_size=1 << 26,
            )
            run = self._run
        threading.Thread(target=run, name="map", daemon=True).start()

    def _read(self) -> None:
        values = self._values
        try:
            try:
                check_node_path(values["mesh_file"])
            except MapFileError as error:
                raise MeshMapError(str(error)) from error
            source = MapSource(
                values["mesh_file"], values["mesh_part"] or None, values["origin"] or None
            )
            mesh_map = source.make_map(values["global_frame_id"])
            self._use(mesh_map.geometry)
        except Exception as error:  # of whatever is in the file
            self._refuse("the map cannot be read: %s" % error_line(error))

    def _on_mesh(self, message: arrays.MeshGeometryStamped) -> None:
        with self._condition:
            self._newest = message
            self._condition.notify()

    def _run(self) -> None:
        while not rospy.is_shutdown():
            with self._condition:
                while self._newest is None and not rospy.is_shutdown():
                    self._condition.wait(1.0)
                message, self._newest = self._newest, None
            if message is None or (message.uuid and message.uuid == self._uuid):
                continue
            try:
                self._use(self._geometry(message))
            except Exception as error:  # of whatever is published there
                topic = rospy.resolve_name(self._values["mesh_topic"])
                self._refuse("the map on %s cannot be used: %s" % (topic, error_line(error)))

    def _geometry(self, message: arrays.MeshGeometryStamped) -> MeshGeometry:
        findings = validation.mesh_geometry_stamped(message)
        if findings:
            raise MeshMapError(one_line(findings[0]))
        mesh, frame = message.mesh_geometry, message.header.frame_id.lstrip("/")
        faces = stitched_faces(mesh.vertices, mesh.faces)
        frame = self._values["global_frame_id"] or frame
        return MeshGeometry(mesh.vertices, faces, frame_id=frame, uuid=message.uuid)

    def _use(self, geometry: MeshGeometry) -> None:
        frame, odometry = geometry.frame_id.lstrip("/"), self._values["odom_frame_id"].lstrip("/")
        if frame == odometry:
            text = "the map is in the frame of the odometry, '%s'"
            raise MeshMapError(text % frame, "set odom_frame_id, or global_frame_id")
        if geometry.uuid == self._uuid:
            return
        target = PlaneTarget(geometry.spatial_index, geometry.face_normals)
        self._uuid, self.fault = geometry.uuid, ""
        self._take(LocalizationMap(target, geometry, frame))
        text = "%s: the map has %s in frame %s"
        count = quantity(len(geometry.faces), "faces")
        rospy.loginfo(text, rospy.get_name(), count, frame)

    def _refuse(self, fault: str) -> None:
        self.fault = fault
        if not rospy.is_shutdown():
            rospy.logerr("%s: %s", rospy.get_name(), fault)
