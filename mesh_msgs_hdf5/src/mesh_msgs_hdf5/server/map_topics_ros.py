"""The topics on which hdf5_map_server publishes."""
import threading
from typing import Hashable, List, Optional, Tuple

import rospy
from mesh_msgs import arrays
from mesh_msgs.msg import LayerInfoArray, MeshFeatures
from mesh_msgs.ros import LatchedTopics

from mesh_msgs.text import one_line
from mesh_msgs_hdf5.model.errors import MapFileError
from mesh_msgs_hdf5.ros.label_services_ros import LabelServices
from mesh_msgs_hdf5.server.origin_frame_ros import OriginFrames
from mesh_msgs_hdf5.server.served_map import ServedMap

# member of a map -> (name of its topic, and of its message in MapMessages; type; name in the log)
_MEMBERS = {
    "geometry": ("geometry", arrays.MeshGeometryStamped, "geometry"),
    "vertex_colors": ("vertex_colors", arrays.MeshVertexColorsStamped, "vertex colors"),
    "vertex_costs": ("vertex_costs", arrays.MeshVertexCostsStamped, "layer"),
    "face_attributes": ("face_costs", arrays.MeshFaceCostsStamped, "face attribute"),
    "features": ("features", MeshFeatures, "features"),
    "layer_info": ("layer_info", LayerInfoArray, "layer info"),
}


class MapServerTopics:
    """Latched for each map and each of its layers: a late subscriber gets every one."""

    def __init__(self, labels: LabelServices, origins: Optional[OriginFrames] = None) -> None:
        self._topics = {
            member: LatchedTopics("mesh/" + name, kind)
            for member, (name, kind, _) in _MEMBERS.items()
        }
        self._labels = labels
        self._origins = origins or OriginFrames()
        self._publishing = threading.Lock()
        # maps whose features nobody has asked for yet: they are not read before
        self._featureless: List[ServedMap] = []

    def publish_map(self, served: ServedMap) -> None:
        """Everything that is published at the start, in the place of what was before; what cannot
        be read is a log line, and where nothing can be, what was published stays."""
        try:
            members = _members(served)
        except MapFileError as error:  # It has just been replaced.
            rospy.logerr("%s", one_line("%s cannot be published: %s" % (served.name, error)))
            return
        self.forget_map(served)
        for member, key in members:
            self._publish(served, member, key)
        self._featureless.append(served)
        self._labels.changed(served.uuid, served.labels)
        self._origins.publish(served)

    def forget_map(self, served: ServedMap) -> None:
        """Nothing of it is sent to later subscribers."""
        with self._publishing:
            for topics in self._topics.values():
                for uuid, key in topics.keys():
                    if uuid == served.uuid:
                        topics.remove((uuid, key))
        self._featureless = [waiting for waiting in self._featureless if waiting is not served]
        self._labels.forget(served.uuid)

    def publish_change(self, served: ServedMap, member: str, key: Hashable) -> None:
        """What a received message has changed (see Received)."""
        waits = member == "features" and served in self._featureless
        if member in _MEMBERS and not waits:
            self._publish(served, member, key)
        if member == "vertex_costs" and _means_something_else(served, str(key)):
            self._publish(served, "layer_info")

    def publish_wanted(self) -> None:
        """The features and the colors of labels, if somebody has subscribed to them meanwhile."""
        self._labels.publish_wanted()
        if self._featureless and self._topics["features"].get_num_connections():
            waiting, self._featureless = self._featureless, []
            for served in waiting:
                self._publish(served, "features")

    def _publish(self, served: ServedMap, member: str, key: Hashable = None) -> None:
        """key: the name of a layer or face attribute."""
        name, _, what = _MEMBERS[member]
        make, topics = getattr(served.messages, name), self._topics[member]
        try:
            with self._publishing:  # of two changes at the same time, the last one is kept
                message = make() if key is None else make(key)
                if message is None:  # the map has none (any more)
                    topics.remove((served.uuid, key))
                else:
                    topics.publish((served.uuid, key), message)
        except (MapFileError, MemoryError) as error:
            what = what if key is None else "%s %s" % (what, key)
            text = "%s: its %s cannot be published: %s" % (served.name, what, error)
            rospy.logerr("%s", one_line(text))


def _means_something_else(served: ServedMap, layer: str) -> bool:
    try:
        return served.messages.layer_replaced(layer)
    except (MapFileError, MemoryError):
        return True  # Whoever publishes that says why it cannot be read.


def _members(served: ServedMap) -> List[Tuple[str, Hashable]]:
    """Members and keys of all that is published of a map at the start."""
    overlay = served.overlay
    members: List[Tuple[str, Hashable]] = [("geometry", None)]
    members += [("vertex_colors", None)] * overlay.has_colors
    members += [("vertex_costs", name) for name in overlay.layer_names()]
    members += [("vertex_costs", name) for name in overlay.vertex_attribute_names()]
    members += [("layer_info", None)]
    members += [("face_attributes", name) for name in overlay.face_attribute_names()]
    return members
