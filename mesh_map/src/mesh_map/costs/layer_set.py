"""All layers of a map, made and evaluated from the list of a user."""

import logging
import re
import time
from typing import (
    TYPE_CHECKING,
    Any,
    Callable,
    Dict,
    FrozenSet,
    Iterable,
    List,
    Mapping,
    NamedTuple,
    Optional,
    Tuple,
)

import numpy as np

from mesh_map.base.errors import PLUGIN_FAILURES, MeshMapError, error_line
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
    """Layers of a map, what each of them reads, and which of them do not stand.

    Attributes:
        made: name -> Layer, of all that could be made and ordered, in the order of evaluation.
        layers: those of them that have a result.
        reads: name -> names of what it reads, whether that has a result or not.
        errors: name -> one line, for the layers that are left out: they have no result.
        stale: name -> one line, for those whose last evaluation failed: with the result before.
        optional: names of layers that are not required.
        logged: name -> when a failure of it was logged last (s, of the monotonic clock).
    """

    def __init__(
        self,
        made: Mapping[str, Layer] = {},
        reads: Mapping[str, Tuple[str, ...]] = {},
        errors: Mapping[str, str] = {},
        stale: Mapping[str, str] = {},
        optional: Iterable[str] = (),
        logged: Mapping[str, float] = {},
    ) -> None:
        self.made, self.reads = dict(made), dict(reads)
        self.layers = {name: one for name, one in made.items() if one.result is not None}
        self.errors, self.stale = dict(errors), dict(stale)
        self.optional, self.logged = frozenset(optional), dict(logged)

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
        listed = make_layers(config)
        graph = LayerGraph(listed.layers, listed.errors)
        for text in dict.fromkeys(graph.errors.values()):
            names = [name for name in graph.errors if graph.errors[name] == text]
            log_left_out(", ".join(names), MeshMapError(text))
        made = cls(
            {name: listed.layers[name] for name in graph.order},
            graph.inputs,
            {**listed.errors, **graph.errors},
            optional=listed.optional.union(
                name for name in graph.errors if not listed.layers[name].params["enabled"]
            ),
        )
        reused = made._announced(mesh_map, stored)
        for number, (name, layer) in enumerate(made.made.items()):
            if progress:
                progress(number / len(made.made), "layer " + name)
            if name in made.errors:
                continue
            try:
                made._evaluate(mesh_map, layer, stored, reused.get(name))
            except PLUGIN_FAILURES as error:
                made._leave_out(name, error)
                continue
            made.layers[name] = layer
            if on_layer:
                on_layer(layer)
        return made

    def _announced(
        self, mesh_map: "MeshMap", stored: Optional[StoredCosts]
    ) -> Dict[str, Optional[LayerResult]]:
        """Results that were stored; all layers without one have said what they need."""
        reused: Dict[str, Optional[LayerResult]] = {}
        for layer in self.made.values():
            if not layer.params["enabled"]:
                continue
            try:
                if stored and not layer.READS_LAYERS:
                    reused[layer.name] = _reused(mesh_map, layer, {}, stored)
                if reused.get(layer.name) is None:
                    layer.announce(mesh_map.geometry)
            except PLUGIN_FAILURES as error:
                self._leave_out(layer.name, error)
        return reused

    def _evaluate(
        self,
        mesh_map: "MeshMap",
        layer: Layer,
        stored: Optional[StoredCosts],
        reused: Optional[LayerResult],
    ) -> None:
        if not layer.params["enabled"]:
            layer.evaluated(LayerResult.free(len(mesh_map.vertices)), mesh_map, {})
            _LOG.info("layer %s is not enabled", layer.name)
            return
        inputs = self.inputs_of(layer.name, {name: one.result for name, one in self.layers.items()})
        if layer.READS_LAYERS and stored:
            reused = _reused(mesh_map, layer, inputs, stored)
        _evaluate(mesh_map, layer, inputs, reused)

    def _leave_out(self, name: str, error: BaseException) -> None:
        self.errors[name] = error_line(error)
        self.logged[name] = time.monotonic()
        log_left_out(name, error)

    def inputs_of(self, name: str, results: Mapping[str, LayerResult]) -> Dict[str, LayerInput]:
        """What a layer reads: of all that it reads what has a result.

        Raises:
            MeshMapError: its parameter "inputs" names a required layer that has none.
        """
        for read in self.reads[name]:
            named = self.made[name].inputs is not None
            if named and read not in results and read not in self.optional:
                raise MeshMapError("its input %s is left out" % read)
        return {
            read: as_input(self.made[read], results[read])
            for read in self.reads[name]
            if read in results
        }


def as_input(layer: Layer, result: LayerResult) -> LayerInput:
    """What readers get of a layer."""
    weight = layer.params["combination_weight"] if layer.params["enabled"] else 0.0
    return LayerInput(*result, weight)


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
    except PLUGIN_FAILURES as error:  # or of a file that others have written to
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


class ListedLayers(NamedTuple):
    """What was made of a list of layers.

    layers: by their names, in the order of the list.
    errors: name -> one line, for those that could not be made; "layer N" where there is no name.
    optional: names of those that are not required.
    """

    layers: Dict[str, Layer]
    errors: Dict[str, str]
    optional: FrozenSet[str]


def make_layers(config: Any) -> ListedLayers:
    """Makes the layers of a list.

    Entries that cannot be used are logged and left out; of two of one name, the first counts. What
    is not required, or not enabled, is optional; what does not say so in a usable way is required.

    Args:
        config: as for MeshMap.compute_layers().
    """
    layers: Dict[str, Layer] = {}
    errors: Dict[str, str] = {}
    optional: List[str] = []
    if not isinstance(config, (list, tuple)):
        errors["layers"] = "the list of layers is a %s, not a list" % type(config).__name__
        _LOG.error("%s", errors["layers"])
        return ListedLayers(layers, errors, frozenset())
    with scanned_once():
        for number, entry in enumerate(config):
            name = "layer %d" % number
            required = True
            try:
                checked = _checked_entry(entry)
                required = checked.required
                if checked.name in layers or checked.name in errors:
                    raise MeshMapError("there are two layers of the name %s" % checked.name)
                name = checked.name
                required = required and checked.params.get("enabled") is not False
                layers[name] = _made(*checked[:3])
                required = checked.required  # it may be enabled later
            except PLUGIN_FAILURES as error:
                errors[name] = error_line(error)
                log_left_out(name, error)
            if not required:
                optional.append(name)
    return ListedLayers(layers, errors, frozenset(optional))


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


class _Entry(NamedTuple):
    """An entry of the list of layers."""

    name: str
    type_name: str
    params: Mapping[str, Any]
    required: bool


def _checked_entry(entry: Any) -> _Entry:
    if not isinstance(entry, Mapping) or not {"name", "type"} <= set(entry):
        raise MeshMapError(
            "an entry of the list of layers is %r" % (entry,), "{name: ..., type: ...} is needed"
        )
    name, type_name, params = entry["name"], entry["type"], entry.get("params") or {}
    required = entry.get("required", True)
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
    if not isinstance(required, bool):
        raise MeshMapError(
            "required of layer %s is %r" % (name, required), "true or false is needed"
        )
    return _Entry(name, type_name, params, required)
