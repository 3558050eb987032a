"""A mesh without the copies of vertices along the seams of its textures."""
from dataclasses import replace
from typing import Dict, Optional

import numpy as np
from mesh_msgs.split_mesh import SplitMesh

from mesh_msgs_hdf5.model.mesh import Materials, Mesh


def split_mesh(mesh: Mesh, uuid: str = "") -> Optional[SplitMesh]:
    """The mesh as a derived mesh of the one without copies; None if it has no copies.

    uuid: of the mesh, for the result; the parent's is not computed.
    """
    if mesh.seam_originals is None:
        return None
    return SplitMesh(uuid, "", mesh.vertices, mesh.faces, mesh.seam_originals)


def without_copies(mesh: Mesh) -> Mesh:
    """The parent of a mesh with copies: one vertex for each point of the surface, the same faces,
    and everything that these have but textures, which need the copies.

    Normals, colors and attributes are those of the originals. Of costs the largest counts, and NaN
    before it (SplitMesh.parent_vertex_values). A mesh without copies is returned as it is.
    """
    split = split_mesh(mesh)
    if split is None:
        return mesh
    count = split.parent_vertex_count
    materials = mesh.materials
    if materials is not None and mesh.textures:
        without = np.full(len(materials.colors), -1, np.int32)
        materials = Materials(materials.colors, without, materials.face_materials)
    return replace(
        mesh,
        vertices=np.ascontiguousarray(mesh.vertices[:count]),
        faces=split.parent_faces,
        vertex_normals=_first(mesh.vertex_normals, count),
        vertex_colors=_first(mesh.vertex_colors, count),
        vertex_costs={
            name: split.parent_vertex_values(costs) for name, costs in mesh.vertex_costs.items()
        },
        vertex_attributes={name: v[:count] for name, v in mesh.vertex_attributes.items()},
        texture_coordinates=None,
        textures={},
        materials=materials,
        seam_originals=None,
    )


def differing_copies(mesh: Mesh) -> Dict[str, int]:
    """What copies have otherwise than their originals -> how many of them, where there are any:
    "normals", "colors", "attribute NAME", "layer NAME". All these but the layers get lost where
    the mesh becomes its parent; of layers the largest values stay.
    """
    if mesh.seam_originals is None:
        return {}
    of_vertices = {
        "normals": mesh.vertex_normals,
        "colors": mesh.vertex_colors,
        **{"attribute " + name: values for name, values in mesh.vertex_attributes.items()},
        **{"layer " + name: values for name, values in mesh.vertex_costs.items()},
    }
    count, found = len(mesh.parent_vertices), {}
    for what, values in of_vertices.items():
        if values is not None:
            copies, originals = values[count:], values[mesh.seam_originals]
            same = copies == originals
            if values.dtype.kind == "f":
                same |= np.isnan(copies) & np.isnan(originals)
            differing = np.count_nonzero(~same.reshape(len(same), -1).all(axis=1))
            found.update({what: differing} if differing else {})
    return found


def _first(values: Optional[np.ndarray], count: int) -> Optional[np.ndarray]:
    return None if values is None else values[:count]
