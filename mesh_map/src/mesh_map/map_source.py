"""Where a mesh map comes from: a map file or a mesh file, and parameters in a dictionary."""

import logging
from dataclasses import dataclass
from typing import Any, Dict, List, Mapping, Optional

import numpy as np
from mesh_msgs_hdf5.any_mesh import open_members
from mesh_msgs_hdf5.errors import MapFileError

from mesh_map.errors import MeshMapError
from mesh_map.layer import Layer
from mesh_map.mesh_map import MeshMap

_LOG = logging.getLogger("mesh_map")


@dataclass(frozen=True)
class MapParameters:
    """Parameters that have been checked.

    mesh_file, mesh_part, global_frame: as in the README.
    layers: the list for MeshMap.compute_layers().
    """

    mesh_file: str
    mesh_part: Optional[str]
    global_frame: str
    layers: Any


def map_parameters(values: Any) -> MapParameters:
    """Reads parameters as ROS users write them: each layer has its own in a dictionary of its name.

    Raises:
        MeshMapError: no mesh_file, or a value of the wrong type.
    """
    if not isinstance(values, Mapping):
        raise MeshMapError("the parameters are %r, not a dictionary" % (values,))
    strings = {}
    for name, default in (("mesh_file", ""), ("mesh_part", ""), ("global_frame", "")):
        strings[name] = values.get(name, default)
        if not isinstance(strings[name], str):
            raise MeshMapError("%s is %r, but it has to be a string" % (name, strings[name]))
    if values.get("server_url") and not strings["mesh_file"]:
        raise MeshMapError("maps of a mesh server (server_url) are not supported", "set mesh_file")
    if not strings["mesh_file"]:
        raise MeshMapError("mesh_file is not set", "name a map file (.h5) or a mesh (.ply .obj …)")
    layers = values.get("layers", [])
    if isinstance(layers, list):
        layers = [_with_params(entry, values) for entry in layers]
    return MapParameters(
        strings["mesh_file"], strings["mesh_part"] or None, strings["global_frame"], layers
    )


def _with_params(entry: Any, values: Mapping[str, Any]) -> Any:
    if not isinstance(entry, Mapping) or not isinstance(entry.get("name"), str):
        return entry  # MeshMap says what is wrong with it
    return dict(entry, params=values.get(entry["name"], entry.get("params", {})))


class MapSource:
    """A mesh that has been read, and the layers stored with it, which are read when needed.

    Attributes: path, is_map_file (HDF5: layers can be saved), mesh (mesh_msgs_hdf5; geometry,
    normals and colors), uuid.
    """

    def __init__(self, path: str, part: Optional[str] = None) -> None:
        """Reads a map file, or a mesh in any format that mesh_msgs_hdf5 knows.

        part: which mesh of a map file; None is "mesh" if there is one, else the only one.

        Raises:
            MeshMapError: a file that cannot be read as a mesh.
        """
        self.path = path
        try:
            opened = open_members(path, part)
            self._members = opened.members
            self.mesh = self._members.read(("vertex_normals", "vertex_colors"))
            self.uuid: str = self._members.uuid
        except MapFileError as error:
            raise MeshMapError(str(error)) from error
        self.is_map_file = opened.is_map
        for note in opened.notes:
            _LOG.warning("%s: %s", path, note)

    def make_map(self, frame_id: str = "") -> MeshMap:
        """A map without layers; its frame is that of the file unless one is given.

        Raises:
            MeshMapError: no usable mesh.
        """
        mesh = self.mesh
        return MeshMap(
            mesh.vertices, mesh.faces, mesh.vertex_normals, frame_id or mesh.frame_id, self.uuid
        )

    def stored_costs(self, name: str, fingerprint: Mapping[str, Any]) -> Optional[np.ndarray]:
        """The costs in the file of the layer of this name, if the same fingerprint is with them.

        A file that does not say how its costs were made may hold those of another radius: they are
        not used, nor are those of a damaged or meanwhile replaced file; that is logged.
        """
        members = self._members
        try:
            if name not in members.layer_names():
                return None
            if members.layer_parameters(name) != dict(fingerprint):
                return None
            return members.vertex_costs(name)
        except MapFileError as error:
            _LOG.warning("layer %s is computed anew: %s", name, error)
            return None

    def save_layers(self, layers: Mapping[str, Layer]) -> List[str]:
        """Writes layers with their parameters to the map file; returns their names.

        Raises:
            MeshMapError: no map file, no layers, or a file that cannot be written.
        """
        if not self.is_map_file:
            raise MeshMapError(
                "%s is no map file, so layers cannot be stored in it" % self.path,
                "rosrun mesh_msgs_hdf5 mesh_tool import IN OUT.h5",
            )
        computed: Dict[str, Any] = {
            name: (layer.result.costs, layer.identity)
            for name, layer in layers.items()
            if layer.result is not None
        }
        if not computed:
            raise MeshMapError("there are no layers to store")
        try:
            self._members.write_layers(computed)
        except MapFileError as error:
            raise MeshMapError(str(error)) from error
        return list(computed)
