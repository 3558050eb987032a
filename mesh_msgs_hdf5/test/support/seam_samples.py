"""Textured models with seams, as files of other programs have them: coordinates of corners."""
import numpy as np
from mesh_writers import image_bytes, pixels

from mesh_msgs.world.solids import box, welded
from mesh_msgs.zoo import grid

IMAGES = {"a.png": pixels(1), "b.png": pixels(2)}


def closed_box():
    """(vertices, faces, uv (F, 3, 2)) of a cube each side of which has a place of its own."""
    vertices, faces = welded(box((0.0, 0.0, 0.0), (2.0, 2.0, 2.0)))
    sides = np.arange(len(faces)) // 2
    corners = np.asarray(vertices)[faces]
    flat = np.array([c[:, np.ptp(c, axis=0) > 0][:, :2] / 2 for c in corners])
    uv = (flat + np.stack([sides % 3, sides // 3], 1)[:, None]) / 3
    return np.float32(vertices), np.int64(faces), uv


def striped_terrain(cells=12, stripes=4, seed=0):
    """A bumpy square, of which each stripe has a place of its own (beyond [0, 1])."""
    mesh = grid(cells, float(cells))
    rng = np.random.default_rng(seed)
    vertices = np.float32(mesh.vertices)
    vertices[:, 2] = rng.random(len(vertices)) * 0.4
    faces = np.int64(mesh.faces)
    middle = vertices[faces][:, :, 0].mean(1)
    low, width = vertices[:, 0].min(), np.ptp(vertices[:, 0]) / stripes
    stripe = np.floor((middle - low) / width)
    uv = vertices[faces][:, :, :2] / 10.0 + 1.7 * stripe[:, None, None]
    return vertices, faces, uv


MODELS = {"box": closed_box, "terrain": striped_terrain}


def write_obj(folder, model, name="model.obj", material=None):
    """An OBJ file with two images, of which every third face has the second; its path.

    material: (F,) of each face 0 or 1 (an image each), 2 (red, no image) or -1 (no
    material; these come first).
    """
    vertices, faces, uv = model
    if material is None:
        material = (np.arange(len(faces)) % 3 == 2).astype(int)
    for image, array in IMAGES.items():
        (folder / image).write_bytes(image_bytes(array))
    (folder / "model.mtl").write_text(
        "newmtl m0\nKd 1 1 1\nmap_Kd a.png\nnewmtl m1\nKd 1 1 1\nmap_Kd b.png\n"
        "newmtl m2\nKd 1 0 0\n"
    )
    pairs, index = np.unique(np.float32(uv).reshape(-1, 2), axis=0, return_inverse=True)
    lines = ["mtllib model.mtl"] + ["v %.9g %.9g %.9g" % tuple(v) for v in vertices]
    lines += ["vt %.9g %.9g" % tuple(pair) for pair in pairs]
    before = -1
    for corners, places, kind in zip(faces + 1, index.reshape(-1, 3) + 1, material):
        if kind != before:
            lines.append("usemtl m%d" % kind)
            before = kind
        lines.append("f " + " ".join("%d/%d" % pair for pair in zip(corners, places)))
    (folder / name).write_text("\n".join(lines) + "\n")
    return folder / name
