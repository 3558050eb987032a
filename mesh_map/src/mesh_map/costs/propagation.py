"""Evaluation of those layers that a change concerns."""

import logging
import math
import time
from typing import TYPE_CHECKING, Dict, Set

import numpy as np

from mesh_map.base.errors import error_line
from mesh_map.costs.layer import LayerInput, LayerResult, checked
from mesh_map.costs.layer_changes import ResultDifference, union
from mesh_map.costs.layer_set import LayerSet, as_input

if TYPE_CHECKING:
    from mesh_map.map.mesh_map import MeshMap

_LOG = logging.getLogger("mesh_map")
FAILURE_PERIOD = 10.0  # seconds, in which the failures of a layer are logged once


class Propagation:
    """A change of one layer, and what follows from it; nothing is in force before commit().

    Attributes:
        results: name -> result of all layers.
        differences: name -> where it differs from the result before; only where it does.
    """

    def __init__(self, mesh_map: "MeshMap", layer_set: LayerSet) -> None:
        self._mesh_map = mesh_map
        self._set = layer_set
        self._stale = dict(layer_set.stale)
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
        layer = self._set.layers[name]
        if "combination_weight" in changed:
            self._weights.add(name)
        declared = [parameter for parameter in layer.PARAMETERS if parameter.name in changed]
        if any(parameter.affects_costs for parameter in declared):
            self.compute(name)
        elif declared:
            self._reuse(name)

    def compute(self, name: str) -> None:
        """Evaluates a layer from nothing. What it raises leaves it as it was."""
        layer = self._set.layers[name]
        layer.announce(self._mesh_map.geometry)
        inputs = self._inputs(name)
        self._put(name, layer.evaluate(self._mesh_map, inputs), inputs)

    def update(self, name: str, changed: np.ndarray) -> None:
        """Evaluates a layer whose inputs, or own data, have changed. Errors as for compute()."""
        if name in self._stale:
            self.compute(name)
            return
        inputs = self._inputs(name)
        before = self.results[name]
        returned = self._set.layers[name].update(self._mesh_map, inputs, changed, before)
        self._put(name, checked(returned, len(before.costs)), inputs)

    def _reuse(self, name: str) -> None:
        """Takes the costs as they are, with other parameters. Errors as for compute()."""
        layer, before = self._set.layers[name], self.results[name]
        inputs = self._inputs(name)
        reused = None
        if name not in self._stale:
            reused = layer.reuse(before.costs, self._mesh_map, inputs)
        if reused is None:
            self.compute(name)
        else:
            self._put(name, checked(reused, len(before.costs)), inputs)

    def fail(self, name: str, error: BaseException) -> None:
        """Keeps the result before of a layer that could not be evaluated, and logs that.

        Not each time: it may fail with every cloud of a sensor.
        """
        now = time.monotonic()
        if now - self._stale.get(name, -math.inf) >= FAILURE_PERIOD:
            self._stale[name] = now
            _LOG.error("layer %s stays as it was: %s", name, error_line(error))

    def follow(self) -> None:
        """Evaluates all layers that read what has changed, in their order."""
        for name, layer in self._set.layers.items():
            read = self._set.inputs[name]
            weights = layer.READS_WEIGHTS and not self._weights.isdisjoint(read)
            changed = [self.differences[other].read for other in read if other in self.differences]
            if not changed and not weights:
                continue
            try:
                if weights:
                    self.compute(name)
                else:
                    self.update(name, union(changed, len(self._mesh_map.vertices)))
            except Exception as error:  # a stranger's plugin may fail in any way
                self.fail(name, error)

    def commit(self) -> None:
        """Gives the layers their new results."""
        for name, inputs in self._used.items():
            self._set.layers[name].evaluated(self.results[name], self._mesh_map, inputs)
        self._set.stale = self._stale

    def changed_vertices(self) -> np.ndarray:
        """(K,) ascending: where any result differs in anything."""
        changed = [difference.read for difference in self.differences.values()]
        return union(changed, len(self._mesh_map.vertices))

    def _inputs(self, name: str) -> Dict[str, LayerInput]:
        layers = self._set.layers
        return {
            other: as_input(layers[other], self.results[other]) for other in self._set.inputs[name]
        }

    def _put(self, name: str, result: LayerResult, inputs: Dict[str, LayerInput]) -> None:
        if self._stale.pop(name, None) is not None:
            _LOG.info("layer %s is up to date again", name)
        self._used[name] = inputs
        before = self.results[name]
        difference = ResultDifference.between(before, result)
        if len(difference.read):
            self.differences[name] = difference
        if len(difference.read) or (result.vectors is None) != (before.vectors is None):
            self.results[name] = result
