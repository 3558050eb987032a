"""All that is known of a mesh, on a mesh that was made of it."""
from typing import Any, Collection, Dict, Mapping, Optional

import numpy as np
from mesh_msgs.derived_mesh import DerivedMesh

from mesh_msgs_hdf5.model.layer_meaning import KEY, computed_with, meaning_of
from mesh_msgs_hdf5.model.mesh import Label, Materials, Mesh

CARRIED_BY = "carried_by"  # a parameter of layers


def carried_mesh(mesh: Mesh, derived: DerivedMesh) -> Mesh:
    """What a mesh has, on one that was derived of it.

    Costs, colors, normals, texture coordinates and attributes of vertices are interpolated, but
    for whole numbers, which may be names of something: those of the nearest vertex; attributes,
    materials and labels of faces are those of their parents. Textures, features, parameters of
    attributes and where the mesh comes from are shared. What layers were computed with is left out
    (see carried_parameters): values that were computed on the derived mesh would be others.

    Raises:
        ValueError: the mesh is not the parent of the derived one.
    """
    counts = len(mesh.vertices), len(mesh.faces)
    parent_counts = derived.parent_vertex_count, derived.parent_face_count
    if counts != parent_counts:
        raise ValueError(
            "a mesh of %d vertices and %d faces is not the parent, which has %d and %d"
            % (counts + parent_counts)
        )
    return Mesh(
        derived.vertices,
        derived.faces,
        vertex_normals=_carried_normals(mesh.vertex_normals, derived),
        vertex_colors=_carried(mesh.vertex_colors, derived),
        vertex_costs={
            name: derived.vertex_values(costs) for name, costs in mesh.vertex_costs.items()
        },
        frame_id=mesh.frame_id,
        source=mesh.source,
        vertex_attributes={
            name: carried_attribute(values, derived)
            for name, values in mesh.vertex_attributes.items()
        },
        vertex_parameters=dict(mesh.vertex_parameters),
        face_attributes={
            name: derived.face_values(values) for name, values in mesh.face_attributes.items()
        },
        face_parameters=dict(mesh.face_parameters),
        texture_coordinates=_carried(mesh.texture_coordinates, derived),
        textures=mesh.textures,
        materials=_carried_materials(mesh.materials, derived),
        labels={text: carried_label(label, derived) for text, label in mesh.labels.items()},
        features=mesh.features,
        origin=mesh.origin,
        crs=mesh.crs,
    )


def carried_parameters(
    costs: Mapping[str, np.ndarray], parameters: Mapping[str, Mapping[str, Any]], by: str
) -> Dict[str, Dict[str, Any]]:
    """Layer name -> parameters of layers that were computed on another mesh: never those of a
    computation, and not none, which would be those of a file that is silent and may be trusted.

    costs: the layers as they are now, of any number of vertices; parameters: of the layers that
    they were. What the values mean stays, with the numbers of these.
    """
    found = {}
    for name, values in costs.items():
        found[name] = {CARRIED_BY: by}
        meaning = meaning_of(parameters.get(name, {}))
        if meaning is not None:
            if meaning.layer_type:
                found[name]["type"] = meaning.layer_type
            found[name][KEY] = meaning._replace(lethal=None).counted(values).stored()
    return found


def mark_silent(mesh: Mesh, by: str, but: Collection[str] = ()) -> None:
    """Give the layers of a mesh that do not say how they were computed, but for some, what tells
    them from those of map files that are silent, and may be trusted."""
    for name in set(mesh.vertex_costs).difference(but):
        mesh.layer_parameters[name] = not_silent(mesh.layer_parameters.get(name, {}), by)


def not_silent(parameters: Mapping[str, Any], by: str) -> Dict[str, Any]:
    """The parameters of a layer; carried by this where they do not say how it was computed."""
    found = dict(parameters)
    return found if computed_with(found) else {CARRIED_BY: by, **found}


def carried_attribute(values: np.ndarray, derived: DerivedMesh) -> np.ndarray:
    """A vertex attribute (V,) or (V, C) of the parent, on a derived mesh."""
    if values.dtype.kind == "f":
        return derived.vertex_values(values)
    nearest = np.argmax(derived.vertex_weights, axis=1)
    return values[derived.vertex_parents[np.arange(len(nearest)), nearest]]


def carried_label(label: Label, derived: DerivedMesh) -> Label:
    """A label of the parent, on a derived mesh: all parts of its faces."""
    return Label(derived.faces_of(label.faces), label.color)


def _carried(values: Any, derived: DerivedMesh) -> Optional[np.ndarray]:
    return None if values is None else derived.vertex_values(values)


def _carried_normals(normals: Any, derived: DerivedMesh) -> Optional[np.ndarray]:
    """Of length 1; where those around cancel each other out, that of the nearest vertex."""
    if normals is None:
        return None
    found = derived.vertex_values(normals)
    lengths = np.linalg.norm(found, axis=1)
    none = lengths < 1e-6
    nearest = np.argmax(derived.vertex_weights[none], axis=1)
    found[none] = np.asarray(normals)[derived.vertex_parents[none, nearest]]
    lengths[none] = 1.0
    is_new = derived.vertex_weights.max(1) < 1.0
    found[is_new] /= lengths[is_new, None]
    return found


def _carried_materials(materials: Optional[Materials], derived: DerivedMesh) -> Optional[Materials]:
    if materials is None:
        return None
    return Materials(
        materials.colors, materials.texture_indices, derived.face_values(materials.face_materials)
    )
