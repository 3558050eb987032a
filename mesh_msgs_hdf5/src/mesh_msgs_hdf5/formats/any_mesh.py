"""Any mesh file by its members: a map file as it is (lazily), other formats read as a whole."""
import os
from typing import Any, Dict, Iterable, List, NamedTuple, Optional, Sequence, Tuple, Union

import numpy as np

from mesh_msgs_hdf5.files.probe import kind_of, read_head
from mesh_msgs_hdf5.formats.importer import read_mesh
from mesh_msgs_hdf5.isolation import IsolatedMapFile
from mesh_msgs_hdf5.model.errors import MapFileError, PathLike
from mesh_msgs_hdf5.model.label_names import natural_order
from mesh_msgs_hdf5.model.mesh import Label, Mesh


class MeshMembers:
    """A Mesh in memory with the reading interface of MapFile (which see)."""

    part = ""
    parts: List[str] = []
    schema = ""
    schema_version = 0
    vertex_rounding = 0.0
    textures_form = ""  # of a file
    notes: List[str] = []  # an import has its own, in a report

    def __init__(self, path: str, mesh: Mesh) -> None:
        self.path, self._mesh = path, mesh
        self.vertex_count, self.face_count = len(mesh.vertices), len(mesh.faces)
        self.has_normals = mesh.vertex_normals is not None
        self.has_colors = mesh.vertex_colors is not None
        self.has_seams = mesh.seam_originals is not None

    def __enter__(self) -> "MeshMembers":
        return self

    def __exit__(self, *_: Any) -> None:
        """There is nothing to close."""

    def __getattr__(self, name):
        return getattr(self._mesh, name)  # vertices, frame_id, origin, uuid, ...

    def layer_names(self) -> List[str]:
        return sorted(self._mesh.vertex_costs)

    def vertex_costs(self, name: str) -> np.ndarray:
        return self._of("layer", self._mesh.vertex_costs, name)

    def layer_parameters(self, name: str) -> Dict[str, Any]:
        self.vertex_costs(name)
        return self._mesh.layer_parameters.get(name, {})

    def all_layer_parameters(self) -> Dict[str, Dict[str, Any]]:
        return {name: self.layer_parameters(name) for name in self.layer_names()}

    def vertex_attribute_names(self) -> List[str]:
        return sorted(self._mesh.vertex_attributes)

    def vertex_attribute(self, name: str) -> np.ndarray:
        return self._of("vertex attribute", self._mesh.vertex_attributes, name)

    def vertex_parameters(self, name: str) -> Dict[str, Any]:
        self.vertex_attribute(name)
        return self._mesh.vertex_parameters.get(name, {})

    def face_attribute_names(self) -> List[str]:
        return sorted(self._mesh.face_attributes)

    def face_attribute(self, name: str) -> np.ndarray:
        return self._of("face attribute", self._mesh.face_attributes, name)

    def face_parameters(self, name: str) -> Dict[str, Any]:
        self.face_attribute(name)
        return self._mesh.face_parameters.get(name, {})

    def texture_indices(self) -> List[int]:
        return sorted(self._mesh.textures)

    def texture(self, index: int) -> np.ndarray:
        return self._of("texture", self._mesh.textures, index, "index")

    def label_names(self) -> List[str]:
        return sorted(self._mesh.labels, key=natural_order)

    def label(self, text: str) -> Label:
        return self._of("label", self._mesh.labels, text, "label")

    def labels(self) -> Dict[str, Label]:
        return {text: self._mesh.labels[text] for text in self.label_names()}

    def other_contents(self, within: Sequence[str] = ()) -> List[str]:
        return []

    def read(self, members: Optional[Iterable[str]] = None) -> Mesh:
        return self._mesh

    def _of(self, what, members, name, code="layer"):
        if name not in members:
            known = ", ".join(map(str, members))
            hint = "there are: " + known if known else "the mesh has none"
            raise MapFileError(code, self.path, "there is no %s %r" % (what, name), hint)
        return members[name]


Members = Union[IsolatedMapFile, MeshMembers]


class Opened(NamedTuple):
    """members: of the mesh; format: "HDF5", "PLY", ...; notes: what reading it changed; rounded: by
    how much (meters) a coordinate changed at most by becoming float32."""

    members: Members
    format: str
    notes: Tuple[str, ...]
    rounded: float = 0.0

    @property
    def is_map(self) -> bool:
        return self.format == "HDF5"


def is_map_file(path: PathLike) -> bool:
    """Whether a file is a map file (HDF5), as far as its first bytes tell. Raises MapFileError."""
    return kind_of(path, read_head(path)) == "h5"


def open_members(
    path: PathLike,
    part: Optional[str] = None,
    origin: Optional[Sequence[float]] = None,
    strict: bool = False,
) -> Opened:
    """The members of a mesh in a file of any known format. Raises MapFileError.

    strict: of a map file, as in MapFile.
    origin: (3,) meters, subtracted from the coordinates of formats other than map files, which
    store theirs.
    """
    path = os.fsdecode(path)
    if is_map_file(path):
        return Opened(IsolatedMapFile(path, part, strict=strict), "HDF5", ())
    mesh, report = read_mesh(path, part, origin=origin)
    members = MeshMembers(path, mesh)
    return Opened(members, report.format, tuple(report.notes), report.rounded)
