"""The parts of layers that talk to ROS: found, started and ended."""

import importlib
import logging
from contextlib import ExitStack

from mesh_map.base.errors import MeshMapError, error_line
from mesh_map.costs.layer import Layer
from mesh_map.map.mesh_map import MeshMap
from mesh_map.ros.ros_adapter import RosAdapter

_LOG = logging.getLogger("mesh_map")


def start_adapters(namespace: str, mesh_map: MeshMap, in_use: ExitStack) -> None:
    """Starts the adapters of all layers of a map that name one, and has them ended with the stack.

    One that cannot be used is logged in one line, and the others go on.

    Args:
        namespace: of the map; a layer's own is below it.
        mesh_map: whose layers get data.
        in_use: what ends with the map.
    """
    for layer in mesh_map.layers.values():
        if not layer.ROS_ADAPTER:
            continue
        try:
            own = "%s/%s" % (namespace.rstrip("/"), layer.name)
            in_use.callback(_end, _started(own, mesh_map, layer))
        except Exception as error:  # a stranger's plugin may fail in any way
            _LOG.error("layer %s gets no data from topics: %s", layer.name, error_line(error))


def _end(adapter: RosAdapter) -> None:
    try:
        adapter.shutdown()
    except Exception as error:  # of a stranger's; the others have to end, too
        _LOG.error("layer %s: %s", adapter.layer.name, error_line(error))


def _started(namespace: str, mesh_map: MeshMap, layer: Layer) -> RosAdapter:
    module_name, _, class_name = layer.ROS_ADAPTER.rpartition(".")
    if not module_name:
        raise MeshMapError("%r is no module.Class" % layer.ROS_ADAPTER)
    found = getattr(importlib.import_module(module_name), class_name)
    if not (isinstance(found, type) and issubclass(found, RosAdapter)):
        raise MeshMapError("%s is no mesh_map.ros.ros_adapter.RosAdapter" % layer.ROS_ADAPTER)
    return found(namespace, mesh_map, layer, lambda: mesh_map.refresh_layer(layer.name))
