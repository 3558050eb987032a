"""The topics on which hdf5_map_server publishes."""
import threading
from typing import Any, Callable, Hashable, List

import rospy
from mesh_msgs import arrays
from mesh_msgs.msg import MeshFaceCluster, MeshFeatures
from mesh_msgs.ros import LatchedTopics

from mesh_msgs.text import one_line
from mesh_msgs_hdf5.model.errors import MapFileError
from mesh_msgs_hdf5.ros.label_colors_ros import LabelColorServices
from mesh_msgs_hdf5.server.served_map import ServedMap


class MapServerTopics:
    """Latched for each map and each of its layers: a late subscriber gets every one."""

    def __init__(self, label_colors: LabelColorServices) -> None:
        self._geometry = LatchedTopics("mesh/geometry", arrays.MeshGeometryStamped)
        self._colors = LatchedTopics("mesh/vertex_colors", arrays.MeshVertexColorsStamped)
        self._vertex_costs = LatchedTopics("mesh/vertex_costs", arrays.MeshVertexCostsStamped)
        self._face_costs = LatchedTopics("mesh/face_costs", arrays.MeshFaceCostsStamped)
        self._features = LatchedTopics("mesh/features", MeshFeatures)
        self._labels = rospy.Publisher("new_cluster_label", MeshFaceCluster, queue_size=10)
        self._label_colors = label_colors
        self._publishing = threading.Lock()
        # maps whose features nobody has asked for yet: they are not read before
        self._featureless: List[ServedMap] = []

    def publish_map(self, served: ServedMap) -> None:
        """Everything that is published at the start; what cannot be read is a log line."""
        messages, overlay = served.messages, served.overlay
        self._publish(served, "geometry", self._geometry, None, messages.geometry)
        if overlay.has_colors:
            self._publish(served, "vertex colors", self._colors, None, messages.vertex_colors)
        for name in overlay.layer_names():
            self._publish_layer(served, name)
        for name in overlay.face_attribute_names():
            self._publish_face_costs(served, name)
        self._featureless.append(served)
        self._label_colors.changed(served.uuid, served.labels)

    def forget_map(self, served: ServedMap) -> None:
        """Nothing of it is sent to later subscribers."""
        with self._publishing:
            for topics in (
                self._geometry,
                self._colors,
                self._vertex_costs,
                self._face_costs,
                self._features,
            ):
                for uuid, key in topics.keys():
                    if uuid == served.uuid:
                        topics.remove((uuid, key))
        self._featureless = [waiting for waiting in self._featureless if waiting is not served]
        self._label_colors.forget(served.uuid)

    def publish_change(self, served: ServedMap, member: str, key: Any) -> None:
        """What a received message has changed (see Received)."""
        if member == "vertex_colors":
            make = served.messages.vertex_colors
            self._publish(served, "vertex colors", self._colors, None, make)
        elif member == "vertex_costs":
            self._publish_layer(served, key)
        elif member == "face_attributes":
            self._publish_face_costs(served, key)
        elif member == "features" and served not in self._featureless:
            self._publish_features(served)

    def publish_wanted(self) -> None:
        """The features and the colors of labels, if somebody has subscribed to them meanwhile."""
        self._label_colors.publish_wanted()
        if self._featureless and self._features.get_num_connections():
            waiting, self._featureless = self._featureless, []
            for served in waiting:
                self._publish_features(served)

    def publish_label(self, served: ServedMap, cluster: arrays.MeshFaceCluster) -> None:
        """A label that has been stored; without faces if it has been deleted."""
        self._labels.publish(cluster)
        self._label_colors.changed(served.uuid, served.labels)

    def _publish_layer(self, served, name):
        make = served.messages.vertex_costs
        self._publish(served, "layer " + name, self._vertex_costs, name, lambda: make(name))

    def _publish_face_costs(self, served, name):
        make = served.messages.face_costs
        what = "face attribute " + name
        self._publish(served, what, self._face_costs, name, lambda: make(name))

    def _publish_features(self, served):
        make = served.messages.features
        self._publish(served, "features", self._features, None, make)

    def _publish(
        self,
        served: ServedMap,
        what: str,
        topics: LatchedTopics,
        key: Hashable,
        make: Callable[[], Any],
    ) -> None:
        try:
            with self._publishing:  # of two changes at the same time, the last one is kept
                message = make()
                if message is None:  # the map has none (any more)
                    topics.remove((served.uuid, key))
                else:
                    topics.publish((served.uuid, key), message)
        except (MapFileError, MemoryError) as error:
            text = "%s: its %s cannot be published: %s" % (served.name, what, error)
            rospy.logerr("%s", one_line(text))
