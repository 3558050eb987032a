"""All layers of a map, made and evaluated from the list of a user."""

import logging
import re
import time
from typing import TYPE_CHECKING, Any, Callable, Dict, List, Mapping, Optional, Tuple

import numpy as np

from mesh_map.base.errors import MeshMapError, error_line
from mesh_map.base.plugins import find_class, scanned_once
from mesh_map.costs.layer import BASE_CLASS_TYPE, Inputs, Layer, LayerInput, LayerResult, checked
from mesh_map.costs.layer_graph import LayerGraph

if TYPE_CHECKING:
    from mesh_map.map.mesh_map import MeshMap

_LOG = logging.getLogger("mesh_map")
_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]*")

Progress = Callable[[float, str], None]
StoredCosts = Callable[[str, Mapping[str, Any]], Optional[np.ndarray]]
OnLayer = Callable[[Layer], None]


class LayerSet:
    """Layers with results, and what each of them reads.

    Attributes:
        layers: name -> Layer, in the order of evaluation.
        inputs: name -> names of what it reads.
        errors: name -> one line, for the layers that are left out.
        stale: names of layers whose last evaluation failed: they have the result before. With the
            time (of the monotonic clock) at which that was logged last.
    """

    def __init__(self) -> None:
        self.layers: Dict[str, Layer] = {}
        self.inputs: Dict[str, List[str]] = {}
        self.errors: Dict[str, str] = {}
        self.stale: Dict[str, float] = {}

    @classmethod
    def computed(
        cls,
        mesh_map: "MeshMap",
        config: Any,
        progress: Optional[Progress] = None,
        stored: Optional[StoredCosts] = None,
        on_layer: Optional[OnLayer] = None,
    ) -> "LayerSet":
        """Loads and evaluates all layers; arguments as for MeshMap.compute_layers()."""
        made = cls()
        layers, made.errors = make_layers(config)
        graph = LayerGraph(layers, made.errors)
        for text in dict.fromkeys(graph.errors.values()):
            names = [name for name in graph.errors if graph.errors[name] == text]
            log_left_out(", ".join(names), MeshMapError(text))
        made.errors.update(graph.errors)
        reused = made._announced(mesh_map, [layers[name] for name in graph.order], stored)
        for number, name in enumerate(graph.order):
            if progress:
                progress(number / len(graph.order), "layer " + name)
            if name in made.errors:
                continue
            layer = layers[name]
            try:
                inputs = made._inputs_of(layer, graph.inputs[name])
                if layer.READS_LAYERS and stored:
                    reused[name] = _reused(mesh_map, layer, inputs, stored)
                _evaluate(mesh_map, layer, inputs, reused.get(name))
            except Exception as error:  # a stranger's plugin may fail in any way
                made._leave_out(name, error)
                continue
            made.layers[name] = layer
            made.inputs[name] = list(inputs)
            if on_layer:
                on_layer(layer)
        return made

    def _announced(
        self, mesh_map: "MeshMap", layers: List[Layer], stored: Optional[StoredCosts]
    ) -> Dict[str, Optional[LayerResult]]:
        """Results that were stored; all layers without one have said what they need."""
        reused: Dict[str, Optional[LayerResult]] = {}
        for layer in layers:
            try:
                if stored and not layer.READS_LAYERS:
                    reused[layer.name] = _reused(mesh_map, layer, {}, stored)
                if reused.get(layer.name) is None:
                    layer.announce(mesh_map.geometry)
            except Exception as error:  # a stranger's plugin may fail in any way
                self._leave_out(layer.name, error)
        return reused

    def _leave_out(self, name: str, error: BaseException) -> None:
        self.errors[name] = error_line(error)
        log_left_out(name, error)

    def _inputs_of(self, layer: Layer, names: Any) -> Dict[str, LayerInput]:
        if layer.inputs is not None:
            for name in names:
                if name in self.errors:
                    raise MeshMapError("its input %s is left out" % name)
        return {name: as_input(self.layers[name]) for name in names if name in self.layers}


def as_input(layer: Layer, result: Optional[LayerResult] = None) -> LayerInput:
    """What readers get of a layer."""
    return LayerInput(*(result or layer.result), layer.params["combination_weight"])


def _reused(
    mesh_map: "MeshMap", layer: Layer, inputs: Inputs, stored: StoredCosts
) -> Optional[LayerResult]:
    if not layer.STORABLE:
        return None
    layer.identity = layer.fingerprint(mesh_map, inputs)
    try:
        costs = stored(layer.name, layer.identity)
        returned = None if costs is None else layer.reuse(costs, mesh_map, inputs)
        return None if returned is None else checked(returned, len(mesh_map.vertices))
    except Exception as error:  # a file that others have written to, or a stranger's plugin
        _LOG.warning("layer %s is computed anew: %s", layer.name, error_line(error))
        return None


def _evaluate(
    mesh_map: "MeshMap", layer: Layer, inputs: Inputs, reused: Optional[LayerResult]
) -> None:
    start = time.monotonic()
    result = layer.evaluate(mesh_map, inputs) if reused is None else reused
    identity = layer.identity
    layer.evaluated(result, mesh_map, inputs)
    if identity:
        layer.identity = identity
    _LOG.info(
        "layer %s: %s lethal vertices, %s in %.2f s",
        layer.name,
        format(int(result.lethal.sum()), ","),
        "computed" if reused is None else "taken from the map file",
        time.monotonic() - start,
    )


def make_layers(config: Any) -> Tuple[Dict[str, Layer], Dict[str, str]]:
    """Layers by their names, in the order of the list, and errors (one line each) by their names.

    Entries that cannot be used are logged and left out; of two of one name, the first counts.

    Args:
        config: list of {"name": ..., "type": ..., "params": {...}}; params may be missing.
    """
    layers: Dict[str, Layer] = {}
    errors: Dict[str, str] = {}
    if not isinstance(config, (list, tuple)):
        errors["layers"] = "the list of layers is a %s, not a list" % type(config).__name__
        _LOG.error("%s", errors["layers"])
        return layers, errors
    with scanned_once():
        for number, entry in enumerate(config):
            name = "layer %d" % number
            try:
                checked_name, type_name, params = _checked_entry(entry)
                if checked_name in layers or checked_name in errors:
                    raise MeshMapError("there are two layers of the name %s" % checked_name)
                name = checked_name
                layers[name] = _made(name, type_name, params)
            except Exception as error:  # a stranger's plugin may fail in any way
                errors[name] = error_line(error)
                log_left_out(name, error)
    return layers, errors


def log_left_out(name: str, error: BaseException) -> None:
    """Says that a layer cannot be used; one without a usable name is "layer N" of the list."""
    failed = "" if isinstance(error, MeshMapError) else "it failed with "
    shown = name if name.startswith("layer ") else "layer " + name
    _LOG.error("%s is left out: %s%s", shown, failed, error_line(error))


def _made(name: str, type_name: str, params: Mapping[str, Any]) -> Layer:
    found = find_class("mesh_map", BASE_CLASS_TYPE, type_name)
    if not issubclass(found, Layer):
        raise MeshMapError("%s is no mesh_map.costs.layer.Layer" % found.__qualname__)
    layer = found(name, params, type_name)
    for warning in layer.warnings:
        _LOG.warning("layer %s: %s", name, warning)
    return layer


def _checked_entry(entry: Any) -> Tuple[str, str, Mapping[str, Any]]:
    """Name, type and parameters of an entry of the list of layers."""
    if not isinstance(entry, Mapping) or not {"name", "type"} <= set(entry):
        raise MeshMapError(
            "an entry of the list of layers is %r" % (entry,), "{name: ..., type: ...} is needed"
        )
    name, type_name, params = entry["name"], entry["type"], entry.get("params") or {}
    if not isinstance(name, str) or not _NAME.fullmatch(name):
        raise MeshMapError(
            "%r is no name for a layer" % (name,), "letters, digits and _, a letter first"
        )
    if not isinstance(type_name, str):
        raise MeshMapError("the type of layer %s is %r" % (name, type_name), "a string is needed")
    if not isinstance(params, Mapping):
        raise MeshMapError(
            "the parameters of layer %s are %r" % (name, params), "a mapping is needed"
        )
    return name, type_name, params
