"""The mesh map: one geometry and the cost layers on it."""

import logging
import re
import time
from typing import Any, Callable, Dict, Mapping, Optional, Tuple

import numpy as np

from mesh_map.array_checks import read_only
from mesh_map.combination import combine
from mesh_map.errors import MeshMapError, one_line
from mesh_map.geometry import MeshGeometry
from mesh_map.layer import BASE_CLASS_TYPE, Layer, LayerInput, checked_result
from mesh_map.plugins import find_class

_LOG = logging.getLogger("mesh_map")
_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]*")

Progress = Callable[[float, str], None]
StoredCosts = Callable[[str, Mapping[str, Any]], Optional[np.ndarray]]


class MeshMap:
    """A triangle mesh with cost layers. All arrays are read-only.

    Attributes:
        geometry: the mesh; may be shared with other maps.
        contents: what else is in the map file (labels, stored layers, face attributes): a
            mesh_msgs_hdf5 MapFile or what has its methods; None where there is none.
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
        """A map of a mesh of its own; arguments and errors are those of MeshGeometry."""
        self._begin(MeshGeometry(vertices, faces, vertex_normals, frame_id, uuid))

    @classmethod
    def of(cls, geometry: MeshGeometry, contents: Any = None) -> "MeshMap":
        """A map without layers of a mesh that may be shared: nothing of it is computed again."""
        made = cls.__new__(cls)
        made._begin(geometry, contents)
        return made

    def _begin(self, geometry: MeshGeometry, contents: Any = None) -> None:
        self.geometry = geometry
        self.contents = contents
        self.layers: Dict[str, Layer] = {}
        self.layer_errors: Dict[str, str] = {}
        self.costs = read_only(np.zeros(len(geometry.vertices), np.float32))

    # What is asked for most, so that callers need not reach through.
    vertices = property(lambda self: self.geometry.vertices)
    faces = property(lambda self: self.geometry.faces)
    frame_id = property(lambda self: self.geometry.frame_id)
    uuid = property(lambda self: self.geometry.uuid)
    topology = property(lambda self: self.geometry.topology)
    face_normals = property(lambda self: self.geometry.face_normals)
    faces_without_area = property(lambda self: self.geometry.faces_without_area)
    vertex_normals = property(lambda self: self.geometry.vertex_normals)
    spatial_index = property(lambda self: self.geometry.spatial_index)
    report = property(lambda self: self.geometry.report)
    closest_face = property(lambda self: self.geometry.closest_face)
    nearest_vertex = property(lambda self: self.geometry.nearest_vertex)

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
            stored: gives costs (V,) that a layer (of a name) had before with the same
                fingerprint(), or None.
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
        inputs = (
            {other.name: _as_input(other) for other in before.values()}
            if layer.READS_LAYERS
            else {}
        )
        layer.identity = layer.fingerprint(self, inputs)
        costs = stored(name, layer.identity) if stored else None
        reused = layer.reuse(costs) if costs is not None else None
        if reused is not None:
            layer.result = checked_result(reused.costs, reused.lethal, len(self.vertices))
        else:
            layer.result = layer.evaluate(self, inputs)
        layer.result = layer.result.read_only()
        _LOG.info(
            "layer %s: %s lethal vertices, %s in %.2f s",
            name,
            format(int(layer.result.lethal.sum()), ","),
            "computed" if reused is None else "taken from the map file",
            time.monotonic() - start,
        )
        return layer


def _as_input(layer: Layer) -> LayerInput:
    return LayerInput(*layer.result, layer.params["combination_weight"])


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
