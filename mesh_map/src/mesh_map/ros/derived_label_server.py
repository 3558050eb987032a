"""Labels of a derived mesh over ROS: shown and edited there, stored as faces of the parent."""

import logging
import threading
from typing import Any, Dict, List, Optional, Tuple

import numpy as np
import rospy
from mesh_msgs import array_services, arrays, validation
from mesh_msgs.text import one_line
from mesh_msgs_hdf5.checks.check import checked_label
from mesh_msgs_hdf5.model.errors import MapFileError
from mesh_msgs_hdf5.model.mesh import Label
from mesh_msgs_hdf5.ros.label_forwarding_ros import LabelForwarder
from mesh_msgs_hdf5.ros.label_services_ros import LabelServices
from mesh_msgs_hdf5.ros.map_messages import cluster
from mesh_msgs_hdf5.ros.sent_names import sent_name_fault
from mesh_msgs_hdf5.ros.store_results_ros import EVERY_MESSAGE

from mesh_map.base.errors import MeshMapError
from mesh_map.io.derived_labels import DerivedLabels
from mesh_map.map.mesh_map import MeshMap

_LOG = logging.getLogger("mesh_map")
_PERIOD = 0.5  # seconds between two looks at the time stamps of file and journal


class DerivedLabelServer:
    """Topics and services of labels as those of hdf5_map_server, for the derived mesh of a map.

    Edits on cluster_label become edits of the parent's faces and go to who owns the labels of the
    map file; whatever becomes of labels there, by whomever, is told on new_cluster_label.
    """

    def __init__(self, prefix: str, mesh_map: MeshMap, labels: DerivedLabels) -> None:
        """Serves those of a map.

        Args:
            prefix: of all names, ending with "/".
            mesh_map, labels: as for serve().
        """
        self._lock = threading.Lock()  # of what is known
        self._labels: Optional[DerivedLabels] = labels
        self._map: Optional[MeshMap] = mesh_map
        self._told: Dict[str, Label] = {}  # labels of the parent, as subscribers have them
        self._version: Any = None
        self._topic = prefix + "cluster_label"
        self._forwarder = LabelForwarder()
        self._services = LabelServices(prefix, self._find, self._forwarder, MeshMapError)
        self.serve(mesh_map, labels)
        self._parents = rospy.Service(
            prefix + "get_derived_mesh", array_services.GetDerivedMesh, self._get_derived
        )
        self._subscriber = rospy.Subscriber(
            self._topic, arrays.MeshFaceClusterStamped, self._edit, queue_size=EVERY_MESSAGE
        )
        self._closed = threading.Event()
        self._thread = threading.Thread(target=self._run, name="derived labels", daemon=True)
        self._thread.start()

    def serve(self, mesh_map: MeshMap, labels: Optional[DerivedLabels]) -> None:
        """From now on those of this map; None where its labels are not on a derived mesh."""
        with self._lock:
            if self._map is not None:
                self._services.forget(self._map.uuid)
            self._map, self._labels = mesh_map, labels
            self._told, self._version = {}, None
            if labels is not None:
                self._version = mesh_map.contents.labels_version()
                self._told = labels.parent.all()
                self._services.changed(mesh_map.uuid, labels)

    def save(self) -> str:
        """Has the owner put label edits into the map file; what it says, or "" without an owner:
        then there are none that it does not have.

        Raises:
            MeshMapError: the owner cannot do that.
        """
        labels = self._labels
        if labels is None or labels.owner is None:
            return ""
        try:
            return self._forwarder.save(labels.parent)
        except MapFileError as error:
            raise MeshMapError(str(error)) from error

    def shutdown(self) -> None:
        """Ends topics, services and the thread."""
        self._closed.set()
        self._thread.join()
        self._subscriber.unregister()
        self._parents.shutdown()
        self._services.shutdown()

    def _find(self, uuid: str) -> Tuple[str, DerivedLabels]:
        mesh_map, labels = self._map, self._labels
        if mesh_map is None:
            raise MeshMapError("no map is loaded")
        if uuid not in ("", "mesh", mesh_map.uuid):
            raise MeshMapError("there is no map of uuid %r; known: %s" % (uuid[:80], mesh_map.uuid))
        if labels is None:
            raise MeshMapError(
                "labels are served here for derived meshes of map files only",
                "hdf5_map_server and label_manager have those of others",
            )
        return mesh_map.uuid, labels

    def _get_derived(self, request: Any) -> Any:
        mesh_map = self._map
        if mesh_map is None or request.uuid not in ("", "mesh", mesh_map.uuid):
            raise rospy.ServiceException("there is no map of uuid %r" % request.uuid[:80])
        derived = mesh_map.geometry.derived
        if derived is None:
            return array_services.GetDerivedMeshResponse()
        return array_services.GetDerivedMeshResponse(derived.parent_uuid, derived.face_parents)

    def _edit(self, message: Any) -> None:
        try:
            uuid, labels = self._find(message.uuid)
            count = len(labels.derived.faces)
            findings = validation.mesh_face_cluster(message.cluster, count)
            fault = str(findings[0]) if findings else sent_name_fault(message.cluster.label)
            if fault:
                raise MeshMapError(fault)
            if labels.owner is None:
                raise labels.refusal
            text, override = message.cluster.label, bool(message.override)
            faces = np.array(message.cluster.face_indices, np.uint32)
            faces = labels.edited(text, faces, override)
            # What the owner would refuse without a word is not waited for.
            checked_label(labels.path, text, Label(faces), labels.derived.parent_face_count)
            sent = arrays.MeshFaceClusterStamped.from_message(message)
            sent.cluster = arrays.MeshFaceCluster(faces, text)
            self._forwarder.store(labels.parent, sent, self._topic)
        except (MeshMapError, MapFileError) as error:
            _LOG.warning("%s: refused: %s", self._topic, one_line(str(error)))
            return
        self._look()

    def _run(self) -> None:
        complaint = ""
        while not self._closed.wait(_PERIOD):
            try:
                self._look()
                self._services.publish_wanted()
                complaint = ""
            except Exception as error:  # of the file: it may be gone for a moment
                text = one_line(str(error))
                if text != complaint and not rospy.is_shutdown():
                    _LOG.error("the labels of the map cannot be followed: %s", text)
                complaint = text

    def _look(self) -> None:
        """Tells what has become of labels since the last look."""
        with self._lock:
            mesh_map, labels = self._map, self._labels
            if mesh_map is None or labels is None:
                return
            version = mesh_map.contents.labels_version()
            if version == self._version:
                return
            now = labels.parent.all()
            for text in _changed(self._told, now):
                told = Label(now[text].faces if text in now else np.zeros(0, np.uint32))
                faces = labels.derived.faces_of(told.faces)
                self._services.stored(mesh_map.uuid, labels, cluster(text, Label(faces)))
            self._services.changed(mesh_map.uuid, labels)
            self._told, self._version = now, version


def _changed(before: Dict[str, Label], now: Dict[str, Label]) -> List[str]:
    """The labels that have other faces, or are there no more."""
    found = [text for text in before if text not in now]
    for text, label in now.items():
        known = before.get(text)
        if known is None or not np.array_equal(known.faces, label.faces):
            found.append(text)
    return found
