"""The parts of layers that talk to ROS: found, started and ended."""

import importlib
import logging
from typing import List

from mesh_map.base.errors import MeshMapError, error_line
from mesh_map.costs.layer import Layer
from mesh_map.map.mesh_map import MeshMap
from mesh_map.ros.ros_adapter import RosAdapter

_LOG = logging.getLogger("mesh_map")


class LayerAdapters:
    """The adapters of all layers of a map that name one."""

    def __init__(self, namespace: str, mesh_map: MeshMap) -> None:
        """Starts them. One that cannot be used is logged in one line, and the others go on.

        namespace: of the map; a layer's own is below it.
        """
        self._adapters: List[RosAdapter] = []
        for layer in mesh_map.layers.values():
            if not layer.ROS_ADAPTER:
                continue
            try:
                own = "%s/%s" % (namespace.rstrip("/"), layer.name)
                self._adapters.append(_started(own, mesh_map, layer))
            except Exception as error:  # a stranger's plugin may fail in any way
                _LOG.error("layer %s gets no data from topics: %s", layer.name, error_line(error))

    def shutdown(self) -> None:
        """Ends them all."""
        for adapter in self._adapters:
            try:
                adapter.shutdown()
            except Exception as error:  # of a stranger's; the others have to end, too
                _LOG.error("layer %s: %s", adapter.layer.name, error_line(error))
        self._adapters = []


def _started(namespace: str, mesh_map: MeshMap, layer: Layer) -> RosAdapter:
    module_name, _, class_name = layer.ROS_ADAPTER.rpartition(".")
    if not module_name:
        raise MeshMapError("%r is no module.Class" % layer.ROS_ADAPTER)
    found = getattr(importlib.import_module(module_name), class_name)
    if not (isinstance(found, type) and issubclass(found, RosAdapter)):
        raise MeshMapError("%s is no mesh_map.ros.ros_adapter.RosAdapter" % layer.ROS_ADAPTER)
    return found(namespace, mesh_map, layer, lambda: mesh_map.refresh_layer(layer.name))
