"""dynamic_reconfigure for a map and its layers."""

import dataclasses
import logging
from contextlib import ExitStack
from functools import partial
from typing import Callable, Dict, Mapping

from mesh_map.base.parameter import Parameter, Value, checked_values
from mesh_map.costs.layer import Layer
from mesh_map.costs.settings import SETTINGS
from mesh_map.map.mesh_map import MeshMap
from mesh_map.ros.parameter_server import ParameterServer, serve

_LOG = logging.getLogger("mesh_map")

# Released configurations set them; nothing has ever depended on them.
WITHOUT_EFFECT = (
    Parameter("cost_limit", 1.0, 0.0, 10.0, "of release 1.x, without effect; planners have theirs"),
    Parameter("min_contour_size", 3, 0, 100000, "of release 1.x, without effect"),
)
MAP_PARAMETERS = SETTINGS + WITHOUT_EFFECT


def serve_map(
    namespace: str,
    mesh_map: MeshMap,
    values: Mapping[str, Value],
    in_use: ExitStack,
    on_change: Callable[[], None],
) -> None:
    """Starts a server at the namespace of the map, and one below it for each layer.

    Args:
        namespace: of the map, resolved.
        mesh_map: its settings and layers are what is changed.
        values: of WITHOUT_EFFECT, checked.
        in_use: with which they end.
        on_change: called when parameters of a layer have changed.
    """
    layers = ("",) + tuple(mesh_map.made_layers)
    parameters = [
        dataclasses.replace(parameter, choices=layers)
        if parameter.name == "default_layer"
        else parameter
        for parameter in MAP_PARAMETERS
    ]
    without_effect = {p.name: values[p.name] for p in WITHOUT_EFFECT}

    def set_map(changed: Dict[str, Value]) -> Mapping[str, Value]:
        own = {name: changed.pop(name, before) for name, before in without_effect.items()}
        checked, warnings = checked_values(WITHOUT_EFFECT, own)
        for warning in warnings:
            _LOG.warning("%s", warning)
        if changed:
            mesh_map.set_settings(**changed)
        without_effect.update(checked)
        return {**checked, **dataclasses.asdict(mesh_map.settings)}

    present = {**without_effect, **dataclasses.asdict(mesh_map.settings)}
    in_use.callback(ParameterServer(namespace, parameters, present, set_map).shutdown)
    for layer in mesh_map.made_layers.values():
        server = partial(_layer_server, namespace, mesh_map, layer, on_change)
        serve(in_use, "layer " + layer.name, server)


def _layer_server(
    namespace: str, mesh_map: MeshMap, layer: Layer, on_change: Callable[[], None]
) -> ParameterServer:
    own = "%s/%s" % (namespace.rstrip("/"), layer.name)

    def change(values: Dict[str, Value]) -> Mapping[str, Value]:
        kept = mesh_map.set_layer_parameters(layer.name, values)
        on_change()
        return kept

    return ParameterServer(own, layer.all_parameters(), layer.params, change)
