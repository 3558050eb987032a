"""All layers of a map, made and evaluated from the list of a user."""

import logging
import time
from typing import TYPE_CHECKING, Any, Callable, Dict, List, Mapping, Optional

import numpy as np

from mesh_map.errors import MeshMapError
from mesh_map.layer import Layer, LayerInput, LayerResult, checked
from mesh_map.layer_graph import LayerGraph
from mesh_map.layer_list import error_line, log_left_out, make_layers

if TYPE_CHECKING:
    from mesh_map.mesh_map import MeshMap

_LOG = logging.getLogger("mesh_map")

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
    mesh_map: "MeshMap", layer: Layer, inputs: Mapping[str, LayerInput], stored: StoredCosts
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
    mesh_map: "MeshMap",
    layer: Layer,
    inputs: Mapping[str, LayerInput],
    reused: Optional[LayerResult],
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
