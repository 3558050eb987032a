"""Costs of a map as they would be if sensors had seen nothing."""

import logging
import threading
from typing import TYPE_CHECKING, Any, Dict, List, Mapping, NamedTuple, Optional, Tuple

from mesh_map import _kernels
from mesh_map.base.errors import PLUGIN_FAILURES, error_line
from mesh_map.costs.combination import Combination
from mesh_map.costs.edge_weights import PlanningCosts
from mesh_map.costs.layer import Layer, LayerResult
from mesh_map.costs.layer_set import LayerSet, as_input
from mesh_map.costs.settings import MapSettings

if TYPE_CHECKING:
    from mesh_map.map.mesh_map import MeshMap

_LOG = logging.getLogger("mesh_map")


class Combined(NamedTuple):
    """Which layers are combined, and how.

    mode: of `Combination`.
    factors: name -> factor, in the order of evaluation.
    """

    mode: str
    factors: Mapping[str, float]

    @classmethod
    def of(cls, layer_set: LayerSet, settings: MapSettings) -> "Combined":
        """As settings say: the default_layer alone, or all that are enabled."""
        params = layer_set.params
        factors = {
            name: params[name]["factor"] for name in layer_set.layers if params[name]["enabled"]
        }
        if settings.default_layer in factors:
            return cls("sum", {settings.default_layer: 1.0})
        return cls(settings.combination, factors)


class ClearedCosts(NamedTuple):
    """Costs of a map with the layers that can be cleared empty.

    planning: costs, and weights of edges.
    results: name -> what the layers then have.
    """

    planning: PlanningCosts
    results: Mapping[str, LayerResult]


class ClearedCostsMemory:
    """Makes them for one map, and keeps the last ones; from any thread.

    Layers that can be cleared count as free. Those that read them are evaluated without them, by
    layers of the same kind that are made for it, so that those of the map are left alone; one that
    fails counts as free. So nothing is closed here that clearing would open.
    """

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._key: Tuple[Any, ...] = ()
        self._made: Optional[ClearedCosts] = None

    def of(
        self, mesh_map: "MeshMap", layer_set: LayerSet, now: PlanningCosts, settings: MapSettings
    ) -> ClearedCosts:
        """For the layers of this moment.

        Args:
            mesh_map: the map.
            layer_set, now, settings: of it, all of one moment.
        """
        present = {name: layer.result for name, layer in layer_set.layers.items()}
        if not layer_set.sensing:
            return ClearedCosts(now, present)
        static = [result for name, result in present.items() if name not in layer_set.sensing]
        params = [layer_set.params[name] for name in layer_set.layers]
        key = (layer_set.made, static, params, settings)
        with self._lock:
            if self._made is None or not _is_same(key, self._key):
                self._made = _cleared(mesh_map, layer_set, settings)
                self._key = key
            return self._made


def _is_same(key: Tuple[Any, ...], other: Tuple[Any, ...]) -> bool:
    if not other or key[0] is not other[0] or len(key[1]) != len(other[1]):
        return False
    return all(a is b for a, b in zip(key[1], other[1])) and key[2:] == other[2:]


def _cleared(mesh_map: "MeshMap", layer_set: LayerSet, settings: MapSettings) -> ClearedCosts:
    count = len(mesh_map.geometry.vertices)
    results: Dict[str, LayerResult] = {}
    for name, layer in layer_set.layers.items():
        if name not in layer_set.sensing:
            results[name] = layer.result
        elif layer.can_be_cleared() or not layer_set.params[name]["enabled"]:
            results[name] = LayerResult.free(count)
        else:
            results[name] = _evaluated(mesh_map, layer_set, layer, results)
    mode, factors = Combined.of(layer_set, settings)
    terms: List[Tuple[LayerResult, float]] = [
        (results[name], factor) for name, factor in factors.items()
    ]
    costs = Combination(terms, count, mode).costs
    return ClearedCosts(PlanningCosts(0, costs, mesh_map.geometry, settings), results)


def _evaluated(
    mesh_map: "MeshMap", layer_set: LayerSet, layer: Layer, results: Mapping[str, LayerResult]
) -> LayerResult:
    """What such a layer would have with these results of others."""
    name = layer.name
    given = dict(layer_set.params[name])
    if layer.inputs is not None:
        given["inputs"] = list(layer.inputs)
    inputs = {
        read: as_input(layer_set.params[read], results[read])
        for read in layer_set.reads[name]
        if read in results
    }
    try:
        other = type(layer)(name, given, layer.type_name)
        with _kernels._BackgroundLoops():  # what a robot sees comes first
            other.announce(mesh_map.geometry)
            return other.evaluate(mesh_map, inputs)
    except PLUGIN_FAILURES as error:
        _LOG.warning("layer %s without what sensors see: %s", name, error_line(error))
        return LayerResult.free(len(mesh_map.geometry.vertices))
