"""The mesh map on ROS: parameters, topics and the service of one map below a namespace."""

import logging
import threading
import time
from typing import Any, Optional

import numpy as np
import rospy
from mesh_msgs import arrays
from mesh_msgs.ros import LatchedTopics
from std_msgs.msg import Header
from std_srvs.srv import Trigger, TriggerRequest, TriggerResponse

from mesh_map.errors import MeshMapError, one_line
from mesh_map.map_source import MapSource, map_parameters
from mesh_map.mesh_map import MeshMap
from mesh_map.topology import quantity

COMBINED_COSTS = "Combined Costs"

_LOG = logging.getLogger("mesh_map")


class _ToRosLog(logging.Handler):
    """Passes what the library logs on to rosout."""

    def emit(self, record: logging.LogRecord) -> None:
        text = one_line(record.getMessage())
        if record.levelno >= logging.ERROR:
            rospy.logerr("%s", text)
        elif record.levelno >= logging.WARNING:
            rospy.logwarn("%s", text)
        elif record.levelno >= logging.INFO:
            rospy.loginfo("%s", text)


def forward_log() -> None:
    """Sends the log of the library to rosout, once per process."""
    if not any(isinstance(handler, _ToRosLog) for handler in _LOG.handlers):
        _LOG.addHandler(_ToRosLog())
        _LOG.setLevel(logging.INFO)
        _LOG.propagate = False


def _stop_at_shutdown(*_progress: Any) -> None:
    if rospy.is_shutdown():
        raise MeshMapError("the node is shut down")


class MeshMapServer:
    """Loads a map as the parameters below a namespace say, and publishes it there.

    Parameters, topics and services: see the README of this package. All names are below the
    namespace, so the map of the node move_base_flex with the default namespace is published on
    /move_base_flex/mesh_map/mesh.
    """

    def __init__(self, namespace: str = "~mesh_map") -> None:
        """Advertises topics and services; load() fills them.

        Args:
            namespace: of parameters, topics and services, such as "~mesh_map", or "~" for those of
                the node itself.
        """
        forward_log()
        own = namespace in ("", "~")
        self.namespace = rospy.get_name() if own else rospy.resolve_name(namespace)
        self._lock = threading.RLock()
        self._map: Optional[MeshMap] = None
        self._source: Optional[MapSource] = None
        self._mesh_topic = rospy.Publisher(
            self._name("mesh"), arrays.MeshGeometryStamped, latch=True, queue_size=1
        )
        self._colors_topic: Optional[rospy.Publisher] = None
        self._costs_topic = LatchedTopics(self._name("vertex_costs"), arrays.MeshVertexCostsStamped)
        self._save_service = rospy.Service(self._name("save_map"), Trigger, self._save_map)

    @property
    def map(self) -> MeshMap:
        """The map.

        Raises:
            MeshMapError: before load() has succeeded.
        """
        if self._map is None:
            raise MeshMapError("no map is loaded")
        return self._map

    def load(self) -> MeshMap:
        """Reads the parameters and the file, computes the layers, and publishes everything.

        A layer that cannot be used is logged, and the others go on. After an error, the map before
        stays.

        Raises:
            MeshMapError: the map cannot be loaded, or ROS is shut down meanwhile; one line for
                users.
        """
        with self._lock:
            parameters = map_parameters(rospy.get_param(self.namespace, {}))
            start = time.monotonic()
            source = MapSource(parameters.mesh_file, parameters.mesh_part)
            _stop_at_shutdown()
            mesh_map = source.make_map(parameters.global_frame)
            _LOG.info("%s: %s", parameters.mesh_file, mesh_map.report())
            mesh_map.compute_layers(parameters.layers, _stop_at_shutdown, source.stored_costs)
            if not mesh_map.layers:
                _LOG.warning("the map has no layers: every vertex is free")
            for old in list(self._costs_topic.keys()):
                self._costs_topic.remove(old)
            self._map, self._source = mesh_map, source
            self._publish_all()
            _LOG.info(
                "map %s with %s is ready after %.2f s",
                mesh_map.uuid,
                quantity(len(mesh_map.layers), "layers"),
                time.monotonic() - start,
            )
            return mesh_map

    def publish_costs(self, type_name: str, costs: np.ndarray) -> None:
        """Publishes costs of all vertices, such as the "Potential" of a plan.

        Late subscribers get the last ones of each type.

        Args:
            type_name: what RViz offers in its list of vertex costs.
            costs: (V,) numbers.
        Raises:
            MeshMapError: a wrong number of costs, or no map.
        """
        mesh_map = self.map
        costs = np.asarray(costs, np.float32)
        if costs.shape != (len(mesh_map.vertices),):
            raise MeshMapError(
                "%s has %s costs for %d vertices" % (type_name, costs.shape, len(mesh_map.vertices))
            )
        message = arrays.MeshVertexCostsStamped(
            header=self._header(),
            uuid=mesh_map.uuid,
            type=type_name,
            mesh_vertex_costs=arrays.MeshVertexCosts(costs=costs),
        )
        self._costs_topic.publish(type_name, message)

    def shutdown(self) -> None:
        """Ends topics and services."""
        self._save_service.shutdown()
        self._costs_topic.unregister()
        self._mesh_topic.unregister()
        if self._colors_topic is not None:
            self._colors_topic.unregister()

    def _name(self, name: str) -> str:
        return self.namespace.rstrip("/") + "/" + name

    def _header(self) -> Header:
        # A map does not age: with the stamp 0, transforms are looked up as they are now.
        return Header(frame_id=self.map.frame_id)

    def _publish_all(self) -> None:
        self._mesh_topic.publish(
            arrays.MeshGeometryStamped(
                header=self._header(),
                uuid=self.map.uuid,
                mesh_geometry=arrays.MeshGeometry(
                    vertices=self.map.vertices,
                    vertex_normals=self.map.vertex_normals,
                    faces=self.map.faces,
                ),
            )
        )
        for name, layer in self.map.layers.items():
            self.publish_costs(name, layer.result.costs)
        self.publish_costs(COMBINED_COSTS, self.map.costs)
        self._publish_colors(self._source.mesh.vertex_colors)

    def _publish_colors(self, colors: Optional[np.ndarray]) -> None:
        if colors is None:
            if self._colors_topic is not None:  # those of another map
                self._colors_topic.unregister()
                self._colors_topic = None
            return
        if self._colors_topic is None:
            self._colors_topic = rospy.Publisher(
                self._name("vertex_colors"),
                arrays.MeshVertexColorsStamped,
                latch=True,
                queue_size=1,
            )
        rgba = np.ones((len(colors), 4), np.float32)
        rgba[:, :3] = colors[:, :3] / np.float32(255)
        self._colors_topic.publish(
            arrays.MeshVertexColorsStamped(
                header=self._header(),
                uuid=self.map.uuid,
                mesh_vertex_colors=arrays.MeshVertexColors(vertex_colors=rgba),
            )
        )

    def _save_map(self, _request: TriggerRequest) -> Any:
        try:
            with self._lock:
                names = self._source.save_layers(self.map.layers) if self._source else []
            if not names:
                raise MeshMapError("no map is loaded")
        except MeshMapError as error:
            _LOG.error("save_map: %s", error)
            return TriggerResponse(success=False, message=str(error))
        message = "stored in %s: %s" % (self._source.path, ", ".join(names))
        _LOG.info("%s", message)
        return TriggerResponse(success=True, message=message)
