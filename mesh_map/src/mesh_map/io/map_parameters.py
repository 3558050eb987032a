"""The parameters of a map, as ROS users write them, in a dictionary."""

import logging
import os
from dataclasses import dataclass
from typing import Any, List, Mapping, Optional, Tuple, Union

import yaml

from mesh_map.base.errors import MeshMapError
from mesh_map.base.parameter import Parameter, checked_values, misspelled
from mesh_map.costs.settings import SETTINGS

_LOG = logging.getLogger("mesh_map")
FILE_PARAMETERS = (
    Parameter(
        "mesh_file", "", description="map file (.h5), or a mesh (.ply .obj .stl .off .dae .glb)"
    ),
    Parameter("mesh_part", "", description="group of the map file; empty: mesh, or the only one"),
    Parameter("global_frame", "", description="frame of all messages; empty: that of the file"),
    Parameter("origin", (), description="x, y, z (m): subtracted from the coordinates"),
    Parameter(
        "require_provenance",
        False,
        description="true: layers in the file that do not say how they were computed are not used",
    ),
)
GEOMETRY_PARAMETERS = (
    Parameter("up_direction", (0.0, 0.0, 1.0), description="against which heights are measured"),
    Parameter("orient", False, description="turn faces so that neighbors agree, and most face up"),
    Parameter(
        "normals",
        "mean",
        description="normals of vertices: mean of the faces around, or weighted by their angle",
        choices=("mean", "angle"),
    ),
    Parameter(
        "max_edge_length",
        0.0,
        0.0,
        1000.0,
        "longer edges (m) are halved, with the faces around them, while the map is loaded; 0: none",
    ),
)


@dataclass(frozen=True)
class MapParameters:
    """Parameters that have been checked.

    mesh_file, mesh_part, global_frame, origin, require_provenance: as in the README; for
        MapSource.
    layers: the list for MeshMap.compute_layers().
    geometry: up_direction, orient, normals and max_edge_length, for MapSource.make_map().
    """

    mesh_file: str
    mesh_part: Optional[str]
    origin: Optional[Tuple[Any, ...]]
    global_frame: str
    require_provenance: bool
    layers: Any
    geometry: Mapping[str, Any]


def map_parameters(values: Any) -> MapParameters:
    """Reads parameters as ROS users write them: each layer has its own in a dictionary of its name.

    The layers are a list of {name, type, required}, or as for ROS 2 a list of names, with type and
    required among the parameters of the layer.

    Raises:
        MeshMapError: no mesh_file, or a value of the wrong type.
    """
    if not isinstance(values, Mapping):
        raise MeshMapError("the parameters are %r, not a dictionary" % (values,))
    checked, warnings = checked_values((*FILE_PARAMETERS, *GEOMETRY_PARAMETERS), values)
    for warning in warnings + _misspelled(values):
        _LOG.warning("%s", warning)
    if values.get("server_url") and not checked["mesh_file"]:
        raise MeshMapError("maps of a mesh server (server_url) are not supported", "set mesh_file")
    if not checked["mesh_file"]:
        raise MeshMapError("mesh_file is not set", "name a map file (.h5) or a mesh (.ply .obj …)")
    layers = values.get("layers", [])
    if isinstance(layers, list):
        layers = [_with_params(entry, values) for entry in layers]
    return MapParameters(
        checked["mesh_file"],
        checked["mesh_part"] or None,
        checked["origin"] or None,
        checked["global_frame"],
        checked["require_provenance"],
        layers,
        {p.name: checked[p.name] for p in GEOMETRY_PARAMETERS},
    )


def parameters_in_file(path: Union[str, "os.PathLike[str]"]) -> Mapping[str, Any]:
    """What a YAML file with a list of layers says: what a node has as its parameters.

    Raises:
        MeshMapError: it cannot be read, or has no layers.
    """
    try:
        with open(path, encoding="utf-8") as file:
            content = yaml.safe_load(file)
    except OSError as error:
        raise MeshMapError("%s: %s" % (os.fspath(path), error.strerror)) from error
    except (yaml.YAMLError, UnicodeDecodeError) as error:
        raise MeshMapError("%s is no YAML: %s" % (os.fspath(path), error)) from error
    if not isinstance(content, Mapping) or "layers" not in content:
        raise MeshMapError(
            "%s has no list of layers" % os.fspath(path),
            "config/mesh_map.yaml of mesh_navigation is an example",
        )
    return content


def _misspelled(values: Mapping[str, Any]) -> List[str]:
    """Names that are nearly those of parameters or, where there is a dictionary, of layers; others
    may belong to the node, or to layers that are not listed now."""
    parameters = (*FILE_PARAMETERS, *GEOMETRY_PARAMETERS, *SETTINGS)
    known = ["layers", *(parameter.name for parameter in parameters)]
    entries = values.get("layers")
    entries = entries if isinstance(entries, list) else []
    names = (entry.get("name") if isinstance(entry, Mapping) else entry for entry in entries)
    layers = [name for name in names if isinstance(name, str)]
    sections = [name for name, value in values.items() if isinstance(value, Mapping)]
    singles = [name for name in values if name not in sections]
    return misspelled(singles, known) + misspelled(sections, layers)


def _with_params(entry: Any, values: Mapping[str, Any]) -> Any:
    if isinstance(entry, str) and isinstance(values.get(entry), Mapping):
        params = dict(values[entry])
        named = {key: params.pop(key) for key in ("type", "required") if key in params}
        return dict(named, name=entry, params=params)
    if not isinstance(entry, Mapping) or not isinstance(entry.get("name"), str):
        return entry  # MeshMap says what is wrong with it
    return dict(entry, params=values.get(entry["name"], entry.get("params", {})))
