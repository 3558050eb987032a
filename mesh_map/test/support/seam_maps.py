"""Textured meshes with seams as map files: with copies of vertices, and without textures."""

import numpy as np
from mesh_msgs.world.solids import box, floor, joined, welded
from mesh_msgs_hdf5.formats.importer import read_mesh
from mesh_msgs_hdf5.map_file import MapFile
from mesh_msgs_hdf5.model.mesh import Label
from PIL import Image
from meshes import terrain


def textured_terrain():
    """(vertices, faces, uv (F, 3, 2)): stripes along y have places of their own in the texture."""
    mesh = terrain(24)
    vertices, faces = np.float32(mesh.vertices), np.int64(mesh.faces)
    low, size = vertices.min(0), np.ptp(vertices, axis=0)
    stripe = np.floor(5 * (vertices[faces].mean(1)[:, 0] - low[0]) / size[0])
    uv = (vertices[faces][:, :, :2] - low[:2]) / size[:2] + 1.5 * stripe[:, None, None]
    return vertices, faces, uv


def textured_box():
    """A floor, on which a box stands; each side and each half has a place of its own."""
    fine = floor((0.0, 0.0), (6.0, 5.0), 0.5)
    vertices, faces = joined(fine, welded(box((2.0, 1.5, 0.0), (3.5, 3.0, 1.0))))
    corners = np.asarray(vertices)[faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    axis = np.abs(normals).argmax(1)
    flat = np.array([np.delete(c, a, axis=1) for c, a in zip(corners, axis)]) / 10.0
    side = 2 * axis + (normals[np.arange(len(axis)), axis] > 0)
    side += 7 * (corners.mean(axis=1).sum(axis=1) > 5.5)  # across the floor
    return np.float32(vertices), np.int64(faces), flat + side[:, None, None]


def closed_box():
    """A cube with edges of 2 m and no border: twelve faces, each with a place of its own."""
    vertices, faces = welded(box((0.0, 0.0, 0.0), (2.0, 2.0, 2.0)))
    uv = np.array([[0, 0], [1, 0], [0, 1]]) + 2.0 * np.arange(len(faces))[:, None, None]
    return np.float32(vertices), np.int64(faces), uv


MODELS = {"terrain": textured_terrain, "box": textured_box, "closed": closed_box}


def write_obj(folder, model):
    """An OBJ file of a model, with an image; its path."""
    vertices, faces, uv = model
    Image.fromarray(np.arange(48, dtype=np.uint8).reshape(4, 4, 3)).save(folder / "a.png")
    (folder / "a.mtl").write_text("newmtl m\nKd 1 1 1\nmap_Kd a.png\n")
    lines = ["mtllib a.mtl"] + ["v %.9g %.9g %.9g" % tuple(v) for v in vertices]
    lines += ["vt %.9g %.9g" % tuple(pair) for pair in uv.reshape(-1, 2)] + ["usemtl m"]
    places = np.arange(3 * len(faces)).reshape(-1, 3)
    for corners, texture in zip(faces + 1, places + 1):
        lines.append("f " + " ".join("%d/%d" % pair for pair in zip(corners, texture)))
    (folder / "model.obj").write_text("\n".join(lines) + "\n")
    return str(folder / "model.obj")


def write_maps(folder, model):
    """(path of the map with copies along seams, of that of the same OBJ file without textures).

    Both have a label, face attributes and a layer of values.
    """
    paths = []
    for name, split in (("split.h5", True), ("plain.h5", False)):
        mesh, _ = read_mesh(write_obj(folder, model), split_seams=split)
        count, rng = len(mesh.parent_vertices), np.random.default_rng(1)
        values = rng.random(count).astype(np.float32)
        values[rng.random(count) < 0.1] = np.nan
        originals = [] if mesh.seam_originals is None else mesh.seam_originals
        mesh.vertex_costs = {"values": np.concatenate([values, values[originals]])}
        mesh.face_attributes = {"speed": rng.random(len(mesh.faces)).astype(np.float32)}
        some = rng.permutation(len(mesh.faces))[: max(1, len(mesh.faces) // 50)]
        mesh.labels = {"forbidden": Label(np.sort(some).astype(np.uint32))}
        mesh.frame_id = "hall"
        paths.append(MapFile.write(str(folder / name), mesh).path)
    return paths
