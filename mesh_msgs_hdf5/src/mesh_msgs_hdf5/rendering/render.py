"""A picture of a mesh: what is in front hides what is behind, slopes are shaded."""
from typing import Callable, Optional, Tuple

import numpy as np

from mesh_msgs_hdf5.model.errors import MapFileError
from mesh_msgs_hdf5.model.layer_meaning import meaning_of
from mesh_msgs_hdf5.model.mesh import Mesh
from mesh_msgs_hdf5.rendering.render_camera import Camera
from mesh_msgs_hdf5.rendering.render_paint import (
    FaceValues,
    Labels,
    Textures,
    VertexColors,
    VertexValues,
    marked_layer,
)
from mesh_msgs_hdf5.rendering.render_raster import NO_FACE, visible_faces
from mesh_msgs_hdf5.rendering.render_scale import SCALES

SAMPLES = 2  # along each side of a pixel, for smooth edges
_BLOCK = 1 << 14  # pixels handled at a time: what fits into the caches
_LIGHT = np.array([-0.45, 0.55, 0.7]) / np.linalg.norm([-0.45, 0.55, 0.7])  # right, up, viewer
_DARKEST = 0.45  # a face that the light does not reach


def choose_paint(
    path: str,
    mesh: Mesh,
    what: str,
    name: Optional[str] = None,
    limits: Optional[Tuple[float, float]] = None,
    scale: str = "rainbow",
    mark_lethal: bool = True,
):
    """The paint for a mesh (see render_paint).

    what: "layer" or "face" (the vertex layer or face attribute called name; a layer that is not
    there may be a face attribute), "labels", "colors", "textures" or "height". mark_lethal: paint
    all lethal values of a layer alike, where its parameters say which are. Raises MapFileError
    (code layer) for what the mesh does not have; path is for the error.
    """
    stops = SCALES[scale]
    if what == "layer" and name in mesh.vertex_costs:
        costs, meaning = mesh.vertex_costs[name], meaning_of(mesh.layer_parameters.get(name, {}))
        if mark_lethal and meaning is not None:
            return marked_layer(name, mesh.faces, costs, meaning, stops, limits)
        return VertexValues(name, mesh.faces, costs, stops, limits)
    if what in ("layer", "face"):
        return FaceValues(name, _face_values(path, mesh, what, name), stops, limits)
    if what == "height":
        return VertexValues("height z [m]", mesh.faces, mesh.vertices[:, 2], stops, limits)
    has = {"labels": mesh.labels, "textures": mesh.materials, "colors": mesh.vertex_colors}[what]
    if has is None or not len(mesh.labels if what == "labels" else (1,)):
        raise MapFileError("layer", path, "the mesh has no %s" % what, "mesh_tool info says more")
    if what == "colors":
        return VertexColors(mesh.faces, mesh.vertex_colors)
    return Labels(mesh) if what == "labels" else Textures(mesh)


def _face_values(path, mesh, what, name):
    single = {key: v for key, v in mesh.face_attributes.items() if v.ndim == 1 or v.shape[1] == 1}
    if name in single:
        return single[name].reshape(-1)
    known = list(single) + (list(mesh.vertex_costs) if what == "layer" else [])
    raise MapFileError(
        "layer",
        path,
        "there is no %s %r" % ("layer" if what == "layer" else "face attribute", name),
        "there are: " + ", ".join(known) if known else "the mesh has none",
    )


def paint_mesh(
    mesh: Mesh, camera: Camera, paint, progress: Callable[[float], None] = lambda part: None
) -> np.ndarray:
    """(height, width, 4) uint8 red, green, blue, alpha; alpha 0 where there is no mesh."""
    screen = camera.screen(mesh.vertices, SAMPLES)
    width, height = camera.width * SAMPLES, camera.height * SAMPLES
    face = visible_faces(screen, mesh.faces, width, height, lambda part: progress(0.7 * part))
    flat = face.reshape(-1)
    shown = np.flatnonzero(flat != NO_FACE)
    brightness = _brightness_of(flat[shown], screen, mesh.faces, SAMPLES / camera.pixel)
    picture = np.zeros((len(flat), 4), dtype=np.float32)
    for start in range(0, len(shown), _BLOCK):
        pixel = shown[start : start + _BLOCK]
        corners = screen[mesh.faces[flat[pixel]]]
        colors = paint.colors(flat[pixel], _weights(corners, pixel % width, pixel // width))
        picture[pixel, :3] = colors * brightness[flat[pixel], None]
        picture[pixel, 3] = 1
        progress(0.7 + 0.3 * min(1.0, (start + _BLOCK) / len(shown)))
    total = _of_samples(picture.reshape(height, width, 4))
    total[..., :3] /= np.maximum(total[..., 3:], 1e-6)
    total[..., 3] /= SAMPLES**2
    return np.rint(total.clip(0, 1) * 255).astype(np.uint8)


def _of_samples(picture):
    """(height, width, 4): the sums of the samples of each pixel."""
    steps = range(SAMPLES)
    return sum(picture[row::SAMPLES, column::SAMPLES] for row in steps for column in steps)


def _weights(corners, column, row):
    """(N, 3): how much of each corner a pixel's center is; none below 0, together 1."""
    # corner by corner and axis by axis: NumPy is slow along axes of three
    x, y = column + 0.5, row + 0.5
    a, b, c = ((corners[:, i, 0] - x, corners[:, i, 1] - y) for i in range(3))
    weights = [_cross(b, c), _cross(c, a), _cross(a, b)]
    total = weights[0] + weights[1] + weights[2]
    total[total == 0] = 1
    weights = [np.maximum(area / total, 0) for area in weights]
    total = weights[0] + weights[1] + weights[2]
    inside = total > 0
    total[~inside] = 1
    return np.stack([np.where(inside, weight / total, 1 / 3) for weight in weights], axis=1)


def _cross(a, b):
    return a[0] * b[1] - a[1] * b[0]


def _brightness_of(shown, screen, faces, scale):
    """(F,) float64: of the faces that are shown; 0 of the others."""
    brightness = np.zeros(len(faces))
    brightness[shown] = 1
    known = np.flatnonzero(brightness)
    for start in range(0, len(known), _BLOCK):
        block = known[start : start + _BLOCK]
        brightness[block] = _brightness(screen[faces[block]], scale)
    return brightness


def _brightness(corners, scale):
    """(N,): of faces under a light from the upper left; both sides of a face are the same.

    scale: units of x and y in one meter.
    """
    seen = corners * (1, -1, -scale)  # right, up, towards the viewer
    normal = np.cross(seen[:, 1] - seen[:, 0], seen[:, 2] - seen[:, 0])
    normal *= np.where(normal[:, 2:] < 0, -1, 1)
    length = np.linalg.norm(normal, axis=1)
    lit = (normal @ _LIGHT) / np.where(length > 0, length, 1)
    return _DARKEST + (1 - _DARKEST) * np.clip(lit, 0, 1)
