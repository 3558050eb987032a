"""A picture of numbers: which class (or instance) each pixel shows, for programs that learn."""
import io
from typing import Any, Dict

import numpy as np

from mesh_msgs_hdf5.rendering.render_camera import Camera
from mesh_msgs_hdf5.rendering.render_raster import NO_FACE, visible_faces


def id_picture(
    vertices: np.ndarray, faces: np.ndarray, of_faces: np.ndarray, camera: Camera
) -> np.ndarray:
    """(height, width) uint16: the id (F,) of the face at the center of each pixel, never a mixture;
    0 where there is no face.
    """
    seen = visible_faces(camera.screen(vertices), faces, camera.width, camera.height)
    shown = np.where(seen == NO_FACE, 0, of_faces[np.maximum(seen, 0)])
    return shown.astype(np.uint16)


def gray_png(picture: np.ndarray) -> bytes:
    """A PNG of 16 bits of gray for each pixel of (height, width) uint16."""
    return _png(picture.astype("<u2"))


def bare_png(picture: np.ndarray) -> bytes:
    """A PNG of (height, width, 4) uint8 as it is."""
    return _png(picture)


def _png(picture: np.ndarray) -> bytes:
    from PIL import Image

    stream = io.BytesIO()
    Image.fromarray(np.ascontiguousarray(picture)).save(stream, "PNG")
    return stream.getvalue()


def camera_table(camera: Camera) -> Dict[str, Any]:
    """Where pixels are, as JSON has it: the middle of column x and row y is the point
    (left + (x + 0.5) * pixel) * right + (top - (y + 0.5) * pixel) * up, along the line of sight.
    """
    right, up, viewer = camera.axes.tolist()
    size = {"width": camera.width, "height": camera.height, "pixel": camera.pixel}
    place = {"left": camera.left, "top": camera.top, "right": right, "up": up, "viewer": viewer}
    return {"projection": "parallel", **size, **place}
