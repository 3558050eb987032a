"""A change of a layer: evaluated, put in force, and noted for those who read it."""

import logging
import math
import time
from typing import TYPE_CHECKING, Any, Callable, Dict, Mapping, Optional, Set

import numpy as np

from mesh_map import _kernels
from mesh_map.base.errors import MeshMapError, error_line
from mesh_map.costs.layer import LayerInput, LayerResult, checked
from mesh_map.costs.layer_changes import ResultDifference, union
from mesh_map.costs.layer_set import Behind, LayerSet, as_input
from mesh_map.costs.layer_worker import Answer

if TYPE_CHECKING:
    from mesh_map.map.mesh_map import MeshMap

_LOG = logging.getLogger("mesh_map")
FAILURE_PERIOD = 10.0  # seconds, in which the failures of a layer are logged once
_NOTHING = Behind(np.zeros(0, np.uint32), False)


class Propagation:
    """A change of a layer, or a few; nothing is in force before commit().

    Attributes:
        differences: name -> where it differs from the result before; only where it does.
    """

    def __init__(self, mesh_map: "MeshMap") -> None:
        """Args: the map. Whoever calls the methods has locked the layers in question."""
        self._mesh_map = mesh_map
        self._made = mesh_map.layer_set.made
        self._behind: Dict[str, Optional[Behind]] = {}  # that is made up for
        self._failed: Dict[str, str] = {}
        self._params: Dict[str, Mapping[str, Any]] = {}
        self._weights: Set[str] = set()
        self._used: Dict[str, Dict[str, LayerInput]] = {}
        self._results: Dict[str, LayerResult] = {}
        self.differences: Dict[str, ResultDifference] = {}

    @property
    def _set(self) -> LayerSet:
        """The layers as they are now."""
        present = self._mesh_map.layer_set
        if present.made is not self._made:
            raise MeshMapError("the layers of the map have been replaced meanwhile")
        return present

    @property
    def results(self) -> Dict[str, LayerResult]:
        """name -> result, of all layers that have one: new, or in force."""
        known = {name: self._results.get(name, one.result) for name, one in self._set.made.items()}
        return {name: result for name, result in known.items() if result is not None}

    def parameters_changed(self, name: str, changed: Set[str]) -> None:
        """Evaluates a layer with its new parameters, as far as needed. Errors as for compute()."""
        layer = self._set.made[name]
        self._params[name] = layer.params
        if not changed.isdisjoint(("combination_weight", "enabled")):
            self._weights.add(name)
        if not layer.params["enabled"]:
            self._take(name)
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
        inputs = self._take(name)

        def evaluate() -> LayerResult:
            layer.announce(self._mesh_map.geometry)
            return layer.evaluate(self._mesh_map, inputs)

        self._put(name, self._call(name, evaluate), inputs)

    def update(self, name: str) -> None:
        """Evaluates a layer whose own data have changed, or that is behind, if it is enabled.

        Errors as for compute().
        """
        layer = self._set.made[name]
        inputs = self._take(name)
        if not layer.params["enabled"]:
            return
        before, behind = self.results.get(name), self._behind[name] or _NOTHING
        if self._has_failed(name) or before is None or behind.anew:
            self.compute(name)
            return
        returned = self._call(
            name, lambda: layer.update(self._mesh_map, inputs, behind.vertices, before)
        )
        self._put(name, checked(returned, len(before.costs)), inputs)

    def _reuse(self, name: str) -> None:
        """Takes the costs as they are, with other parameters. Errors as for compute()."""
        layer, before = self._set.made[name], self.results[name]
        with self._mesh_map.between_changes():
            inputs = self._inputs(name)
        reused = None
        if not self._has_failed(name):
            reused = self._call(name, lambda: layer.reuse(before.costs, self._mesh_map, inputs))
        if reused is None:
            self.compute(name)
        else:
            self._put(name, checked(reused, len(before.costs)), inputs)

    def _call(self, name: str, work: Callable[[], Answer]) -> Answer:
        """Calls a layer; of those without data of sensors, kernels leave the cores to the others:
        what a robot sees comes first."""

        def in_background() -> Answer:
            with _kernels._BackgroundLoops():
                return work()

        sensing = name in self._set.sensing
        return self._set.workers[name].call(work if sensing else in_background)

    def fail(self, name: str, error: BaseException) -> None:
        """Notes that a layer could not be evaluated: it keeps the result before, if it has one."""
        self._failed[name] = error_line(error)

    def commit(self) -> LayerSet:
        """Gives the layers their new results, and logs failures; returns the layers as they are
        then. No other change may be committed meanwhile."""
        after = self._set.changed()
        after.params.update(self._params)
        for name, inputs in self._used.items():
            layer = after.made[name]
            layer.evaluated(self._results.get(name, layer.result), self._mesh_map, inputs)
            failed = after.stale.pop(name, "") or after.errors.pop(name, "")
            if failed and name not in self._failed:
                after.logged.pop(name, None)
                _LOG.info("layer %s is up to date again", name)
        after.layers = {name: one for name, one in after.made.items() if one.result is not None}
        self._note_who_is_behind(after)
        for name, reason in self._failed.items():
            stands = name in after.layers
            (after.stale if stands else after.errors)[name] = reason
            _log_failure(after.logged, name, reason, stands)
        return after

    def changed_vertices(self) -> np.ndarray:
        """(K,) ascending: where any result differs in anything."""
        changed = [difference.read for difference in self.differences.values()]
        return union(changed, len(self._mesh_map.vertices))

    def _note_who_is_behind(self, after: LayerSet) -> None:
        for name, behind in self._behind.items():
            if after.behind.get(name) is behind:
                after.behind.pop(name, None)  # else more has changed since it was taken
        changed = self._weights.union(self.differences)
        for name, layer in self._made.items():
            read = changed.intersection(after.reads[name])
            anew = layer.READS_WEIGHTS and not self._weights.isdisjoint(read)
            parts = [self.differences[other].read for other in read if other in self.differences]
            if after.params[name]["enabled"] and (parts or anew):
                more = Behind(union(parts, len(self._mesh_map.vertices)), anew)
                after.behind[name] = more.joined(after.behind.get(name))

    def _take(self, name: str) -> Dict[str, LayerInput]:
        """What a layer reads, to evaluate it: then it is not behind any more."""
        with self._mesh_map.between_changes():
            self._behind[name] = self._set.behind.get(name)
            return self._inputs(name)

    def _inputs(self, name: str) -> Dict[str, LayerInput]:
        inputs = self._set.inputs_of(name, self.results)
        for other in inputs.keys() & self._params.keys():
            inputs[other] = as_input(self._params[other], inputs[other][:3])
        return inputs

    def _has_failed(self, name: str) -> bool:
        """Whether its last evaluation failed, so that more than the differences is to be done."""
        return name in self._set.stale

    def _put(self, name: str, result: LayerResult, inputs: Dict[str, LayerInput]) -> None:
        self._failed.pop(name, None)
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
            self._results[name] = result


def _log_failure(logged: Dict[str, float], name: str, reason: str, stands: bool) -> None:
    """Not each time: a layer may fail with every cloud of a sensor."""
    now = time.monotonic()
    if now - logged.get(name, -math.inf) >= FAILURE_PERIOD:
        logged[name] = now
        what = "stays as it was" if stands else "is left out"
        _LOG.error("layer %s %s: %s", name, what, reason)
