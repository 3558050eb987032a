"""Map files as other programs write them, made with plain h5py field by field; and a comparison.

Each function writes what its layout holds of a mesh and returns that as the Mesh to be read.
"""
import dataclasses
import re

import h5py
import numpy as np

from mesh_msgs_hdf5.checks.check import identical
from mesh_msgs_hdf5.model.mesh import Label, Materials, Mesh

# hdf5_map_io's compound, with one byte of padding
MATERIAL = np.dtype(
    {
        "names": ["textureIndex", "r", "g", "b"],
        "formats": ["<i4", "u1", "u1", "u1"],
        "offsets": [0, 4, 5, 6],
        "itemsize": 8,
    }
)


def assert_same_mesh(found, mesh):
    """Every member, bit for bit; types and shapes of arrays and the order of their keys too."""
    for field in dataclasses.fields(Mesh):
        assert_same(getattr(found, field.name), getattr(mesh, field.name), field.name)


def assert_same(found, expected, name):
    """The same of one member: an array, a dict, a dataclass or a plain value."""
    if isinstance(expected, np.ndarray):
        assert identical(found, expected), name
    elif isinstance(expected, dict):
        assert set(found) == set(expected), name
        for key, value in expected.items():
            assert_same(found[key], value, "%s %r" % (name, key))
    elif dataclasses.is_dataclass(expected):
        assert type(found) is type(expected), name
        for field in dataclasses.fields(expected):
            inner = "%s of %s" % (field.name, name)
            assert_same(getattr(found, field.name), getattr(expected, field.name), inner)
    else:
        assert found == expected and type(found) is type(expected), name


def _plain_labels(mesh):
    """The labels that the released programs can have: class_instance, without a color."""
    plain = re.compile("[a-z]+_[0-9]+")
    return {t: Label(label.faces) for t, label in mesh.labels.items() if plain.fullmatch(t)}


def _contiguous(group, name, values):
    """As H5LTmake_dataset: no chunks, no filters."""
    return group.create_dataset(name, data=values)


def _lvr2(group, name, values):
    """As LVR2's ArrayIO: one chunk as large as the data, deflate 9, no shuffle."""
    return group.create_dataset(
        name, data=values, chunks=values.shape, compression="gzip", compression_opts=9
    )


def write_image(group, name, pixels, **attributes):
    """As H5IMmake_image_24bit; further attributes replace those."""
    image = _contiguous(group, name, pixels)
    texts = {
        "CLASS": "IMAGE",
        "IMAGE_VERSION": "1.2",
        "IMAGE_SUBCLASS": "IMAGE_TRUECOLOR",
        "INTERLACE_MODE": "INTERLACE_PIXEL",
    }
    texts.update(attributes)
    for key, text in texts.items():
        if isinstance(text, str):
            kind = h5py.h5t.C_S1.copy()
            kind.set_size(len(text) + 1)
            kind.set_strpad(h5py.h5t.STR_NULLTERM)
            space = h5py.h5s.create(h5py.h5s.SCALAR)
            h5py.h5a.create(image.id, key.encode(), kind, space).write(np.array(text.encode()))
        elif text is not None:
            image.attrs[key] = text
    return image


def _hdf5_map_io_rest(part, mesh, textures=True):
    """textures, labels and clustersets, which S0 and S1 have in common."""
    part.create_group("clustersets")
    labels = part.create_group("labels")
    for text, label in _plain_labels(mesh).items():
        class_name, instance = text.split("_")
        _contiguous(labels.require_group(class_name), instance, label.faces)
    group = part.create_group("textures")
    if not textures:
        return
    uvw = np.zeros((len(mesh.vertices), 3), "<f4")
    uvw[:, :2] = mesh.texture_coordinates
    uvw[:, 2] = 0.25  # the third is to be ignored
    _contiguous(group, "coords", uvw.ravel())
    materials = np.zeros(len(mesh.materials.colors), MATERIAL)
    materials["textureIndex"] = mesh.materials.texture_indices
    for i, name in enumerate("rgb"):
        materials[name] = mesh.materials.colors[:, i]
    _contiguous(group, "materials", materials)
    _contiguous(group, "mat_face_indices", mesh.materials.face_materials)
    images = group.create_group("images")
    for index, pixels in mesh.textures.items():
        write_image(images, str(index), pixels)


def _features(group, mesh):
    for i, (place, values) in enumerate(zip(mesh.features.locations, mesh.features.descriptors)):
        _contiguous(group, str(i), values).attrs["vector"] = place


def _common(mesh, **members):
    return Mesh(
        vertices=mesh.vertices,
        faces=mesh.faces,
        vertex_normals=mesh.vertex_normals,
        vertex_colors=mesh.vertex_colors,
        **members,
    )


def _textured(mesh):
    return dict(
        texture_coordinates=mesh.texture_coordinates,
        textures=mesh.textures,
        materials=mesh.materials,
        features=mesh.features,
        labels=_plain_labels(mesh),
    )


def write_s0(path, mesh):
    """hdf5_map_io 1.0.0: groups at the root, everything in one dimension."""
    costs = mesh.vertex_costs["height_diff"]
    with h5py.File(path, "w") as file:
        _contiguous(file, "geometry/vertices", mesh.vertices.ravel())
        _contiguous(file, "geometry/faces", mesh.faces.ravel())
        attributes = file.create_group("attributes")
        _contiguous(attributes, "normals", mesh.vertex_normals.ravel())
        _contiguous(attributes, "rgb_colors", mesh.vertex_colors.ravel())
        _contiguous(attributes, "roughness", costs[::-1])
        _contiguous(attributes, "height_difference", costs)
        _features(attributes.create_group("texture_features"), mesh)
        _hdf5_map_io_rest(file, mesh)
    layers = {"roughness": costs[::-1].copy(), "height_difference": costs}
    return _common(mesh, vertex_costs=layers, **_textured(mesh))


def write_hdf5_map_io(path, mesh, part="mesh"):
    """hdf5_map_io 1.0.1 to 1.1: S1 in one dimension."""
    costs = mesh.vertex_costs["height_diff"]
    with h5py.File(path, "a") as file:
        group = file.create_group(part) if part else file["/"]
        channels = group.create_group("channels")
        _contiguous(channels, "vertices", mesh.vertices.ravel())
        _contiguous(channels, "face_indices", mesh.faces.ravel())
        _contiguous(channels, "vertex_normals", mesh.vertex_normals.ravel())
        _contiguous(channels, "vertex_colors", mesh.vertex_colors.ravel())
        _contiguous(channels, "roughness", costs[::-1])
        _contiguous(channels, "height_diff", costs)
        _features(channels.create_group("texture_features"), mesh)
        _hdf5_map_io_rest(group, mesh)
    layers = {"roughness": costs[::-1].copy(), "height_diff": costs}
    return _common(mesh, vertex_costs=layers, **_textured(mesh))


def write_lvr2_l1(path, mesh, part="mesh"):
    """LVR2 up to 2024-11: S1 in two dimensions, textures and materials in a form of its own."""
    costs = mesh.vertex_costs["height_diff"]
    edges = np.arange(len(mesh.vertices), dtype="<f4")[:, None]  # as many edges as vertices
    with h5py.File(path, "a") as file:
        group = file.create_group(part) if part else file["/"]
        group.attrs["IO"], group.attrs["CLASS"] = "MeshIO", "MeshBuffer"
        for name, values in (
            ("vertices", mesh.vertices),
            ("face_indices", mesh.faces),
            ("vertex_normals", mesh.vertex_normals),
            ("vertex_colors", mesh.vertex_colors),
            ("height_diff", costs[:, None]),
            ("steepness", costs[::-1, None]),
            ("face_normals", mesh.vertices[mesh.faces[:, 0]]),
            ("edge_distances", edges),
            ("edge_distances_idx", edges.astype("<u4")),
            ("face_material_indices", mesh.materials.face_materials[:, None]),
            ("texture_coordinates", mesh.texture_coordinates),
        ):
            _lvr2(group, "channels/" + name, values)
        for index, pixels in mesh.textures.items():
            height, width, planes = pixels.shape
            # the bytes row by row, under the name [width,height,channels]
            _lvr2(group, "textures/%d" % index, pixels.reshape(width, height, planes))
        _lvr2(group, "materials/texture_handles", mesh.materials.texture_indices)
        rgb = mesh.materials.colors.astype("<i2")
        rgb[1] = -1
        _lvr2(group, "materials/rgb_color", rgb)
        for text, label in _plain_labels(mesh).items():
            _lvr2(group, "labels/" + text.replace("_", "/"), label.faces[:, None])
    members = _textured(mesh)
    colors = mesh.materials.colors.copy()
    colors[1] = 255
    materials = Materials(colors, mesh.materials.texture_indices, mesh.materials.face_materials)
    members.update(features=None, materials=materials)
    layers = {"height_diff": costs, "steepness": costs[::-1].copy()}
    return _common(mesh, vertex_costs=layers, **members)


def write_s2(path, mesh, part="mesh", alpha=False, in_geometry=False):
    """LVR2 since 2024-12. in_geometry: normals and colors as channels of the geometry."""
    costs = mesh.vertex_costs["height_diff"]
    colors = mesh.vertex_colors
    if alpha:
        colors = np.concatenate([colors, np.full((len(colors), 1), 255, "u1")], axis=1)
    face_normals = mesh.vertices[mesh.faces[:, 0]]
    per_vertex = "geometry/" if in_geometry else "vertex_attributes/"
    with h5py.File(path, "a") as file:
        group = file.create_group(part) if part else file["/"]
        group.attrs["IO"], group.attrs["CLASS"] = "MeshIO", "MeshBuffer"
        for name, values in (
            ("geometry/vertices", mesh.vertices),
            ("geometry/face_indices", mesh.faces),
            (per_vertex + "vertex_normals", mesh.vertex_normals),
            (per_vertex + "vertex_colors", colors),
            ("geometry/texture_coordinates", mesh.texture_coordinates),
            ("vertex_attributes/roughness", costs[:, None]),
            ("vertex_attributes/inflation", costs[::-1, None]),
            ("face_attributes/face_normals", face_normals),
            ("edge_attributes/edge_distances", costs[:, None]),
            ("edge_attributes/edge_distances_idx", np.arange(40, dtype="<u4")[:, None]),
        ):
            _lvr2(group, name, values)
        group.create_group("cluster_attributes")
        for text, label in _plain_labels(mesh).items():
            _lvr2(group, "labels/" + text.replace("_", "/"), label.faces[:, None])
    return _common(
        mesh,
        vertex_costs={"roughness": costs, "inflation": costs[::-1].copy()},
        face_attributes={"face_normals": face_normals},
        texture_coordinates=mesh.texture_coordinates,
        labels=_plain_labels(mesh),
    )


def write_model_factory(path, mesh, name="garden"):
    """LVR2's old ModelFactory: vertices and indices alone."""
    with h5py.File(path, "a") as file:
        _lvr2(file, "meshes/%s/vertices" % name, mesh.vertices)
        _lvr2(file, "meshes/%s/indices" % name, mesh.faces)
    return Mesh(mesh.vertices, mesh.faces)


def write_mesh_io(path, mesh, name="garden"):
    """LVR2's new meshio layout; all but geometry, normals and colors is left to the file."""
    with h5py.File(path, "a") as file:
        group = file.create_group("meshes/%s" % name)
        group.attrs["n_faces"] = len(mesh.faces)
        for place, values in (
            ("vertices/coordinates", mesh.vertices),
            ("vertices/normals", mesh.vertex_normals),
            ("vertices/colors", mesh.vertex_colors),
            ("vertices/texture_coordinates", mesh.texture_coordinates),
            ("faces/indices", mesh.faces),
            ("faces/materials", mesh.materials.face_materials),
            ("surfaces/combined_face_indices", np.arange(60, dtype="<u4")),
            ("materials/00000000/textures/layer", np.zeros((4, 5, 3, 1), "u1")),
        ):
            _lvr2(group, place, values)
    return _common(mesh)


SAMPLES = {
    "S0": write_s0,
    "hdf5_map_io": write_hdf5_map_io,
    "lvr2_l1": write_lvr2_l1,
    "S2": write_s2,
    "model_factory": write_model_factory,
    "mesh_io": write_mesh_io,
}
