"""Which layers do not stand, and why."""

import threading
from typing import Callable, Dict, Mapping

from mesh_map.base.errors import PLUGIN_FAILURES, error_line
from mesh_map.costs.layer_set import LayerSet


class LayerFaults:
    """What is known of failures beside the layers themselves: what sensors say. For any thread."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._without_data: Dict[str, str] = {}
        self._data_watches: Dict[str, Callable[[], str]] = {}

    def set_without_data(self, name: str, reason: str) -> None:
        """Notes why a layer gets no data of sensors; "": it does."""
        with self._lock:
            others = {key: self._without_data[key] for key in self._without_data if key != name}
            self._without_data = {**others, name: reason} if reason else others

    def watch_data(self, name: str, look: Callable[[], str]) -> None:
        """From now on, look() says why the data of a layer are not current."""
        with self._lock:
            self._data_watches = {**self._data_watches, name: look}

    def forget(self) -> None:
        """All layers are replaced."""
        with self._lock:
            self._without_data, self._data_watches = {}, {}

    def errors(self, layers: LayerSet, default_layer: str) -> Dict[str, str]:
        """name -> one line, for layers that are left out; default_layer where it is none."""
        errors = dict(layers.errors)
        if default_layer and layers.layers and default_layer not in layers.layers:
            errors.setdefault("default_layer", no_default_layer(default_layer))
        return errors

    def lasting(self, layers: LayerSet, default_layer: str) -> Dict[str, str]:
        """name -> one line, for what does not go by itself."""
        of_layers = {**layers.stale, **self._without_data, **layers.hanging()}
        return {**self.errors(layers, default_layer), **_of_enabled(layers, of_layers)}

    def gaps(self, layers: LayerSet) -> Dict[str, str]:
        """name -> one line, for what goes when sensors speak again."""
        found = {name: _looked(look) for name, look in self._data_watches.items()}
        return _of_enabled(layers, {name: reason for name, reason in found.items() if reason})


def of_required(failures: Mapping[str, str], layers: LayerSet, default_layer: str) -> str:
    """The failures of layers that are required, in one line."""
    optional = layers.optional
    if default_layer in optional:
        optional = optional | {"default_layer"}
    return "; ".join(
        "%s: %s" % (_shown(name), reason)
        for name, reason in failures.items()
        if name not in optional
    )


def no_default_layer(name: str) -> str:
    """What is wrong with a default_layer that is none of the layers."""
    return "%s is no layer: all layers are combined" % name


def _of_enabled(layers: LayerSet, reasons: Mapping[str, str]) -> Dict[str, str]:
    return {
        name: reason
        for name, reason in reasons.items()
        if name in layers.layers and layers.params[name]["enabled"]
    }


def _looked(look: Callable[[], str]) -> str:
    try:
        return look()
    except PLUGIN_FAILURES as error:  # what cannot be looked at is not current
        return error_line(error)


def _shown(name: str) -> str:
    """How a failure is named: of a layer, "layer N" of the list, or the list itself."""
    unnamed = name.startswith("layer ") or name in ("layers", "default_layer")
    return name if unnamed else "layer " + name
