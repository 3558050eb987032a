"""A map with one of everything, of which each thing tells where it belongs."""

import numpy as np
from mesh_msgs_hdf5.formats.base.remap import take_vertices
from mesh_msgs_hdf5.model.mesh import Features, Label, Materials, Mesh
from meshes import terrain


def full_map(size=12):
    """A terrain of size x size vertices, 0.1 m apart, with layers, labels, textures and so on."""
    made = terrain(size)
    vertices, faces = made.vertices, made.faces
    middles = vertices[faces].mean(1)
    mesh = Mesh(vertices, faces, frame_id="hall", crs="EPSG:25832", origin=(1000.0, 2000.0, 3.0))
    mesh.vertex_normals = np.tile(np.float32([0, 0, 1]), (len(vertices), 1))
    mesh.vertex_colors = np.uint8(np.arange(3 * len(vertices)) % 251).reshape(-1, 3)
    costs = vertices[:, 0].copy()
    costs[:2] = np.inf, np.nan
    mesh.vertex_costs = {"x": costs}
    mesh.layer_parameters = {"x": {"radius": 0.3}}
    mesh.vertex_attributes = {
        "id": np.arange(len(vertices), dtype=np.int64),
        "place": vertices.astype(np.float64),
    }
    mesh.face_attributes = {
        "number": np.arange(len(faces), dtype=np.int64),
        "middle": middles.astype(np.float64),
    }
    mesh.texture_coordinates = vertices[:, :2].copy()
    images = {4: np.full((2, 2, 3), 4, np.uint8), 9: np.full((2, 2, 4), 9, np.uint8)}
    mesh.textures = images
    right = (middles[:, 0] > 0.55).astype(np.uint32)
    colors = np.uint8([[1, 2, 3], [4, 5, 6]])
    mesh.materials = Materials(colors, np.int32([4, 9]), right)
    mesh.labels = {
        "tree_1": Label(np.uint32([0, 1, 2]), (1, 2, 3)),
        "floor": Label(np.arange(len(faces), dtype=np.uint32)[::2]),
    }
    places = vertices[[0, len(vertices) - 1]]
    mesh.features = Features(places, np.float32([[1, 2], [3, 4]]))
    return mesh


def seamed_map(size=12):
    """The same with a seam of its textures between the materials: copies of the vertices there."""
    mesh = full_map(size)
    right = mesh.materials.face_materials == 1
    seam = np.intersect1d(mesh.faces[right], mesh.faces[~right])
    rows = np.concatenate([np.arange(len(mesh.vertices)), seam])
    number = np.arange(len(mesh.vertices))
    number[seam] = len(mesh.vertices) + np.arange(len(seam))
    faces = np.where(right[:, None], number[mesh.faces], mesh.faces).astype(np.uint32)
    mesh = take_vertices(mesh, rows)
    mesh.faces, mesh.seam_originals = faces, seam.astype(np.uint32)
    mesh.texture_coordinates[len(number) :] += 0.5
    return mesh
