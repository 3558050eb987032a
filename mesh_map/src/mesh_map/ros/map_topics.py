"""The topics on which a map is published."""

import math
import threading
import time
from typing import Any, Callable, Dict, Hashable, Iterable, Optional

import numpy as np
import rospy
from mesh_msgs import arrays
from mesh_msgs.msg import LayerInfoArray
from mesh_msgs.ros import LatchedTopics
from std_msgs.msg import String
from visualization_msgs.msg import Marker

from mesh_map.costs.layer import Layer
from mesh_map.costs.layer_changes import different
from mesh_map.io import map_messages
from mesh_map.io.markers import no_marker, vector_field_marker
from mesh_map.map.mesh_map import MeshMap

# The name under which the .rviz files in the field show the repulsive vectors of an inflation.
INFLATION = "inflation"
# Updates that wait for a subscriber that is slow; one that misses some gets the whole layer soon.
_UPDATES_QUEUE = 100


class PacedTopics:
    """Latched messages that change often: the newest is kept, and sent once per period at most."""

    def __init__(self, name: str, data_class: Any) -> None:
        self.period = 1.0  # seconds
        self._topics = LatchedTopics(name, data_class)
        self._due: Dict[Hashable, float] = {}  # of each message that there is
        self._lock = threading.Lock()
        self.unregister = self._topics.unregister

    def send(self, key: Hashable, make_message: Callable[[], Any]) -> None:
        """Sends a message at once, however little time has passed since the one before."""
        self._topics.keep(key, make_message)
        self._topics.send(key)
        with self._lock:
            self._due[key] = time.monotonic()

    def change(self, key: Hashable, make_message: Callable[[], Any]) -> None:
        """Later subscribers get this message; those that are there get it, or a newer one, at once
        if none of this key was sent within the last period, and else when the period is over."""
        self._topics.keep(key, make_message)
        with self._lock:
            now = time.monotonic()
            due = self._due.get(key, now - self.period)
            if due > now:
                return  # it will go with the one that waits
            self._due[key] = due = max(now, due + self.period)
        self._topics.send(key, due - now)

    def __contains__(self, key: Hashable) -> bool:
        return key in self._due

    def clear(self) -> None:
        """Forgets all messages; the next one of each key is sent at once."""
        with self._lock:
            keys, self._due = self._due, {}
        for key in keys:
            self._topics.remove(key)


class MapTopics:
    """Topics below a namespace, see the README. All methods may be called from any thread.

    Messages are made when a subscriber needs them.

    Attributes:
        map: of which the topics tell now; None before begin().
        costs: name -> (V,) what was published last on vertex_costs.
        cost_limit: of planners, for layer_info; NaN for none.
        face_costs, markers: messages by their type and namespace.
    """

    def __init__(self, namespace: str) -> None:
        """Advertises all but vertex_colors, which not every map has."""
        prefix = namespace.rstrip("/") + "/"
        self.costs: Dict[str, np.ndarray] = {}
        self.map: Optional[MeshMap] = None
        self.cost_limit = math.nan
        self._infinities: Dict[str, str] = {}  # of costs beside those of the map
        self._lock = threading.RLock()
        self._vectors: Dict[str, np.ndarray] = {}
        self._colors_name = prefix + "vertex_colors"
        self._colors: Optional[rospy.Publisher] = None
        self._mesh = rospy.Publisher(
            prefix + "mesh", arrays.MeshGeometryStamped, latch=True, queue_size=1
        )
        self._costs = PacedTopics(prefix + "vertex_costs", arrays.MeshVertexCostsStamped)
        self._updates = rospy.Publisher(
            prefix + "vertex_costs/updates",
            arrays.MeshVertexCostsSparseStamped,
            queue_size=_UPDATES_QUEUE,
        )
        self.face_costs = PacedTopics(prefix + "face_costs", arrays.MeshFaceCostsStamped)
        self._info = PacedTopics(prefix + "layer_info", LayerInfoArray)
        self._fields = PacedTopics(prefix + "vector_field", Marker)
        self.markers = PacedTopics(prefix + "marker", Marker)
        self._progress = rospy.Publisher(prefix + "progress", String, latch=True, queue_size=10)
        self._remark = rospy.Publisher(prefix + "remark", String, latch=True, queue_size=1)
        self._paced = (self._costs, self._info, self.face_costs, self._fields, self.markers)

    def begin(self, mesh_map: MeshMap, colors: Optional[np.ndarray], period: float) -> None:
        """Publishes the geometry of a map; what was published of another one is forgotten.

        Args:
            mesh_map: of which the topics tell from now on.
            colors: (V, 3) uint8, None where there are none.
            period: the shortest time between two whole messages of one layer while it changes (s).
        """
        with self._lock:
            for topics in self._paced:
                topics.clear()
                topics.period = period
            self.costs, self._vectors, self.map = {}, {}, mesh_map
            self._infinities = {}
        self._mesh.publish(map_messages.geometry_message(mesh_map))
        if colors is not None:
            if self._colors is None:
                kind = arrays.MeshVertexColorsStamped
                self._colors = rospy.Publisher(self._colors_name, kind, latch=True, queue_size=1)
            self._colors.publish(map_messages.colors_message(mesh_map, colors))
        elif self._colors is not None:  # those of another map
            self._colors.unregister()
            self._colors = None

    def publish_costs(self, name: str, costs: np.ndarray, infinity: str = "lethal") -> None:
        """All costs (V,) of a layer, which must not change any more.

        infinity: what +inf means in them, for costs beside those of the map.
        """
        mesh_map = self.map
        self.costs[name] = costs
        self._costs.send(name, lambda: map_messages.costs_message(mesh_map, name, costs))
        if infinity != "lethal" and self._infinities.get(name) != infinity:
            self._infinities[name] = infinity
            self.publish_info()

    def publish_info(self) -> None:
        """What the costs of the layers mean, and how many are lethal or unknown now."""
        mesh_map, others = self.map, dict(self._infinities)
        if mesh_map is None:
            return  # before a map, and after the end
        self._info.change(
            "", lambda: map_messages.layer_info_message(mesh_map, self.cost_limit, others)
        )

    def publish_changes(self, mesh_map: MeshMap, changes: Iterable[Any]) -> None:
        """mesh_map.LayerChange: at once the differences, and the whole layers when it is time.

        mesh_map: which has changed; nothing is published if another one has been begun meanwhile.
        """
        with self._lock:
            if self.map is not mesh_map:
                return
            for name, vertices, costs in changes:
                self._publish_change(name, vertices, costs)
            self.publish_info()
            self.publish_layer_vectors(mesh_map.layers.values())

    def publish_vectors(
        self,
        namespace: str,
        vectors: np.ndarray,
        values: np.ndarray,
        faces: Optional[np.ndarray] = None,
        paced: bool = False,
    ) -> None:
        """Vectors (V, 3) at the vertices, or (F, 3) in the middle of these faces, with the values
        (V,) that color them; at once, or paced as layers are."""
        mesh_map, stamp = self.map, rospy.Time.now()
        publish = self._fields.change if paced else self._fields.send
        publish(
            namespace,
            lambda: vector_field_marker(
                mesh_map.vertices, vectors, values, mesh_map.frame_id, stamp, namespace, faces
            ),
        )

    def remove_vectors(self, namespace: str) -> None:
        """Takes vectors away, also for later subscribers; nothing happens where there are none."""
        if namespace in self._fields:
            marker = no_marker(namespace, self.map.frame_id, rospy.Time.now())
            self._fields.send(namespace, lambda: marker)

    def publish_layer_vectors(self, layers: Iterable[Layer]) -> None:
        """The vectors of those layers that have any, where they have changed."""
        with self._lock:
            shown = {}
            for layer in layers:
                if layer.result is not None and layer.result.vectors is not None:
                    namespace = "%s/%s" % (INFLATION, layer.name) if shown else INFLATION
                    shown[namespace] = layer.result
            for namespace in [name for name in self._vectors if name not in shown]:
                del self._vectors[namespace]
                marker = no_marker(namespace, self.map.frame_id, rospy.Time.now())
                self._fields.change(namespace, lambda marker=marker: marker)
            for namespace, result in shown.items():
                if self._vectors.get(namespace) is not result.vectors:
                    self._vectors[namespace] = result.vectors
                    self.publish_vectors(namespace, result.vectors, result.costs, paced=True)

    def publish_progress(self, text: str) -> None:
        """What is being done."""
        self._progress.publish(String(data=text))

    def publish_remark(self, text: str) -> None:
        """What users may do better with their map; empty: nothing."""
        self._remark.publish(String(data=text))

    def shutdown(self) -> None:
        """Ends all topics."""
        with self._lock:
            self.map = None  # changes that are just being made find nobody
        for topics in self._paced:
            topics.unregister()
        for publisher in (self._mesh, self._colors, self._updates, self._progress, self._remark):
            if publisher is not None:
                publisher.unregister()

    def _publish_change(self, name: str, vertices: np.ndarray, costs: np.ndarray) -> None:
        before = self.costs.get(name)
        if before is not None:
            vertices = vertices[different(before[vertices], costs[vertices])]
        if not len(vertices):
            return  # other vectors alone
        mesh_map, self.costs[name] = self.map, costs
        if self._updates.get_num_connections():
            message = map_messages.update_message(mesh_map, name, vertices, costs[vertices])
            self._updates.publish(message)
        self._costs.change(name, lambda: map_messages.costs_message(mesh_map, name, costs))
