"""The mesh map: one geometry and the cost layers on it."""

import logging
import re
import threading
import time
from functools import cached_property
from typing import Any, Callable, Dict, Mapping, Optional, Tuple

import numpy as np
from mesh_msgs.identity import geometry_uuid
from mesh_msgs.validation import check_geometry

from mesh_map import _kernels
from mesh_map.array_checks import as_faces, as_vertices, read_only
from mesh_map.combination import combine
from mesh_map.errors import MeshMapError, one_line
from mesh_map.hits import NO_FACE, SurfacePoint
from mesh_map.layer import BASE_CLASS_TYPE, Layer, LayerResult, checked_result
from mesh_map.normals import face_normals, vertex_normals
from mesh_map.plugins import find_class
from mesh_map.query_arguments import checked_distance
from mesh_map.spatial_index import SpatialIndex
from mesh_map.topology import Topology, quantity

_LOG = logging.getLogger("mesh_map")
_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]*")

Progress = Callable[[float, str], None]
StoredCosts = Callable[[Layer], Optional[np.ndarray]]


class MeshMap:
    """A triangle mesh with cost layers.

    Any triangle soup will do: nothing is repaired, all oddities are counted. What follows from the
    geometry is computed when it is first asked for. All arrays are read-only.

    Attributes:
        vertices: (V, 3) float32, meters in frame_id.
        faces: (F, 3) uint32.
        frame_id: coordinate frame.
        layers: name -> Layer, in the order of evaluation; only those that have a result.
        layer_errors: name -> one line, for the layers of the last compute_layers() that could not
            be used.
        costs: (V,) float32, all layers combined: >= 0, +inf lethal, NaN unknown; zeros without
            layers.
    """

    def __init__(
        self,
        vertices: Any,
        faces: Any,
        vertex_normals: Optional[Any] = None,
        frame_id: str = "map",
        uuid: str = "",
    ) -> None:
        """Checks the geometry.

        Args:
            vertices: (V, 3) finite numbers.
            faces: (F, 3) vertex indices; at least one face.
            vertex_normals: (V, 3) finite numbers; None to compute them.
            frame_id: coordinate frame.
            uuid: identity that the geometry already has; "" for that of its content.
        Raises:
            MeshMapError: what is wrong with it.
        """
        if vertex_normals is not None and not len(vertex_normals):
            vertex_normals = None
        findings = check_geometry(vertices, faces, vertex_normals)
        if findings:
            more = " (and %d more faults)" % (len(findings) - 1) if len(findings) > 1 else ""
            raise MeshMapError("no usable mesh: %s%s" % (findings[0], more))
        self.vertices = read_only(as_vertices(vertices))
        self.faces = read_only(as_faces(faces))
        self.frame_id = frame_id
        self._uuid = uuid
        self._index: Optional[SpatialIndex] = None
        self._index_lock = threading.Lock()
        if vertex_normals is not None:
            self.__dict__["vertex_normals"] = read_only(as_vertices(vertex_normals))
        self.layers: Dict[str, Layer] = {}
        self.layer_errors: Dict[str, str] = {}
        self.costs = read_only(np.zeros(len(self.vertices), np.float32))

    @cached_property
    def topology(self) -> Topology:
        """What is next to what."""
        return Topology(faces=self.faces, vertex_count=len(self.vertices))

    @cached_property
    def uuid(self) -> str:
        """Identity: the one that was given, or the version 5 UUID of vertices and faces."""
        return self._uuid or geometry_uuid(self.vertices, self.faces)

    @cached_property
    def _face_normals(self) -> Tuple[np.ndarray, np.ndarray]:
        return face_normals(self.vertices, self.faces)

    @property
    def face_normals(self) -> np.ndarray:
        """(F, 3) float32 of length 1; (0, 0, 1) for faces without area."""
        return read_only(self._face_normals[0])

    @property
    def faces_without_area(self) -> np.ndarray:
        """(F,) bool."""
        return read_only(self._face_normals[1])

    @cached_property
    def vertex_normals(self) -> np.ndarray:
        """(V, 3) float32: those that were given, or those of mesh_map.normals."""
        return read_only(vertex_normals(self.topology, *self._face_normals))

    def report(self) -> str:
        """One line for people: what the mesh consists of, and its oddities."""
        without_area = int(self.faces_without_area.sum())
        suffix = ", " + quantity(without_area, "faces without area") if without_area else ""
        return self.topology.report() + suffix

    @property
    def spatial_index(self) -> SpatialIndex:
        """Rays, closest points and selections of faces; built when it is first asked for."""
        if self._index is None:
            with self._index_lock:  # for other threads that ask meanwhile
                if self._index is None:
                    self._index = SpatialIndex(self.vertices, self.faces)
        return self._index

    def closest_face(
        self,
        point: Any,
        max_distance: float,
        normal: Optional[Any] = None,
        max_angle: Optional[float] = None,
    ) -> Optional[SurfacePoint]:
        """The nearest point of the surface, exact over all faces.

        None if there is none within the distance.

        Args:
            point: (3,) meters in frame_id; one that is not finite finds nothing.
            max_distance: meters, on both sides of the surface.
            normal, max_angle: both or none: only faces count whose normal is within this angle
                (radians, 0 to pi) of this direction (3,), such as the upper of two storeys.
        Raises:
            ValueError: a distance that is negative or NaN, or a wrong shape or angle.
        """
        return self.spatial_index.closest(
            point=point,
            max_distance=checked_distance(max_distance),
            normal=normal,
            max_angle=max_angle,
        )

    def nearest_vertex(self, point: Any, max_distance: float) -> Optional[Tuple[int, float]]:
        """The nearest vertex and its distance; None if there is none within the distance (meters).

        Vertices without an edge do not count: no way leads there.
        """
        vertex, distance = _kernels._closest_vertex(
            self.vertices,
            (~self.topology.isolated_vertices).view(np.uint8),
            np.ascontiguousarray(point, np.float64),
            float(max_distance),
        )
        return None if vertex == NO_FACE else (int(vertex), float(distance))

    def compute_layers(
        self,
        config: Any,
        progress: Optional[Progress] = None,
        stored: Optional[StoredCosts] = None,
    ) -> None:
        """Loads and evaluates layers in order, and combines them. Replaces what was there.

        A layer that cannot be used is logged in one line, noted in layer_errors, and left out; the
        others go on.

        Args:
            config: list of {"name": ..., "type": ..., "params": {...}}; params may be missing.
            progress: called with the share that is done (0 to 1) and what comes next. What it
                raises ends the computation and leaves everything as it was.
            stored: gives costs (V,) that a layer had before with the same stored_parameters(), or
                None.
        """
        layers: Dict[str, Layer] = {}
        errors: Dict[str, str] = {}
        if not isinstance(config, (list, tuple)):
            errors["layers"] = "the list of layers is a %s, not a list" % type(config).__name__
            _LOG.error("%s", errors["layers"])
            config = []
        for number, entry in enumerate(config):
            name = "layer %d" % number
            if progress:
                shown = entry.get("name", number) if isinstance(entry, Mapping) else number
                progress(number / len(config), "layer %s" % (shown,))
            try:
                name, type_name, params = _checked_entry(entry, layers, errors)
                layers[name] = self._evaluated(name, type_name, params, layers, stored)
            except MeshMapError as error:
                errors.setdefault(name, str(error))
                _LOG.error("layer %s is left out: %s", name, error)
            except Exception as error:  # a stranger's plugin may fail in any way
                errors[name] = "%s: %s" % (type(error).__name__, one_line(error))
                _LOG.error("layer %s is left out: it failed with %s", name, errors[name])
        results = [(layer.result, layer.params["factor"]) for layer in layers.values()]
        costs = read_only(combine(results, len(self.vertices)))
        if progress:
            progress(1.0, "done")
        self.layers, self.layer_errors, self.costs = layers, errors, costs

    def _evaluated(
        self,
        name: str,
        type_name: str,
        params: Mapping[str, Any],
        before: Mapping[str, Layer],
        stored: Optional[StoredCosts],
    ) -> Layer:
        found = find_class("mesh_map", BASE_CLASS_TYPE, type_name)
        if not issubclass(found, Layer):
            raise MeshMapError("%s is no mesh_map.layer.Layer" % found.__qualname__)
        layer = found(name, params, type_name)
        for warning in layer.warnings:
            _LOG.warning("layer %s: %s", name, warning)
        start = time.monotonic()
        costs = stored(layer) if stored else None
        reused = layer.reuse(costs) if costs is not None else None
        if reused is not None:
            layer.result = checked_result(reused.costs, reused.lethal, len(self.vertices))
        else:
            inputs = {other.name: other.result for other in before.values()}
            layer.result = layer.evaluate(self, inputs)
        layer.result = LayerResult(*map(read_only, layer.result))
        _LOG.info(
            "layer %s: %s lethal vertices, %s in %.2f s",
            name,
            format(int(layer.result.lethal.sum()), ","),
            "computed" if reused is None else "taken from the map file",
            time.monotonic() - start,
        )
        return layer


def _checked_entry(
    entry: Any, layers: Mapping[str, Any], errors: Mapping[str, str]
) -> Tuple[str, str, Mapping[str, Any]]:
    """Name, type and parameters of an entry of the list of layers."""
    if not isinstance(entry, Mapping) or not {"name", "type"} <= set(entry):
        raise MeshMapError("an entry of the list of layers is %r" % (entry,), "{name, type}")
    name, type_name, params = entry["name"], entry["type"], entry.get("params") or {}
    if not isinstance(name, str) or not _NAME.fullmatch(name):
        raise MeshMapError(
            "%r is no name for a layer" % (name,), "letters, digits and _, a letter first"
        )
    if name in layers or name in errors:
        raise MeshMapError("there are two layers of the name %s" % name)
    if not isinstance(type_name, str):
        raise MeshMapError("the type of layer %s is %r" % (name, type_name), "a string is needed")
    if not isinstance(params, Mapping):
        raise MeshMapError("the parameters of layer %s are %r" % (name, params), "not a mapping")
    return name, type_name, params
