"""The mesh map on ROS: one map below a namespace, with all that is said about it in the README."""

import contextlib
import logging
import threading
import time
from functools import partial
from typing import Any, Callable, Dict, Mapping, Optional

import numpy as np
import rospy
from mesh_msgs import arrays
from mesh_msgs.diagnostics_ros import ERROR, OK, WARN, Diagnostics, Status
from mesh_msgs_hdf5.files.probe import check_node_path
from mesh_msgs_hdf5.model.errors import MapFileError
from mesh_msgs_hdf5.processes.zygote import prepare
from visualization_msgs.msg import Marker

from mesh_map.base.errors import PLUGIN_FAILURES, MeshMapError, error_line
from mesh_map.base.parameter import Parameter, read_parameters
from mesh_map.costs.combination import COMBINED_COSTS
from mesh_map.costs.layer import Layer
from mesh_map.costs.settings import SETTINGS
from mesh_map.geometry.topology import quantity
from mesh_map.io import map_messages
from mesh_map.io.derived_labels import DerivedLabels
from mesh_map.io.map_parameters import map_parameters
from mesh_map.io.map_source import MapSource
from mesh_map.map.coarse_edges import coarse_remark
from mesh_map.map.mesh_map import MeshMap
from mesh_map.ros.derived_label_server import DerivedLabelServer
from mesh_map.ros.layer_adapters import LayerAdapters
from mesh_map.ros.log import forward_log
from mesh_map.ros.map_services import MapServices
from mesh_map.ros.map_topics import MapTopics
from mesh_map.ros.reconfigure import MAP_PARAMETERS, serve_map

__all__ = ["COMBINED_COSTS", "MeshMapServer", "forward_log"]

COSTS_PERIOD = Parameter(
    "costs_period", 1.0, 0.0, 3600.0, "shortest time between whole messages of a layer (s)"
)
LAYER_TIMEOUT = Parameter(
    "layer_timeout", 60.0, 0.1, 86400.0, "for a call of a layer (s per started million of faces)"
)

_LOCKED_AGAIN = 0.5  # seconds until a file that another program has open is tried once more

_LOG = logging.getLogger("mesh_map")


class MeshMapServer:
    """Loads a map as the parameters below a namespace say, and publishes it there.

    All names are below the namespace, so the map of the node move_base_flex with the default
    namespace is published on /move_base_flex/mesh_map/mesh.
    """

    def __init__(
        self, namespace: str = "~mesh_map", radii: Optional[Mapping[str, float]] = None
    ) -> None:
        """Advertises topics and services; load() fills them.

        Args:
            namespace: of parameters, topics and services, such as "~mesh_map", or "~" for those of
                the node itself.
            radii: what it is of -> meters: of the robot, for which edges of the mesh may be too
                long, see coarse_remark(); those of layers are known.
        """
        self._radii = dict(radii or {})
        forward_log()
        prepare()
        own = namespace in ("", "~")
        self.namespace = rospy.get_name() if own else rospy.resolve_name(namespace)
        self._lock = threading.RLock()
        self._map: Optional[MeshMap] = None
        self._source: Optional[MapSource] = None
        self._why_not = "no map is loaded"
        self._doing = ""  # while a map is being loaded
        self._done = ""  # when it was
        self._remark = ""  # what users may do better
        self._ended = False
        self._in_use = contextlib.ExitStack()  # what works for the map
        self._topics = MapTopics(self.namespace)
        self._services = MapServices(self)
        self._derived_labels: Optional[DerivedLabelServer] = None
        self._diagnostics = Diagnostics("map", self._status, self._tell)

    @property
    def map(self) -> MeshMap:
        """The map.

        Raises:
            MeshMapError: before load() has succeeded.
        """
        if self._map is None:
            raise MeshMapError(self._why_not)
        return self._map

    @property
    def colors(self) -> Optional[np.ndarray]:
        """(V, 3) uint8 of the map; None where there are none."""
        return self._source.vertex_colors if self._source else None

    def load(self) -> MeshMap:
        """Reads the parameters and the file, computes the layers, and publishes everything.

        The geometry is published first, each layer as soon as it is there, and the combination
        last. A layer that cannot be used is logged, and the others go on: `MeshMap.fault` says
        whether the map may be used. After an error, the map before stays.

        Raises:
            MeshMapError: the map cannot be loaded, or ROS or this server is shut down meanwhile;
                one line for users.
        """
        with self._lock:
            self._why_not = self._doing = "the map is being loaded"
            self._done = ""
            try:
                return self._load()
            except PLUGIN_FAILURES as error:
                self._why_not = "there is no map: %s" % error_line(error)
                if not self._is_shut_down():
                    self._topics.publish_progress("failed: %s" % error_line(error))
                raise
            finally:
                self._doing = ""

    def set_cost_limit(self, limit: float) -> None:
        """Says on layer_info which combined costs planners do not enter; NaN for all they do."""
        self._topics.cost_limit = limit
        if self._map is not None:
            self._topics.publish_info()

    def publish_costs(self, type_name: str, costs: np.ndarray, infinity: str = "lethal") -> None:
        """Publishes costs of all vertices, such as the "Potential" of a plan.

        Late subscribers get the last ones of each type.

        Args:
            type_name: what RViz offers in its list of vertex costs.
            costs: (V,) numbers.
            infinity: what +inf means, as LayerInfo has it.
        Raises:
            MeshMapError: a wrong number of costs, or no map.
        """
        costs = _checked(costs, (len(self.map.vertices),), type_name)
        self._topics.publish_costs(type_name, costs, infinity)

    def publish_vector_field(
        self, namespace: str, vectors: np.ndarray, values: np.ndarray, of_faces: bool = False
    ) -> None:
        """Publishes directions at the vertices, or in the middle of the faces, as a marker.

        Args:
            namespace: of the marker, under which RViz lists it; a later one replaces it.
            vectors: (V, 3), of length 1 or zero, such as those of a plan; of faces (F, 3).
            values: (V,), by which lines are colored; the mean of its corners colors that of a face.
        Raises:
            MeshMapError: a wrong number of vectors or values, or no map.
        """
        vertices, faces = self.map.vertices, self.map.faces if of_faces else None
        rows, of = (vertices, "vertices") if faces is None else (faces, "faces")
        vectors = _checked(vectors, (len(rows), 3), namespace, of)
        values = _checked(values, (len(vertices),), namespace)
        self._topics.publish_vectors(namespace, vectors, values, faces)

    def remove_vectors(self, namespace: str) -> None:
        """Takes the vectors of a namespace away, if any were published.

        Raises:
            MeshMapError: no map.
        """
        if self.map is not None:
            self._topics.remove_vectors(namespace)

    def publish_marker(self, namespace: str, make_marker: Callable[[], Marker]) -> None:
        """Publishes a marker for debugging.

        Args:
            namespace: of the marker; a later one replaces it.
            make_marker: gives it; not called where nobody looks.
        """
        self._topics.markers.send(namespace, make_marker)

    def all_costs(self) -> Dict[str, np.ndarray]:
        """Name -> (V,): of the layers, their combination, and others that were published.

        Raises:
            MeshMapError: no map.
        """
        mesh_map = self.map
        known = {name: layer.result.costs for name, layer in mesh_map.layers.items()}
        known[COMBINED_COSTS] = mesh_map.planning_costs().costs
        if self._topics.map is mesh_map:  # not while another one is being loaded
            others = dict(self._topics.costs)
            known.update((name, others[name]) for name in others if name not in known)
        return known

    def save(self) -> str:
        """Stores the layers in the map file; says what was done, and which are not stored, and why.

        Where the labels of a derived mesh are edited here, who owns them stores them, too.

        Raises:
            MeshMapError: no map, no map file, one that cannot be written, another map since, or no
                layer that can be stored (and no labels).
        """
        with self._lock:
            mesh_map, source, served = self.map, self._source, self._derived_labels
        labels = served.save() if served is not None else ""
        if labels:
            labels = "labels: " + labels
        layers, errors = mesh_map.layers_to_store()
        left_out = ", ".join("%s: %s" % error for error in errors.items())
        if errors and not layers:
            raise MeshMapError("no layer can be stored: " + left_out)
        if labels and not any(layer.STORABLE for layer in layers.values()):
            return labels
        with self._lock:
            if self._map is not mesh_map:
                raise MeshMapError("the map has been replaced meanwhile", "save it again")
            names = source.save_layers(layers)  # may take seconds
        message = "stored in %s: %s" % (source.path, ", ".join(names))
        if left_out:
            message += "; not stored: " + left_out
        if labels:
            message += "; " + labels
        _LOG.info("%s", message)
        return message

    def shutdown(self) -> None:
        """Ends topics, services and what layers do on ROS; waits for load() to give up."""
        self._ended = True
        self._diagnostics.shutdown()
        with self._lock:
            self._in_use.close()
            if self._derived_labels is not None:
                self._derived_labels.shutdown()
            self._services.shutdown()
            self._topics.shutdown()

    def _load(self) -> MeshMap:
        self._stop_at_shutdown()
        given = rospy.get_param(self.namespace, {})
        parameters = map_parameters(given)
        values, complaints = read_parameters((*MAP_PARAMETERS, COSTS_PERIOD, LAYER_TIMEOUT), given)
        for complaint in complaints:
            _LOG.warning("%s", complaint)
        start = time.monotonic()
        self._say("reading %s" % parameters.mesh_file)
        try:
            check_node_path(parameters.mesh_file)
        except MapFileError as error:
            raise MeshMapError(str(error)) from error
        source = self._read(parameters.mesh_file, parameters.mesh_part, parameters.origin)
        source.require_provenance = parameters.require_provenance
        self._stop_at_shutdown()
        mesh_map = source.make_map(parameters.global_frame, **parameters.geometry)
        mesh_map.layer_timeout = values[LAYER_TIMEOUT.name]
        mesh_map.set_settings(**{p.name: values[p.name] for p in SETTINGS})
        self._in_use.close()
        self._topics.begin(mesh_map, source.vertex_colors, values[COSTS_PERIOD.name])
        self._serve_labels(mesh_map, source)

        def publish_layer(layer: Layer) -> None:
            self._topics.publish_costs(layer.name, layer.result.costs)

        mesh_map.compute_layers(
            parameters.layers,
            self._progress,
            source.stored_costs,
            publish_layer,
            source.costs_on_trust,
        )
        if not (mesh_map.layers or mesh_map.layer_errors):
            _LOG.warning("the map has no layers: every vertex is free")
        self._topics.publish_costs(COMBINED_COSTS, mesh_map.planning_costs().costs)
        self._topics.publish_info()
        self._topics.publish_layer_vectors(mesh_map.layers.values())
        self._map, self._source = mesh_map, source
        for name in mesh_map.contents.face_attribute_names():
            self._topics.face_costs.send(name, partial(_face_costs_message, mesh_map, name))

        def publish_changes(changes: Any) -> None:
            self._topics.publish_changes(mesh_map, changes)
            adapters.start()  # of layers that were left out

        adapters = LayerAdapters(self.namespace, mesh_map, self._in_use)
        adapters.start()
        mesh_map.add_listener(publish_changes)
        self._in_use.callback(lambda: mesh_map.remove_listener(publish_changes))
        serve_map(self.namespace, mesh_map, values, self._in_use, self._topics.publish_info)
        text = "map %s with %s is ready after %.2f s" % (
            mesh_map.uuid,
            quantity(len(mesh_map.layers), "layers"),
            time.monotonic() - start,
        )
        self._done = text
        self._topics.publish_progress(_progress(text, mesh_map.fault))
        _LOG.info("%s", text)
        _LOG.info("%s: %s", parameters.mesh_file, mesh_map.report())
        self._remark = coarse_remark(mesh_map, self._radii)
        self._topics.publish_remark(self._remark)
        if self._remark:
            _LOG.warning("%s", self._remark)
        return mesh_map

    def _read(self, path: str, *options: Any) -> MapSource:
        """What MapSource reads; the first map is waited for while another program has the file open
        to write, which is said once."""
        said = False
        while True:
            try:
                return MapSource(path, *options)
            except MeshMapError as error:
                cause = error.__cause__
                locked = isinstance(cause, MapFileError) and cause.code == "locked"
                if not locked or self._map is not None:
                    raise
                if not said:
                    _LOG.warning("%s; the map is loaded as soon as that is done", error)
                    self._say("waiting: %s" % error)
                    said = True
            time.sleep(_LOCKED_AGAIN)
            self._stop_at_shutdown()

    def _serve_labels(self, mesh_map: MeshMap, source: MapSource) -> None:
        """Labels of a derived mesh are served here: who owns them knows the parent only."""
        labels = None
        if mesh_map.geometry.derived is not None and source.is_map_file:
            try:
                store = mesh_map.contents.parent.label_store()
                labels = DerivedLabels(store, mesh_map.geometry.derived)
            except MapFileError as error:
                _LOG.warning("the labels of the map are not served: %s", error)
        if self._derived_labels is not None:
            self._derived_labels.serve(mesh_map, labels)
        elif labels is not None:
            prefix = self.namespace.rstrip("/") + "/"
            self._derived_labels = DerivedLabelServer(prefix, mesh_map, labels)

    def _is_shut_down(self) -> bool:
        return self._ended or rospy.is_shutdown()

    def _stop_at_shutdown(self) -> None:
        if self._is_shut_down():
            raise MeshMapError("the node is shut down")

    def _progress(self, share: float, what: str) -> None:
        self._stop_at_shutdown()
        self._say("%.0f %%: %s" % (100 * share, what))

    def _say(self, doing: str) -> None:
        self._doing = doing
        self._topics.publish_progress(doing)

    def _status(self) -> Status:
        """For /diagnostics; waits for nothing."""
        mesh_map, source, doing, done = self._map, self._source, self._doing, self._done
        if doing:
            return Status(WARN, "the map is being loaded: " + doing)
        if mesh_map is None or source is None or not done:
            return Status(ERROR, self._why_not)
        failures, stale = mesh_map.layer_failures, mesh_map.stale_layers
        values = {"file": source.path, "uuid": mesh_map.uuid, "faces": len(mesh_map.faces)}
        if self._remark:
            values["remark"] = self._remark
        for name, layer in mesh_map.layers.items():
            enabled = layer.params["enabled"]
            stands = "stands, but its inputs are newer" if name in stale else "stands"
            values["layer " + name] = failures.get(name, stands if enabled else "not enabled")
        for name, reason in failures.items():
            values.setdefault("layer " + name, reason)
        if mesh_map.fault:
            return Status(ERROR, mesh_map.fault, values)
        if failures:
            left_out = ", ".join("%s: %s" % failure for failure in failures.items())
            return Status(WARN, "layers that are not required do not stand: " + left_out, values)
        return Status(OK, done, values)

    def _tell(self, status: Status) -> None:
        """On the topic progress: what has happened to the map that is loaded."""
        mesh_map, done = self._map, self._done
        if mesh_map is not None and done and not self._is_shut_down():
            self._topics.publish_progress(_progress(done, mesh_map.fault))


def _progress(done: str, fault: str) -> str:
    return "failed: %s; the rest of the map is shown" % fault if fault else "ready: " + done


def _checked(values: Any, shape: Any, what: str, of: str = "vertices") -> np.ndarray:
    """A copy as float32, of one row for each of some things."""
    array = np.array(values, np.float32)
    if array.shape != shape:
        kind = "costs" if len(shape) == 1 else "vectors"
        raise MeshMapError("%s has %s %s for %d %s" % (what, array.shape, kind, shape[0], of))
    return array


def _face_costs_message(mesh_map: MeshMap, name: str) -> Optional[arrays.MeshFaceCostsStamped]:
    """Of a face attribute that is a cost (one float32 for each face); None for others."""
    costs = mesh_map.contents.face_attribute(name)
    count = len(mesh_map.faces)
    is_cost = costs.dtype == np.float32 and costs.shape in ((count,), (count, 1))
    return map_messages.face_costs_message(mesh_map, name, costs.reshape(-1)) if is_cost else None
