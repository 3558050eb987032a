"""The parts of layers that talk to ROS: found, started and ended."""

import importlib
import logging
from contextlib import ExitStack
from functools import partial
from typing import Set

from mesh_map.base.errors import PLUGIN_FAILURES, MeshMapError, error_line
from mesh_map.costs.layer import Layer
from mesh_map.map.mesh_map import MeshMap
from mesh_map.ros.ros_adapter import RosAdapter

_LOG = logging.getLogger("mesh_map")


class LayerAdapters:
    """The adapters of all layers of a map that name one, from the first result of each layer on.

    One that cannot be used is logged in one line, and its layer does not stand; the others go on.
    """

    def __init__(self, namespace: str, mesh_map: MeshMap, in_use: ExitStack) -> None:
        """
        Args:
            namespace: of the map; a layer's own is below it.
            mesh_map: whose layers get data.
            in_use: with which they end.
        """
        self._namespace, self._map, self._in_use = namespace.rstrip("/"), mesh_map, in_use
        self._begun: Set[str] = set()

    def start(self) -> None:
        """Starts those that are new; by one thread at a time."""
        for name, layer in self._map.layers.items():
            if not layer.ROS_ADAPTER or name in self._begun:
                continue
            self._begun.add(name)
            try:
                own = "%s/%s" % (self._namespace, name)
                worker = self._map.layer_set.workers[name]
                self._in_use.callback(_end, worker.call(partial(_started, own, self._map, layer)))
            except PLUGIN_FAILURES as error:
                reason = "it gets no data from topics: %s" % error_line(error)
                _LOG.error("layer %s: %s", name, reason)
                self._map.set_without_data(name, reason)


def _end(adapter: RosAdapter) -> None:
    try:
        adapter.shutdown()
    except PLUGIN_FAILURES as error:  # the others have to end, too
        _LOG.error("layer %s: %s", adapter.layer.name, error_line(error))


def _started(namespace: str, mesh_map: MeshMap, layer: Layer) -> RosAdapter:
    module_name, _, class_name = layer.ROS_ADAPTER.rpartition(".")
    if not module_name:
        raise MeshMapError("%r is no module.Class" % layer.ROS_ADAPTER)
    found = getattr(importlib.import_module(module_name), class_name)
    if not (isinstance(found, type) and issubclass(found, RosAdapter)):
        raise MeshMapError("%s is no mesh_map.ros.ros_adapter.RosAdapter" % layer.ROS_ADAPTER)
    refresh = partial(mesh_map.refresh_layer, layer.name, wait=False)
    return found(namespace, mesh_map, layer, refresh)
