"""Labels over ROS, as both nodes have them: services, what has been stored, and their colors."""
import threading
from typing import Any, Callable, Dict, List, Optional, Tuple, Type

import rospy
from mesh_msgs import array_services, arrays
from mesh_msgs.msg import MeshFaceCluster, MeshLabelColors
from mesh_msgs.ros import LatchedTopics
from mesh_msgs.srv import (
    GetLabelColors,
    GetLabelColorsResponse,
    GetLabelGroups,
    GetLabelGroupsResponse,
    SetLabelColor,
    SetLabelColorResponse,
)
from std_msgs.msg import ColorRGBA

from mesh_msgs.text import one_line
from mesh_msgs_hdf5.labels.journal_reading import OwnedError
from mesh_msgs_hdf5.model.errors import MapFileError
from mesh_msgs_hdf5.model.mesh import Color, Label
from mesh_msgs_hdf5.ros.label_forwarding_ros import LabelForwarder
from mesh_msgs_hdf5.ros.map_messages import cluster, clusters

# (UUID of the geometry, its labels: LabelStore or what has its interface)
Found = Tuple[str, Any]
_QUEUE = 100


class LabelServices:
    """get_labeled_clusters, get_label_groups, get_labeled_cluster_group, delete_label,
    get_label_colors, set_label_color; new_cluster_label, and label_colors: for each mesh all labels
    with a color.

    The latter is filled when somebody subscribes to it: labels are not read before.
    """

    def __init__(
        self,
        prefix: str,
        find: Callable[[str], Found],
        forwarder: LabelForwarder,
        *refusals: Type[Exception],
    ) -> None:
        """prefix: of the names. find: the labels of a UUID; it raises MapFileError or refusals."""
        self._find = find
        self._forwarder = forwarder
        self._lock = threading.Lock()
        self._publishing = threading.Lock()
        self._stale: Dict[str, Any] = {}
        self._stored = rospy.Publisher(
            prefix + "new_cluster_label", MeshFaceCluster, queue_size=_QUEUE
        )
        self._colors = LatchedTopics(prefix + "label_colors", MeshLabelColors)
        self._services: List[rospy.Service] = [
            rospy.Service(prefix + name, kind, answering(handler, *refusals))
            for name, kind, handler in (
                ("get_labeled_clusters", array_services.GetLabeledClusters, self._get_all),
                ("get_label_groups", GetLabelGroups, self._get_groups),
                ("get_labeled_cluster_group", array_services.GetLabeledClusterGroup, self._get),
                ("delete_label", array_services.DeleteLabel, self._delete),
                ("get_label_colors", GetLabelColors, self._get_colors),
                ("set_label_color", SetLabelColor, self._set_color),
            )
        ]

    def shutdown(self) -> None:
        """Ends topics and services."""
        for service in self._services:
            service.shutdown()
        self._stored.unregister()
        self._colors.unregister()

    def stored(self, uuid: str, labels: Any, changed: arrays.MeshFaceCluster) -> None:
        """A label has been stored; it has no faces if it has been deleted."""
        self._stored.publish(changed)
        self.changed(uuid, labels)

    def changed(self, uuid: str, labels: Any) -> None:
        """There are other labels, or other colors, than before."""
        with self._lock:
            self._stale[uuid] = labels

    def forget(self, uuid: str) -> None:
        """Nothing of this mesh is sent to later subscribers."""
        with self._publishing:
            with self._lock:
                self._stale.pop(uuid, None)
            self._colors.remove((uuid, None))

    def publish_wanted(self) -> None:
        """The colors that have changed, if somebody listens; what cannot be read is a log line."""
        if not self._colors.get_num_connections():
            return
        with self._publishing:  # of two changes at the same time, the last one is kept
            with self._lock:
                stale, self._stale = self._stale, {}
            for uuid, labels in stale.items():
                try:
                    names, colors = label_colors(labels.all())
                except (MapFileError, MemoryError) as error:
                    rospy.logerr("the colors of labels are not published: %s", one_line(str(error)))
                    continue
                message = MeshLabelColors(uuid=uuid, labels=names, colors=colors)
                self._colors.publish((uuid, None), message)

    def _get_all(self, request):
        found = clusters(self._find(request.uuid)[1].all())
        return array_services.GetLabeledClustersResponse(clusters=found)

    def _get_groups(self, request):
        return GetLabelGroupsResponse(labels=self._find(request.uuid)[1].groups())

    def _get(self, request):
        found = clusters(self._find(request.uuid)[1].group(request.labelGroup))
        return array_services.GetLabeledClusterGroupResponse(clusters=found)

    def _delete(self, request):
        uuid, labels = self._find(request.uuid)
        try:
            deleted = cluster(request.label, labels.delete(request.label))
        except OwnedError:
            deleted = self._forwarder.delete(labels, request.label)
        self.stored(uuid, labels, arrays.MeshFaceCluster(label=request.label))
        return array_services.DeleteLabelResponse(cluster=deleted)

    def _get_colors(self, request):
        names, colors = label_colors(self._find(request.uuid)[1].all())
        return GetLabelColorsResponse(labels=names, colors=colors)

    def _set_color(self, request):
        uuid, labels = self._find(request.uuid)
        color = color_of(labels.path, request.label, request.color)
        try:
            labels.set_color(request.label, color)
        except OwnedError:
            self._forwarder.set_color(labels, request.label, request.color)
        self.changed(uuid, labels)
        self.publish_wanted()
        return SetLabelColorResponse()


def label_colors(labels: Dict[str, Label]) -> Tuple[List[str], List[ColorRGBA]]:
    """The labels that have a color of their own, in their order."""
    found = {text: label.color for text, label in labels.items() if label.color is not None}
    colors = [ColorRGBA(*(part / 255.0 for part in color), 1.0) for color in found.values()]
    return list(found), colors


def color_of(path: str, text: str, color: ColorRGBA) -> Optional[Color]:
    """The bytes of a color; None for one of alpha 0. Raises MapFileError (value)."""
    parts = (color.r, color.g, color.b)
    if not all(0.0 <= part <= 1.0 for part in parts + (color.a,)):
        raise MapFileError(
            "value",
            path,
            "the color of label %s is %s, alpha %g" % (one_line(text)[:80], parts, color.a),
            "each channel is from 0 to 1",
        )
    red, green, blue = (int(round(255.0 * part)) for part in parts)
    return (red, green, blue) if color.a else None


def answering(handler: Callable[[Any], Any], *refusals: Type[Exception]) -> Callable[[Any], Any]:
    """A handler of a service whose errors (MapFileError, and these) are the answer."""

    def answer(request: Any) -> Any:
        try:
            return handler(request)
        except (MapFileError, *refusals) as error:
            raise rospy.ServiceException(str(error)) from error
        except MemoryError as error:
            raise rospy.ServiceException("there is not enough memory to answer") from error

    return answer
