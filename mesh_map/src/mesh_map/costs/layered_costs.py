"""Layers on a mesh, what follows from them, and how they are changed while in use."""

import contextlib
import contextvars
import copy
import logging
import threading
from functools import partial
from typing import (
    Any,
    Callable,
    Dict,
    Iterable,
    Iterator,
    List,
    Mapping,
    NamedTuple,
    Optional,
    Tuple,
)

import numpy as np

from mesh_map.base.errors import PLUGIN_FAILURES, MeshMapError, error_line
from mesh_map.base.parameter import Value
from mesh_map.costs.background_work import BackgroundWork
from mesh_map.costs.cleared_costs import ClearedCosts, ClearedCostsMemory, Combined
from mesh_map.costs.combination import COMBINED_COSTS, Combination
from mesh_map.costs.edge_weights import PlanningCosts
from mesh_map.costs.layer import OF_ALL, Layer
from mesh_map.costs.layer_changes import (
    Listener,
    Listeners,
    PendingChanges,
    ResultDifference,
    different,
)
from mesh_map.costs.layer_faults import LayerFaults, no_default_layer, of_required
from mesh_map.costs.layer_set import LayerSet, OnLayer, Progress, StoredCosts
from mesh_map.costs.propagation import Propagation
from mesh_map.costs.settings import MapSettings
from mesh_map.costs.trust import CostsOnTrust
from mesh_map.geometry.mesh_geometry import MeshGeometry

_LOG = logging.getLogger("mesh_map")
# The maps that are being changed by who asks, or by whom that one works for.
_CHANGING: "contextvars.ContextVar[Tuple[LayeredCosts, ...]]" = contextvars.ContextVar(
    "changing", default=()
)


class _State(NamedTuple):
    """All that readers see; replaced as a whole."""

    layer_set: LayerSet
    settings: MapSettings
    combination: Combination
    combined: Tuple[str, ...]  # names of the layers in it
    planning: PlanningCosts


class LayeredCosts:
    """Cost layers on one geometry, and their combination. All arrays are read-only.

    Changes (compute_layers, set_layer_parameters, refresh_layer, clear_layers, set_settings) may be
    made from any thread. Those of one layer are made one after the other; others do not wait for
    each other. All else may be read meanwhile, and never waits. Each layer comes into force as soon
    as it is evaluated, and those that read it, one after the other, behind it: until then,
    `stale_layers` names them. A change returns when that is done, or another thread does it; one
    that sensors make need not wait for it (see refresh_layer, catch_up). Only `params` of the layer
    in question are new while it is evaluated.

    Attributes:
        geometry: the mesh; may be shared with other maps.
        layer_timeout: seconds per started million of faces that a call of a layer may take, for
            compute_layers(); then it counts as failed, and is not called any more. None (the
            default): no limit, and layers are called in the thread of the caller.
    """

    def __init__(self, geometry: MeshGeometry) -> None:
        """No layers: every vertex is free."""
        self.geometry = geometry
        self.layer_timeout: Optional[float] = None
        self._lock = threading.RLock()  # of the state: held for moments
        self._computing = threading.Lock()
        self._listeners = Listeners()
        self._changes = PendingChanges()
        self._background = BackgroundWork(self._go_on, "layers")
        combination = Combination([], len(geometry.vertices))
        settings = MapSettings()
        planning = PlanningCosts(0, combination.costs, geometry, settings)
        self._faults = LayerFaults()
        self._cleared = ClearedCostsMemory()
        self._state = _State(LayerSet(), settings, combination, (), planning)

    @property
    def layers(self) -> Dict[str, Layer]:
        """name -> Layer, in the order of evaluation; only those that have a result."""
        return self._state.layer_set.layers

    @property
    def layer_set(self) -> LayerSet:
        """All that is known of the layers."""
        return self._state.layer_set

    @property
    def made_layers(self) -> Dict[str, Layer]:
        """name -> Layer, in the order of evaluation; those that are left out, but exist, too."""
        return self._state.layer_set.made

    @property
    def layer_errors(self) -> Dict[str, str]:
        """name -> one line, for the layers that are left out; default_layer where it is none."""
        return self._faults.errors(*self._set_and_default)

    @property
    def layer_failures(self) -> Dict[str, str]:
        """name -> one line, for all that is enabled and does not stand: layers that are left out,
        whose last evaluation failed or hangs (they have the result before), that get no data, or
        whose data are not current."""
        layers, default_layer = self._set_and_default
        return {**self._faults.gaps(layers), **self._faults.lasting(layers, default_layer)}

    @property
    def stale_layers(self) -> Tuple[str, ...]:
        """Names of layers whose inputs are newer than they are: they are being evaluated, or will
        be next. All else is in the costs already, and what stale layers said before."""
        return tuple(self._state.layer_set.behind)

    @property
    def fault(self) -> str:
        """Why nothing should be planned or driven on these costs, in one line: the required layers
        that do not stand, and the reasons. Empty where all of them do."""
        return of_required(self.layer_failures, *self._set_and_default)

    @property
    def lasting_fault(self) -> str:
        """What of `fault` does not go by itself."""
        return of_required(self._faults.lasting(*self._set_and_default), *self._set_and_default)

    @property
    def gap(self) -> str:
        """What of `fault` goes when sensors speak again: whoever drives stands until then."""
        return of_required(self._faults.gaps(self.layer_set), *self._set_and_default)

    @property
    def _set_and_default(self) -> Tuple[LayerSet, str]:
        state = self._state
        return state.layer_set, state.settings.default_layer

    @property
    def costs(self) -> np.ndarray:
        """(V,) float32, all layers in one: >= 0, +inf lethal, NaN unknown; zeros without layers."""
        return self._state.combination.costs

    @property
    def settings(self) -> MapSettings:
        """How costs are combined, and what they mean to planners."""
        return self._state.settings

    def planning_costs(self) -> PlanningCosts:
        """Costs and weights of edges that belong together; keeps what it is for good."""
        return self._state.planning

    def cleared_costs(self) -> ClearedCosts:
        """What the costs would be if the layers that can be cleared were empty. Takes the time of
        evaluating the layers that read those, where other layers have changed since the last
        call."""
        state = self._state
        mesh_map: Any = self
        return self._cleared.of(mesh_map, state.layer_set, state.planning, state.settings)

    @property
    def clearable_layers(self) -> Tuple[str, ...]:
        """Names of the layers that can be cleared, are enabled, and whose data are current."""
        layer_set, failures = self._state.layer_set, self.layer_failures
        return tuple(
            name
            for name, layer in layer_set.layers.items()
            if layer.can_be_cleared() and layer_set.params[name]["enabled"] and name not in failures
        )

    def compute_layers(
        self,
        config: Any,
        progress: Optional[Progress] = None,
        stored: Optional[StoredCosts] = None,
        on_layer: Optional[OnLayer] = None,
        on_trust: Optional[CostsOnTrust] = None,
    ) -> None:
        """Loads and evaluates layers in order, and combines them. Replaces what was there.

        A layer that cannot be used is logged in one line, noted in layer_errors, and left out; the
        others go on. So is one whose "inputs" name one that is left out, or which reads itself over
        others. If default_layer is none of the layers, that is logged, and all are combined.

        Listeners are told of all costs that differ from those before of the same name.

        Args:
            config: list of {"name": ..., "type": ..., "required": ..., "params": {...}}; other
                members of an entry are parameters that "params" does not have. Where a layer that
                is required (the default) does not stand, `fault` says so; without one that is not,
                the others go on, also those that read it.
            progress: called with the share that is done (0 to 1) and what comes next. What it
                or on_layer raises ends the computation and leaves everything as it was.
            stored: gives costs (V,) that a layer (of a name) had before with the same
                fingerprint(), or None.
            on_layer: called with each layer as soon as it has its result.
            on_trust: gives costs (V,) that stand, without a word on how they were made, under the
                name that the release has for a layer's type, or None; None: there are none.
        """
        with self._change(), self._computing:
            layer_set = LayerSet.computed(self, config, progress, stored, on_layer, on_trust)
            settings = self.settings
            if settings.default_layer and settings.default_layer not in layer_set.layers:
                _LOG.error("default_layer %s", no_default_layer(settings.default_layer))
            if progress:
                progress(1.0, "done")
            with self._lock:
                shown = {}
                for name, layer in layer_set.layers.items():
                    known = self.layers[name].result if name in self.layers else None
                    shown[name] = ResultDifference.between(known, layer.result).shown
                self._commit(layer_set, self.settings, shown)
                self._faults.forget()

    def set_layer_parameters(self, name: str, values: Mapping[str, Any]) -> Dict[str, Value]:
        """Changes parameters of a layer, and evaluates it and those that read it where needed.

        A value out of its range is moved to the limit with a warning; an unknown name is logged.
        Nothing is evaluated where nothing changes, and only the combination where `factor` does. A
        layer that is left out takes its place as soon as it can be evaluated.

        Returns:
            all parameters of the layer as they are now.
        Raises:
            MeshMapError: no such layer, a value that is NaN or of another type, or the layer cannot
                be evaluated with these: then nothing has changed.
        """
        with self._change(), self._locked([name]):
            layer = self._layer(name)
            params, warnings = self._checked_changes(layer, values)
            for warning in warnings:
                _LOG.warning("layer %s: %s", name, warning)
            before = layer.params
            changed = {key for key in params if params[key] != before.get(key)}
            if changed:
                layer.params = params
                try:
                    propagation = Propagation(self)
                    propagation.parameters_changed(name, changed)
                    self._put_in_force(propagation)
                except BaseException as error:
                    layer.params = before
                    if isinstance(error, MeshMapError) or not isinstance(error, PLUGIN_FAILURES):
                        raise
                    raise MeshMapError("layer %s: %s" % (name, error_line(error))) from error
            return dict(layer.params)

    def refresh_layer(self, name: str, wait: bool = True) -> None:
        """Evaluates a layer whose own data have changed, and those that read it.

        A layer that fails stays as it was, which is logged.

        Args:
            name: of the layer.
            wait: for those that read it. If not, this returns as soon as the layer is in force, and
                a thread of the map evaluates them, again and again while more data come: whoever
                hands over what sensors see does not wait for others. See catch_up().
        Raises:
            MeshMapError: no such layer.
        """
        with self._change(wait), self._locked([name]):
            self._layer(name)
            propagation = Propagation(self)
            try:
                propagation.update(name)
            except PLUGIN_FAILURES as error:
                propagation.fail(name, error)
            self._put_in_force(propagation)

    def catch_up(self) -> None:
        """Returns when all layers that are behind now (`stale_layers`) have been evaluated with
        what they read by now, each once: by this thread, or by others, for which it waits.

        Raises:
            MeshMapError: called by what a change has called.
        """
        with self._change(wait=False):
            self._catch_up(wait=True)

    def set_without_data(self, name: str, reason: str) -> None:
        """Notes why a layer gets no data of sensors, so that it does not stand; "": it does."""
        self._faults.set_without_data(name, reason)

    def watch_data(self, name: str, look: Callable[[], str]) -> None:
        """From now on, look() says why the data of a layer are not current, so that it does not
        stand; "" while they are. It is called whenever somebody wants to know, from any thread, and
        must not wait for anything."""
        self._faults.watch_data(name, look)

    def layers_to_store(self) -> Tuple[Dict[str, Layer], Dict[str, str]]:
        """Copies of all layers that stand and may be stored, and why others cannot be.

        Result, parameters and identity of each belong together. Waits for layers that are being
        evaluated, one after the other; the others may change meanwhile. A layer that does not say
        in time how it was made hangs.

        Returns:
            name -> layer, its `identity` is known; name -> one line, of those that fail to say it.
        Raises:
            MeshMapError: called by what a change has called.
        """
        found: Dict[str, Layer] = {}
        errors: Dict[str, str] = {}
        for name in self.layer_set.made:
            with self._change(wait=False), self._locked([name]):
                layer = self.layers.get(name)
                if layer is None or not (layer.STORABLE and layer.params["enabled"]):
                    continue
                if name in self.layer_failures:
                    continue  # its costs are those of before
                kept = copy.copy(layer)
                try:
                    worker = self.layer_set.workers[name]
                    layer.identity = worker.call(partial(getattr, kept, "identity"))
                    found[name] = kept
                except PLUGIN_FAILURES as error:
                    errors[name] = error_line(error)
                    _LOG.error("layer %s cannot be stored: %s", name, errors[name])
        return found, errors

    def clear_layers(self, names: Optional[Iterable[str]] = None) -> Dict[str, int]:
        """Has layers forget what sensors have seen, and evaluates them and those that read them.

        A layer that fails is logged; the others go on.

        Args:
            names: of layers; None for all that can be cleared.
        Returns:
            name -> how many things a layer forgot, of those that could be cleared.
        Raises:
            MeshMapError: no such layer; then nothing has changed.
        """
        counts: Dict[str, int] = {}
        asked = [self._layer(name) for name in (self.layers if names is None else names)]
        layers = [layer for layer in asked if layer.can_be_cleared()]
        with self._change(), self._locked(layer.name for layer in layers):
            propagation = Propagation(self)
            for layer in layers:
                try:
                    worker = self.layer_set.workers[layer.name]
                    count = int(worker.call(layer.clear))
                    propagation.update(layer.name)
                    counts[layer.name] = count
                except PLUGIN_FAILURES as error:
                    propagation.fail(layer.name, error)
            self._put_in_force(propagation)
        return counts

    def set_settings(self, **values: Any) -> MapSettings:
        """Changes settings (see mesh_map.costs.settings); takes effect at once.

        Returns:
            all settings as they are now; numbers out of range are moved to the limit.
        Raises:
            MeshMapError: an unknown name, a wrong type, none of the choices, or a default_layer
                that is none of the layers (any will do before there are layers): then nothing has
                changed.
        """
        with self._change(), self._lock:
            settings, warnings = self.settings.changed(values)
            chosen = settings.default_layer
            if "default_layer" in values and chosen and self.layers and chosen not in self.layers:
                raise MeshMapError(
                    "default_layer is %s, which is no layer" % chosen,
                    "known: " + ", ".join(self.layers),
                )
            for warning in warnings:
                _LOG.warning("%s", warning)
            if settings != self.settings:
                self._commit(self._state.layer_set, settings, {})
        return settings

    @contextlib.contextmanager
    def unchanged(self) -> Iterator[None]:
        """Within, no other thread changes anything: for reading what belongs together.

        Waits for layers that are being evaluated.
        """
        try:
            with self._locked(self.layer_set.made), self._lock:
                yield
        finally:
            if self.stale_layers and self not in _CHANGING.get():
                with self._change():
                    pass  # what others have left to this thread

    @contextlib.contextmanager
    def between_changes(self) -> Iterator[None]:
        """Within, nothing comes into force: for moments."""
        with self._lock:
            yield

    @contextlib.contextmanager
    def _locked(self, names: Iterable[str]) -> Iterator[None]:
        """See LayerSet.locked(); what is no layer is left alone."""
        names = set(names)
        while True:
            layer_set = self.layer_set
            with layer_set.locked(name for name in layer_set.made if name in names):
                if self.layer_set.made is layer_set.made:
                    yield
                    return

    @contextlib.contextmanager
    def _change(self, wait: bool = True) -> Iterator[None]:
        """No change from within another one; then layers that read what has changed are evaluated,
        by this thread if it waits for them, and listeners are told."""
        if self in _CHANGING.get():
            raise MeshMapError("the map cannot be changed by what a change of it has called")
        token = _CHANGING.set((*_CHANGING.get(), self))
        try:
            try:
                yield
            finally:
                if wait:
                    self._catch_up()
                self._leave_the_rest()
        finally:
            _CHANGING.reset(token)
            with self._lock:
                costs = {name: layer.result.costs for name, layer in self.layers.items()}
                self._listeners.put(self._changes.taken({**costs, COMBINED_COSTS: self.costs}))
            self._listeners.tell()

    def add_listener(self, listener: Listener) -> None:
        """Calls listener(changes) after each change of costs, in the order of the changes.

        changes: a list of LayerChange, of layers in the order of evaluation, "Combined Costs" last;
        what is as before is not in it. It is called by the thread that made the change, or one that
        is just calling for an earlier one, without any lock of the map. Whoever makes changes waits
        for it, so it should be quick. What it raises is logged.
        """
        self._listeners.add(listener)

    def remove_listener(self, listener: Listener) -> None:
        """Ends what add_listener() began."""
        self._listeners.remove(listener)

    def _layer(self, name: str) -> Layer:
        made = self._state.layer_set.made
        if name not in made:
            reason = self.layer_errors.get(name)
            known = "it is left out: %s" % reason if reason else "known: " + ", ".join(self.layers)
            raise MeshMapError("there is no layer %s" % name, known)
        return made[name]

    def _checked_changes(
        self, layer: Layer, values: Mapping[str, Any]
    ) -> Tuple[Dict[str, Value], List[str]]:
        worker, of_all = self.layer_set.workers[layer.name], {p.name for p in OF_ALL}
        if worker.fault and of_all.issuperset(values):
            return Layer.checked_changes(layer, values)  # one that hangs can be taken out
        try:
            return worker.call(lambda: layer.checked_changes(values))
        except MeshMapError:
            raise
        except PLUGIN_FAILURES as error:
            raise MeshMapError("layer %s: %s" % (layer.name, error_line(error))) from error

    def _put_in_force(self, propagation: Propagation) -> None:
        """A change of layers, at once; those who read them are behind from then on."""
        with self._lock:
            shown = {name: found.shown for name, found in propagation.differences.items()}
            self._commit(self.layer_set, self.settings, shown, propagation)

    def _catch_up(self, wait: bool = False) -> None:
        """Evaluates layers that are behind, in their order, each once.

        Those that another thread holds are waited for, or left to it: it looks for what is behind
        when it has let them go.
        """
        layer_set = self.layer_set
        for name in layer_set.made:
            lock = layer_set.workers[name].lock
            if name in self.layer_set.behind and lock.acquire(blocking=wait):
                try:
                    self._evaluate_behind(layer_set, name)
                finally:
                    lock.release()

    def _leave_the_rest(self) -> None:
        """What is behind, and held by nobody who would look here, is for the background."""
        layer_set = self.layer_set
        for name in layer_set.behind:
            lock = layer_set.workers[name].lock
            if lock.acquire(blocking=False):
                lock.release()
                self._background.ask()
                return

    def _evaluate_behind(self, layer_set: LayerSet, name: str) -> None:
        present = self.layer_set
        if present.made is not layer_set.made or name not in present.behind:
            return  # all layers have been replaced, or another thread was quicker
        propagation = Propagation(self)
        try:
            propagation.update(name)
        except PLUGIN_FAILURES as error:
            propagation.fail(name, error)
        with self._lock:
            if self.layer_set.made is layer_set.made:  # else all layers have been replaced
                self._put_in_force(propagation)

    def _go_on(self) -> None:
        with self._change():
            pass

    def _commit(
        self,
        layer_set: LayerSet,
        settings: MapSettings,
        shown: Mapping[str, np.ndarray],
        propagation: Optional[Propagation] = None,
    ) -> None:
        """Combines the layers, puts the new state in force, and has listeners told of it."""
        state = self._state
        changed_vertices = None
        if propagation is not None:
            changed_vertices = propagation.changed_vertices()
            layer_set = propagation.commit()
        results = {name: layer.result for name, layer in layer_set.layers.items()}
        mode, factors = Combined.of(layer_set, settings)
        combined = tuple(factors)
        changed_results = changed_vertices if combined == state.combined else None
        count, before = len(self.geometry.vertices), state.combination
        terms = [(results[name], factor) for name, factor in factors.items()]
        combination = Combination(terms, count, mode, before, changed_results)
        changed = different(before.costs, combination.costs).astype(np.uint32)
        for name, vertices in shown.items():
            self._changes.add(name, vertices, None)
        self._changes.add(COMBINED_COSTS, changed, before.costs)
        planning = state.planning
        if len(changed) or settings != state.settings:
            same_weights = (planning, changed) if settings == state.settings else ()
            planning = PlanningCosts(
                planning.version + 1, combination.costs, self.geometry, settings, *same_weights
            )
        self._state = _State(layer_set, settings, combination, combined, planning)
