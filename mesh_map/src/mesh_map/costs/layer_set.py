"""All layers of a map, made and evaluated from the list of a user."""

import contextlib
import copy
import logging
import re
import time
from functools import partial
from typing import (
    TYPE_CHECKING,
    Any,
    Callable,
    Dict,
    FrozenSet,
    Iterable,
    Iterator,
    List,
    Mapping,
    NamedTuple,
    Optional,
    Set,
    Tuple,
)

import numpy as np

from mesh_map.base.errors import PLUGIN_FAILURES, MeshMapError, UnknownPluginError, error_line
from mesh_map.base.plugins import find_class, scanned_once
from mesh_map.costs.layer import BASE_CLASS_TYPE, Inputs, Layer, LayerInput, LayerResult, checked
from mesh_map.costs.layer_graph import LayerGraph
from mesh_map.costs.layer_worker import LayerWorker, seconds_for
from mesh_map.costs.trust import CostsOnTrust, trusted

if TYPE_CHECKING:
    from mesh_map.map.mesh_map import MeshMap

_LOG = logging.getLogger("mesh_map")
_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]*")

Progress = Callable[[float, str], None]
StoredCosts = Callable[[str, Mapping[str, Any]], Optional[np.ndarray]]
OnLayer = Callable[[Layer], None]


class Behind(NamedTuple):
    """What has changed in what a layer reads.

    vertices: (K,) uint32, ascending: where results differ.
    anew: weights do, or results that are new, so that it is evaluated from nothing.
    """

    vertices: np.ndarray
    anew: bool

    def joined(self, other: Optional["Behind"]) -> "Behind":
        """Both."""
        if other is None:
            return self
        return Behind(np.union1d(self.vertices, other.vertices), self.anew or other.anew)


class LayerSet:
    """Layers of a map, what each of them reads, and which of them do not stand.

    Attributes:
        made: name -> Layer, of all that could be made and ordered, in the order of evaluation.
        layers: those of them that have a result.
        reads: name -> names of what it reads, whether that has a result or not.
        errors: name -> one line, for the layers that are left out: they have no result.
        stale: name -> one line, for those whose last evaluation failed: with the result before.
        behind: name -> what has changed in what it reads since it was evaluated; only where
            something has.
        optional: names of layers that are not required.
        params: name -> the parameters in force; those of the layer itself are others while it is
            evaluated with them.
        workers: name -> who calls the layer.
        sensing: names of those that have data of sensors, or read one that has.
        logged: name -> when a failure of it was logged last (s, of the monotonic clock).
    """

    def __init__(
        self,
        made: Mapping[str, Layer] = {},
        reads: Mapping[str, Tuple[str, ...]] = {},
        errors: Mapping[str, str] = {},
        optional: Iterable[str] = (),
        seconds: Optional[float] = None,
    ) -> None:
        """
        Args:
            made, reads, errors, optional: see above.
            seconds: that a call of a layer may take; None for no limit.
        """
        self.made, self.reads, self.optional = made, reads, frozenset(optional)
        self.layers: Dict[str, Layer] = {}
        self.errors = dict(errors)
        self.stale: Dict[str, str] = {}
        self.behind: Dict[str, Behind] = {}
        self.params = {name: layer.params for name, layer in made.items()}
        self.workers = {name: LayerWorker(name, seconds) for name in made}
        sensing: Set[str] = set()
        for name, layer in made.items():
            if layer.can_be_cleared() or not sensing.isdisjoint(reads.get(name, ())):
                sensing.add(name)
        self.sensing = frozenset(sensing)
        self.logged: Dict[str, float] = {}

    def changed(self) -> "LayerSet":
        """One that can be changed into what follows it."""
        after = copy.copy(self)
        after.layers, after.params = dict(self.layers), dict(self.params)
        after.behind = dict(self.behind)
        after.errors, after.stale, after.logged = map(dict, (self.errors, self.stale, self.logged))
        return after

    @contextlib.contextmanager
    def locked(self, names: Iterable[str]) -> Iterator[None]:
        """Within, no other thread evaluates these.

        Names are in the order of evaluation, and come after those that this thread has locked: so
        nobody waits in a circle. Whoever wants them waits for calls under way, at most as long as
        a call may take.
        """
        with contextlib.ExitStack() as locks:
            for name in names:
                locks.enter_context(self.workers[name].lock)
            yield

    def hanging(self) -> Dict[str, str]:
        """name -> one line, for the layers that have not answered in time."""
        return {name: worker.fault for name, worker in self.workers.items() if worker.fault}

    @classmethod
    def computed(
        cls,
        mesh_map: "MeshMap",
        config: Any,
        progress: Optional[Progress] = None,
        stored: Optional[StoredCosts] = None,
        on_layer: Optional[OnLayer] = None,
        on_trust: Optional[CostsOnTrust] = None,
    ) -> "LayerSet":
        """Loads and evaluates all layers; arguments as for MeshMap.compute_layers()."""
        seconds = seconds_for(len(mesh_map.faces), mesh_map.layer_timeout)
        listed = make_layers(config, seconds)
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
            seconds=seconds,
        )
        reused = made._announced(mesh_map, stored, on_trust)
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
        self,
        mesh_map: "MeshMap",
        stored: Optional[StoredCosts],
        on_trust: Optional[CostsOnTrust],
    ) -> Dict[str, Optional[LayerResult]]:
        """Results that were stored; all layers without one have said what they need."""
        reused: Dict[str, Optional[LayerResult]] = {}
        for layer in self.made.values():
            if not layer.params["enabled"]:
                continue
            try:
                reused[layer.name] = self.workers[layer.name].call(
                    partial(_announced, mesh_map, layer, stored, on_trust)
                )
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
        """Gives a layer its first result; reused: one that was stored."""
        if not layer.params["enabled"]:
            layer.evaluated(LayerResult.free(len(mesh_map.vertices)), mesh_map, {})
            _LOG.info("layer %s is not enabled", layer.name)
            return
        inputs = self.inputs_of(layer.name, {name: one.result for name, one in self.layers.items()})
        start = time.monotonic()
        call = self.workers[layer.name].call
        if layer.READS_LAYERS and stored:
            reused = call(partial(_reused, mesh_map, layer, inputs, stored))
        result = reused or call(partial(layer.evaluate, mesh_map, inputs))
        identity = layer.identity
        layer.evaluated(result, mesh_map, inputs)
        if identity:
            layer.identity = identity
        _LOG.info(
            "layer %s: %s lethal vertices, %s in %.2f s",
            layer.name,
            format(int(result.lethal.sum()), ","),
            "taken from the map file" if reused else "computed",
            time.monotonic() - start,
        )

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
            read: as_input(self.params[read], results[read])
            for read in self.reads[name]
            if read in results
        }


def as_input(params: Mapping[str, Any], result: LayerResult) -> LayerInput:
    """What readers get of a layer with these parameters."""
    weight = params["combination_weight"] if params["enabled"] else 0.0
    return LayerInput(*result, weight)


def _announced(
    mesh_map: "MeshMap",
    layer: Layer,
    stored: Optional[StoredCosts],
    on_trust: Optional[CostsOnTrust],
) -> Optional[LayerResult]:
    """A result that was stored; a layer without one has said what it needs."""
    reused = None
    if stored and not layer.READS_LAYERS:
        reused = _reused(mesh_map, layer, {}, stored)
    if reused is None:
        reused = _trusted(mesh_map, layer, on_trust)
    if reused is None:
        layer.announce(mesh_map.geometry)
    return reused


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


def _trusted(
    mesh_map: "MeshMap", layer: Layer, on_trust: Optional[CostsOnTrust]
) -> Optional[LayerResult]:
    try:
        return trusted(mesh_map, layer, on_trust)
    except PLUGIN_FAILURES as error:
        _LOG.warning("layer %s is computed anew: %s", layer.name, error_line(error))
        return None


class ListedLayers(NamedTuple):
    """What was made of a list of layers.

    layers: by their names, in the order of the list.
    errors: name -> one line, for those that could not be made; "layer N" where there is no name.
    optional: names of those that are not required.
    """

    layers: Dict[str, Layer]
    errors: Dict[str, str]
    optional: FrozenSet[str]


def make_layers(config: Any, seconds: Optional[float] = None) -> ListedLayers:
    """Makes the layers of a list.

    Entries that cannot be used are logged and left out; of two of one name, the first counts. What
    is not required, or not enabled, is optional; what does not say so in a usable way is required.

    Args:
        config: as for MeshMap.compute_layers().
        seconds: that the constructor of a layer may take; None for no limit.
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
                layers[name] = LayerWorker(name, seconds).call(partial(_made, *checked[:3]))
                required = checked.required  # it may be enabled later
            except PLUGIN_FAILURES as error:
                log_left_out(name, error)  # with all types that there are: once is enough
                errors[name] = error_line(error)
                if isinstance(error, UnknownPluginError):
                    errors[name] = error.message
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


_ENTRY_KEYS = ("name", "type", "required", "params")


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
    # What stands in the entry itself is meant for the layer, too.
    beside = {key: entry[key] for key in entry if key not in _ENTRY_KEYS}
    return _Entry(name, type_name, {**beside, **params}, required)
