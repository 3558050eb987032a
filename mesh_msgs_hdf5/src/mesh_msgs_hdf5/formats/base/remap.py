"""A mesh of some of the vertices or faces of another one; everything that it has follows."""
from dataclasses import replace
from typing import Optional

import numpy as np

from mesh_msgs_hdf5.model.mesh import Label, Materials, Mesh


def take_vertices(mesh: Mesh, rows: np.ndarray) -> Mesh:
    """A Mesh with the vertices (and their values) of these rows (N,) of the mesh.

    The faces stay as they are: giving them the new numbers is the caller's task, and which of the
    vertices are copies along seams.
    """

    def taken(values: Optional[np.ndarray]) -> Optional[np.ndarray]:
        return None if values is None else values[rows]

    return replace(
        mesh,
        vertices=mesh.vertices[rows],
        vertex_normals=taken(mesh.vertex_normals),
        vertex_colors=taken(mesh.vertex_colors),
        texture_coordinates=taken(mesh.texture_coordinates),
        vertex_costs={name: costs[rows] for name, costs in mesh.vertex_costs.items()},
        vertex_attributes={name: values[rows] for name, values in mesh.vertex_attributes.items()},
        seam_originals=None,
    )


def take_faces(mesh: Mesh, rows: np.ndarray, twins: Optional[np.ndarray] = None) -> Mesh:
    """A Mesh with the faces of these rows (N,), ascending, of the mesh.

    Labels keep those of their faces that are left. twins: (F,) which face stands for each one (a
    duplicate's twin, else itself): labels of the duplicate go to it.
    """
    number = np.full(len(mesh.faces), -1, np.int64)
    number[rows] = np.arange(len(rows))

    def renumbered(faces):
        new = number[faces if twins is None else twins[faces]]
        left = new[new >= 0]
        # each once, in the order in which they stood
        return left[np.sort(np.unique(left, return_index=True)[1])].astype(np.uint32)

    materials = mesh.materials
    if materials is not None:
        materials = Materials(
            materials.colors, materials.texture_indices, materials.face_materials[rows]
        )
    return replace(
        mesh,
        faces=mesh.faces[rows],
        face_attributes={name: values[rows] for name, values in mesh.face_attributes.items()},
        materials=materials,
        labels={
            text: Label(renumbered(label.faces), label.color) for text, label in mesh.labels.items()
        },
    )
