"""Evaluation of those layers that a change concerns."""

import logging
import math
import time
from typing import TYPE_CHECKING, Dict, Set

import numpy as np

from mesh_map.base.errors import PLUGIN_FAILURES, error_line
from mesh_map.costs.layer import LayerInput, LayerResult, checked
from mesh_map.costs.layer_changes import ResultDifference, union
from mesh_map.costs.layer_set import LayerSet

if TYPE_CHECKING:
    from mesh_map.map.mesh_map import MeshMap

_LOG = logging.getLogger("mesh_map")
FAILURE_PERIOD = 10.0  # seconds, in which the failures of a layer are logged once


class Propagation:
    """A change of one layer, and what follows from it; nothing is in force before commit().

    Attributes:
        results: name -> result of all layers that have one.
        differences: name -> where it differs from the result before; only where it does.
    """

    def __init__(self, mesh_map: "MeshMap", layer_set: LayerSet) -> None:
        self._mesh_map = mesh_map
        self._set = layer_set
        self._errors, self._stale = dict(layer_set.errors), dict(layer_set.stale)
        self._logged = dict(layer_set.logged)
        self._weights: Set[str] = set()
        self._used: Dict[str, Dict[str, LayerInput]] = {}
        self.results: Dict[str, LayerResult] = {
            name: layer.result
            for name, layer in layer_set.layers.items()
            if layer.result is not None
        }
        self.differences: Dict[str, ResultDifference] = {}

    def parameters_changed(self, name: str, changed: Set[str]) -> None:
        """Evaluates a layer with its new parameters, as far as needed. Errors as for compute()."""
        layer = self._set.made[name]
        if not changed.isdisjoint(("combination_weight", "enabled")):
            self._weights.add(name)
        if not layer.params["enabled"]:
            self._put(name, LayerResult.free(len(self._mesh_map.vertices)), {})
            return
        declared = [parameter for parameter in layer.PARAMETERS if parameter.name in changed]
        costs = any(parameter.affects_costs for parameter in declared)
        if costs or "enabled" in changed or name not in self.results:
            self.compute(name)
        elif declared:
            self._reuse(name)

    def compute(self, name: str) -> None:
        """Evaluates a layer from nothing. What it raises leaves it as it was."""
        layer = self._set.made[name]
        inputs = self._set.inputs_of(name, self.results)
        layer.announce(self._mesh_map.geometry)
        self._put(name, layer.evaluate(self._mesh_map, inputs), inputs)

    def update(self, name: str, changed: np.ndarray) -> None:
        """Evaluates a layer whose inputs, or own data, have changed, if it is enabled.

        Errors as for compute().
        """
        layer = self._set.made[name]
        if not layer.params["enabled"]:
            return
        if name in self._stale or name not in self.results:
            self.compute(name)
            return
        inputs = self._set.inputs_of(name, self.results)
        before = self.results[name]
        returned = layer.update(self._mesh_map, inputs, changed, before)
        self._put(name, checked(returned, len(before.costs)), inputs)

    def _reuse(self, name: str) -> None:
        """Takes the costs as they are, with other parameters. Errors as for compute()."""
        layer, before = self._set.made[name], self.results[name]
        inputs = self._set.inputs_of(name, self.results)
        reused = None
        if name not in self._stale:
            reused = layer.reuse(before.costs, self._mesh_map, inputs)
        if reused is None:
            self.compute(name)
        else:
            self._put(name, checked(reused, len(before.costs)), inputs)

    def fail(self, name: str, error: BaseException) -> None:
        """Notes that a layer could not be evaluated: it keeps the result before, if it has one.

        Not logged each time: it may fail with every cloud of a sensor.
        """
        stands = name in self.results
        (self._stale if stands else self._errors)[name] = error_line(error)
        now = time.monotonic()
        if now - self._logged.get(name, -math.inf) >= FAILURE_PERIOD:
            self._logged[name] = now
            what = "stays as it was" if stands else "is left out"
            _LOG.error("layer %s %s: %s", name, what, error_line(error))

    def follow(self) -> None:
        """Evaluates all layers that read what has changed, in their order."""
        for name, layer in self._set.made.items():
            read = self._set.reads[name]
            weights = layer.READS_WEIGHTS and not self._weights.isdisjoint(read)
            changed = [self.differences[other].read for other in read if other in self.differences]
            if not layer.params["enabled"] or not (changed or weights):
                continue
            try:
                if weights:
                    self.compute(name)
                else:
                    self.update(name, union(changed, len(self._mesh_map.vertices)))
            except PLUGIN_FAILURES as error:
                self.fail(name, error)

    def commit(self) -> LayerSet:
        """Gives the layers their new results; returns the layers as they are now."""
        before = self._set
        for name, inputs in self._used.items():
            before.made[name].evaluated(self.results[name], self._mesh_map, inputs)
        return LayerSet(
            before.made, before.reads, self._errors, self._stale, before.optional, self._logged
        )

    def changed_vertices(self) -> np.ndarray:
        """(K,) ascending: where any result differs in anything."""
        changed = [difference.read for difference in self.differences.values()]
        return union(changed, len(self._mesh_map.vertices))

    def _put(self, name: str, result: LayerResult, inputs: Dict[str, LayerInput]) -> None:
        failed = self._stale.pop(name, None), self._errors.pop(name, None)
        if any(failed):
            self._logged.pop(name, None)
            _LOG.info("layer %s is up to date again", name)
        self._used[name] = inputs
        before = self.results.get(name)
        if before is None:
            self._weights.add(name)
        difference = ResultDifference.between(before, result)
        if len(difference.read):
            self.differences[name] = difference
        if (
            before is None
            or len(difference.read)
            or (result.vectors is None) != (before.vectors is None)
        ):
            self.results[name] = result
