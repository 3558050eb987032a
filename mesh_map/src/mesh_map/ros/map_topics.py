"""The topics on which a map is published."""

import threading
import time
from typing import Any, Callable, Dict, Hashable, Iterable, Optional

import numpy as np
import rospy
from mesh_msgs import arrays
from mesh_msgs.ros import LatchedTopics
from std_msgs.msg import String
from visualization_msgs.msg import Marker

from mesh_map.costs.layer import Layer
from mesh_map.costs.layer_changes import different
from mesh_map.io import map_messages
from mesh_map.io.markers import face_vectors_marker, no_marker, vector_field_marker
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
        self._due: Dict[Hashable, float] = {}
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

    def remove(self, key: Hashable) -> None:
        """Forgets a message; the next one of this key is sent at once."""
        self._topics.remove(key)
        with self._lock:
            self._due.pop(key, None)


class MapTopics:
    """Topics below a namespace, see the README. All methods may be called from any thread.

    Messages are made when a subscriber needs them.

    Attributes:
        map: of which the topics tell now; None before begin().
        costs: name -> (V,) what was published last on vertex_costs.
    """

    def __init__(self, namespace: str) -> None:
        """Advertises all but vertex_colors, which not every map has."""
        prefix = namespace.rstrip("/") + "/"
        self.costs: Dict[str, np.ndarray] = {}
        self.map: Optional[MeshMap] = None
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
        self._face_costs = PacedTopics(prefix + "face_costs", arrays.MeshFaceCostsStamped)
        self._fields = PacedTopics(prefix + "vector_field", Marker)
        self._markers = PacedTopics(prefix + "marker", Marker)
        self._progress = rospy.Publisher(prefix + "progress", String, latch=True, queue_size=10)
        self._paced = (self._costs, self._face_costs, self._fields, self._markers)
        self._sent: Dict[PacedTopics, Dict[str, None]] = {topics: {} for topics in self._paced}

    def set_period(self, seconds: float) -> None:
        """The shortest time between two whole messages of one layer while it changes."""
        for topics in self._paced:
            topics.period = seconds

    def begin(self, mesh_map: MeshMap, colors: Optional[np.ndarray]) -> None:
        """Publishes the geometry of a map; what was published of another one is forgotten.

        colors: (V, 3) uint8, None where there are none.
        """
        with self._lock:
            for topics, keys in self._sent.items():
                for key in list(keys):
                    topics.remove(key)
                keys.clear()
            self.costs, self._vectors, self.map = {}, {}, mesh_map
        self._mesh.publish(map_messages.geometry_message(mesh_map))
        if colors is not None:
            if self._colors is None:
                kind = arrays.MeshVertexColorsStamped
                self._colors = rospy.Publisher(self._colors_name, kind, latch=True, queue_size=1)
            self._colors.publish(map_messages.colors_message(mesh_map, colors))
        elif self._colors is not None:  # those of another map
            self._colors.unregister()
            self._colors = None

    def publish_costs(self, name: str, costs: np.ndarray) -> None:
        """All costs (V,) of a layer, which must not change any more."""
        mesh_map = self.map
        self.costs[name] = costs
        self._send(self._costs, name, lambda: map_messages.costs_message(mesh_map, name, costs))

    def publish_changes(self, mesh_map: MeshMap, changes: Iterable[Any]) -> None:
        """mesh_map.LayerChange: at once the differences, and the whole layers when it is time.

        mesh_map: which has changed; nothing is published if another one has been begun meanwhile.
        """
        with self._lock:
            if self.map is not mesh_map:
                return
            for name, vertices, costs in changes:
                self._publish_change(name, vertices, costs)
            self.publish_layer_vectors(mesh_map.layers.values())

    def publish_face_costs(self, name: str, read_costs: Callable[[], Optional[np.ndarray]]) -> None:
        """Costs of all faces.

        read_costs: gives them, (F,) float32, or None for none, when a subscriber comes.
        """
        mesh_map = self.map

        def make() -> Optional[arrays.MeshFaceCostsStamped]:
            costs = read_costs()
            return None if costs is None else map_messages.face_costs_message(mesh_map, name, costs)

        self._send(self._face_costs, name, make)

    def publish_vectors(self, namespace: str, vectors: np.ndarray, values: np.ndarray) -> None:
        """Vectors (V, 3) at the vertices, with the values (V,) that color them."""
        self._send(self._fields, namespace, self._field_maker(namespace, vectors, values))

    def publish_face_vectors(self, namespace: str, vectors: np.ndarray, values: np.ndarray) -> None:
        """Vectors (F, 3) in the middle of the faces; values (V,) at the vertices color them."""
        mesh_map, stamp = self.map, rospy.Time.now()
        self._send(
            self._fields,
            namespace,
            lambda: face_vectors_marker(
                mesh_map.vertices,
                mesh_map.faces,
                vectors,
                values,
                mesh_map.frame_id,
                stamp,
                namespace,
            ),
        )

    def remove_vectors(self, namespace: str) -> None:
        """Takes vectors away, also for later subscribers; nothing happens where there are none."""
        if namespace in self._sent[self._fields]:
            frame_id, stamp = self.map.frame_id, rospy.Time.now()
            self._send(self._fields, namespace, lambda: no_marker(namespace, frame_id, stamp))

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
                frame_id = self.map.frame_id
                marker = no_marker(namespace, frame_id, rospy.Time.now())
                self._fields.change(namespace, lambda marker=marker: marker)
            for namespace, result in shown.items():
                if self._vectors.get(namespace) is not result.vectors:
                    self._vectors[namespace] = result.vectors
                    self._sent[self._fields][namespace] = None
                    maker = self._field_maker(namespace, result.vectors, result.costs)
                    self._fields.change(namespace, maker)

    def publish_marker(self, namespace: str, make_marker: Callable[[], Marker]) -> None:
        """A marker for debugging, made when a subscriber comes."""
        self._send(self._markers, namespace, make_marker)

    def publish_progress(self, text: str) -> None:
        """What is being done."""
        self._progress.publish(String(data=text))

    def shutdown(self) -> None:
        """Ends all topics."""
        with self._lock:
            self.map = None  # changes that are just being made find nobody
        for topics in self._paced:
            topics.unregister()
        for publisher in (self._mesh, self._colors, self._updates, self._progress):
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
        self._sent[self._costs][name] = None
        self._costs.change(name, lambda: map_messages.costs_message(mesh_map, name, costs))

    def _send(self, topics: PacedTopics, key: str, make_message: Callable[[], Any]) -> None:
        self._sent[topics][key] = None
        topics.send(key, make_message)

    def _field_maker(
        self, namespace: str, vectors: np.ndarray, values: np.ndarray
    ) -> Callable[[], Marker]:
        mesh_map, stamp = self.map, rospy.Time.now()
        return lambda: vector_field_marker(
            mesh_map.vertices, vectors, values, mesh_map.frame_id, stamp, namespace
        )
