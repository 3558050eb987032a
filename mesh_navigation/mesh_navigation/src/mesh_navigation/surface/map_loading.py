"""Maps for planning without ROS: a file, and layers as in the parameters of a node."""

import logging
import os
from typing import Any, Callable, Mapping, Optional, Sequence, Union

from mesh_map.base.errors import MeshMapError
from mesh_map.costs.settings import SETTINGS
from mesh_map.geometry.coordinates import checked_origin
from mesh_map.io.map_parameters import map_parameters, parameters_in_file
from mesh_map.io.map_source import MapSource
from mesh_map.map.coarse_edges import coarse_remark
from mesh_map.map.mesh_map import MeshMap

Progress = Callable[[float, str], None]
_LOG = logging.getLogger("mesh_navigation")


def load_map(
    path: Union[str, "os.PathLike[str]"],
    layers: Union[None, str, "os.PathLike[str]", Mapping[str, Any]] = None,
    part: str = "",
    progress: Optional[Progress] = None,
    origin: Optional[Sequence[float]] = None,
    robot_radius: float = 0.0,
    max_edge_length: Optional[float] = None,
) -> MeshMap:
    """Read a map and compute its layers. Layers that are stored in the file are used if they fit.

    Args:
        path: a map file, or a mesh of any format that can be imported.
        layers: a YAML file with what a node has below ~mesh_map (the list ``layers``, and below
            each one's name its parameters; ``edge_cost_factor`` and other settings), or the same
            as a mapping. None: no layers, every vertex is free.
        part: which mesh of a map file; empty: mesh, or the only one.
        progress: called with the share that is done, 0 to 1, and what comes next.
        origin: x, y, z (m), subtracted from the coordinates of a mesh before they are rounded to
            float32: those of a UTM zone need it. The map's frame begins there. None: that of
            ``layers``, else that of the file.
        robot_radius: (m) for which edges of the mesh may be too long, which is logged once, as it
            is for the radii of layers; 0: of a point.
        max_edge_length: (m) the map has no longer edges, see the parameter of that name of
            mesh_map; 0: the mesh as it is. None: that of ``layers``, else 0.

    Raises:
        MeshMapError: a file that cannot be read, coordinates that need another origin, or a
            required layer that cannot be used: a plan that does not know of it might lead anywhere.
    """
    configuration = dict(_configuration(layers))
    configuration["mesh_file"] = os.fspath(path)
    if part:
        configuration["mesh_part"] = part
    if origin is not None:
        configuration["origin"] = checked_origin(origin).tolist()
    if max_edge_length is not None:
        configuration["max_edge_length"] = max_edge_length
    parameters = map_parameters(configuration)
    progress = progress or (lambda share, what: None)
    progress(0.0, f"reading {parameters.mesh_file}")
    source = MapSource(parameters.mesh_file, parameters.mesh_part, parameters.origin)
    source.require_provenance = parameters.require_provenance
    mesh_map = source.make_map(parameters.global_frame, **parameters.geometry)
    names = [parameter.name for parameter in SETTINGS]
    mesh_map.set_settings(**{name: configuration[name] for name in names if name in configuration})
    mesh_map.compute_layers(
        parameters.layers, progress, source.stored_costs, on_trust=source.costs_on_trust
    )
    if mesh_map.fault:
        raise MeshMapError(mesh_map.fault)
    for name, layer in mesh_map.layers.items():
        if layer.can_be_cleared() and layer.params["enabled"]:
            _LOG.warning("layer %s is empty: there is no sensor here", name)
    remark = coarse_remark(mesh_map, {"the robot's radius": robot_radius})
    if remark:
        _LOG.warning("%s", remark)
    return mesh_map


def _configuration(layers: Any) -> Mapping[str, Any]:
    if layers is None:
        return {}
    if isinstance(layers, Mapping):
        return layers
    if isinstance(layers, (str, os.PathLike)):
        return parameters_in_file(layers)
    text = f"layers is {layers!r}, neither a file nor a mapping"
    raise MeshMapError(text, "{'layers': [{'name': ..., 'type': ...}]} is one")
