"""Where each thing of a mesh stands in the file layouts that are in use.

S0 is that of hdf5_map_io 1.0.0 (groups at the root), S1 that of hdf5_map_io 1.0.1 to 1.1, of LVR2
up to 2024-11 and our own, S2 that of LVR2 since 2024-12; "meshes" are LVR2's two layouts below
/meshes. All places are relative to the group of a part. Of several places the first that is there
is read; what stands at the others counts as unknown and stays in the file.
"""
from dataclasses import dataclass
from typing import FrozenSet, List, Optional, Tuple

import h5py

from mesh_msgs_hdf5.map_file.hdf5.hdf5_guard import (
    address,
    children,
    exists,
    first_keys,
    is_group_of_this_file,
    link_kind,
)
from mesh_msgs_hdf5.model import schema
from mesh_msgs_hdf5.model.errors import MapFileError, PathLike

Places = Tuple[str, ...]
ROOT = ""  # the name of the part that is the root group

MAX_DEPTH = 3
_MAX_GROUPS = 1024  # that are looked at in search of meshes
_MAX_NAMES = 1024  # of a group below the root that may hold parts


@dataclass(frozen=True)
class Layout:
    """The places of one layout.

    layers, face_attributes: groups with one dataset each; face_arrays: datasets that are face
    attributes by their last name. lvr2_*: LVR2's own form of textures and materials, read where
    hdf5_map_io's (names in schema.py) is not there. structure: groups that say nothing by
    themselves. below: the group that parts must be in. marker: a group that shows the layout even
    if the mesh is incomplete.
    """

    schema: str
    vertices: str
    faces: str
    normals: Places
    colors: Places
    marker: str
    layers: Places = ()
    features: str = ""
    labels: str = ""
    textures: str = ""
    texture_coordinates: Places = ()
    lvr2_materials: str = ""
    lvr2_face_materials: str = ""
    face_attributes: str = ""
    face_arrays: Places = ()
    seams: str = ""
    structure: Places = ()
    below: str = ""

    @property
    def single(self) -> FrozenSet[str]:
        """The places of single arrays; no layer is at one of them."""
        several = self.normals + self.colors + self.texture_coordinates + self.face_arrays
        return frozenset((self.vertices, self.faces, self.lvr2_face_materials) + several)


_HDF5_MAP_IO = ("clustersets", "labels", "textures", "textures/images")
S1 = Layout(
    schema="S1",
    vertices="channels/vertices",
    faces="channels/face_indices",
    normals=("channels/vertex_normals",),
    colors=("channels/vertex_colors",),
    marker="channels",
    layers=("channels",),
    features="channels/texture_features",
    labels="labels",
    textures="textures",
    texture_coordinates=("textures/coords", "channels/texture_coordinates"),
    lvr2_materials="materials",
    lvr2_face_materials="channels/face_material_indices",
    face_attributes=schema.FACE_ATTRIBUTES,
    seams=schema.SEAMS,
    structure=_HDF5_MAP_IO
    + ("channels", "channels/texture_features", "face_attributes", "materials", schema.SEAMS),
)
S0 = Layout(
    schema="S0",
    vertices="geometry/vertices",
    faces="geometry/faces",
    normals=("attributes/normals",),
    colors=("attributes/rgb_colors",),
    marker="attributes",
    layers=("attributes",),
    features="attributes/texture_features",
    labels="labels",
    textures="textures",
    texture_coordinates=("textures/coords",),
    structure=_HDF5_MAP_IO + ("attributes", "attributes/texture_features"),
)
S2 = Layout(
    schema="S2",
    vertices="geometry/vertices",
    faces="geometry/face_indices",
    normals=("vertex_attributes/vertex_normals", "geometry/vertex_normals"),
    colors=("vertex_attributes/vertex_colors", "geometry/vertex_colors"),
    marker="geometry",
    layers=("vertex_attributes", "geometry"),
    features="channels/texture_features",  # our own: there is no place for them in S2
    labels="labels",
    textures="textures",
    texture_coordinates=(
        "textures/coords",
        "geometry/texture_coordinates",
        "vertex_attributes/texture_coordinates",
    ),
    lvr2_materials="materials",
    lvr2_face_materials="geometry/face_material_indices",
    face_attributes="face_attributes",
    face_arrays=("geometry/face_normals", "geometry/face_colors"),
    seams=schema.SEAMS,  # our own
    structure=_HDF5_MAP_IO
    + ("vertex_attributes", "face_attributes", "edge_attributes", "cluster_attributes")
    + ("channels", "channels/texture_features", "materials", schema.SEAMS),
)
MESH_IO = Layout(
    schema="meshes",
    below="meshes",
    vertices="vertices/coordinates",
    faces="faces/indices",
    normals=("vertices/normals",),
    colors=("vertices/colors",),
    marker="vertices",
)
MODEL_FACTORY = Layout(
    schema="meshes",
    below="meshes",
    vertices="vertices",
    faces="indices",
    normals=(),
    colors=(),
    marker="vertices",
)
LAYOUTS = (S1, S0, S2, MESH_IO, MODEL_FACTORY)


def layout_of(group: h5py.Group, components: List[str]) -> Tuple[Optional[Layout], bool]:
    """(the layout of a part's group, None if it holds no mesh; whether all of a mesh is there).

    components: the part's name. Only looks at names; links are not followed.
    """
    found = None
    for layout in LAYOUTS:
        if layout.below and (len(components) < 2 or components[0] != layout.below):
            continue
        if exists(group, layout.vertices) and exists(group, layout.faces):
            return layout, True
        if found is None and exists(group, layout.marker):
            found = layout
    return found, False


def find_parts(file: h5py.File, path: PathLike) -> List[str]:
    """The names of the parts that hold a mesh, ROOT among them; sorted by depth, then by name.

    A part is looked for down to three groups below the root, in at most 1024 groups, and not in
    other parts nor, below the root, in groups with very many entries (scans); one that is not
    found so can still be opened by its name.
    """
    parts = []
    seen = {address(file["/"])}  # a group may be in many places, even in itself
    level = [((), file["/"])]
    for depth in range(MAX_DEPTH + 1):
        below = []
        for components, group in level:
            layout, whole = layout_of(group, list(components))
            if whole:
                parts.append("/".join(components))
            if depth == MAX_DEPTH or layout is not None and components:
                continue
            for name in _names(path, group, depth):
                if len(seen) > _MAX_GROUPS:
                    break
                if not is_group_of_this_file(group, name):
                    continue
                inner = group[name]
                if address(inner) not in seen:
                    seen.add(address(inner))
                    below.append((components + (name,), inner))
        level = below
    return sorted(parts, key=lambda part: (part.count("/") if part else -1, part))


def default_part(file: h5py.File, path: PathLike) -> str:
    """The part that is meant if none is named: mesh if there is one, else the only one.

    Raises MapFileError (part) if there are several.
    """
    if is_group_of_this_file(file, "mesh") and layout_of(file["mesh"], ["mesh"])[1]:
        return "mesh"
    parts = find_parts(file, path)
    if len(parts) > 1:
        raise MapFileError(
            "part",
            path,
            "it holds %d meshes, and none is called mesh" % len(parts),
            "name the part: %s" % ", ".join(part or "/" for part in parts[:20]),
        )
    if parts:
        return parts[0]
    # no mesh at all: reading this one says what is missing
    return ROOT if link_kind(file["/"], "mesh") is None else "mesh"


def _names(path, group, depth):
    if depth and len(first_keys(group, _MAX_NAMES + 1)) > _MAX_NAMES:
        return []
    # the usual ones first: the search may end before the others
    found = children(path, group, tell=lambda _: None)  # no part can be named by what is no text
    return sorted(found, key=lambda name: name not in ("mesh", "meshes"))
