"""Where a picture is seen from: parallel projection, so that lengths can be measured in it."""
import math
from typing import NamedTuple, Tuple

import numpy as np

from mesh_msgs_hdf5.rendering.render_raster import NO_FACE, visible_faces

# azimuth and elevation in degrees of the place one looks from; top: x to the right, y up
VIEWS = {
    "top": (-90.0, 90.0),
    "iso": (-45.0, math.degrees(math.atan(math.sqrt(0.5)))),
    "front": (-90.0, 0.0),
    "side": (0.0, 0.0),
}
_MARGIN = 0.03  # of the picture's size, on each side
# for the usual view: pixels of a picture that need not be good, faces at a time, how much of a
# normal is up in what is level, and how often such surfaces cover the ground where several do
_ROUGHLY, _FACES, _LEVEL, _OVER_EACH_OTHER = 256, 1 << 19, 0.7, 1.4


class Camera(NamedTuple):
    """axes: (3, 3) float64, rows right, up and towards the viewer; left, top in meters along right
    and up: the picture's corner; pixel: meters per pixel; width, height in pixels.
    """

    axes: np.ndarray
    left: float
    top: float
    pixel: float
    width: int
    height: int

    def screen(self, vertices: np.ndarray, samples: int = 1) -> np.ndarray:
        """(V, 3) float64: x right and y down in pixels / samples, depth in meters."""
        seen = vertices.astype(np.float64) @ self.axes.T
        scale = samples / self.pixel
        seen[:, 0] = (seen[:, 0] - self.left) * scale
        seen[:, 1] = (self.top - seen[:, 1]) * scale
        seen[:, 2] *= -1
        return seen

    @property
    def extent(self) -> Tuple[float, float, float, float]:
        """left, right, bottom, top in meters."""
        right, bottom = self.left + self.width * self.pixel, self.top - self.height * self.pixel
        return self.left, right, bottom, self.top


def look_at(vertices: np.ndarray, view: Tuple[float, float], width: int, height: int) -> Camera:
    """A camera that has all vertices (V, 3) in its picture of width x height pixels.

    view: azimuth and elevation in degrees; the x axis is azimuth 0, straight down elevation 90.
    """
    axes = view_axes(*view)
    seen = vertices.astype(np.float64) @ axes[:2].T
    low, high = seen.min(axis=0), seen.max(axis=0)
    size = (1 - 2 * _MARGIN) * np.array([width, height])
    pixel = float(np.max((high - low) / size)) or 1.0 / max(width, height)
    middle = (low + high) / 2
    left, top = middle[0] - pixel * width / 2, middle[1] + pixel * height / 2
    return Camera(axes, float(left), float(top), pixel, width, height)


def parsed_view(text: str) -> Tuple[float, float]:
    """The view of a name in VIEWS, or of "AZIMUTH,ELEVATION" in degrees. Raises ValueError."""
    if text in VIEWS:
        return VIEWS[text]
    azimuth, elevation = (float(value) for value in text.split(","))
    if not (abs(azimuth) <= 360 and abs(elevation) <= 90):
        raise ValueError(text)
    return azimuth, elevation


parsed_view.__name__ = "view"


def usual_view(vertices: np.ndarray, faces: np.ndarray) -> Tuple[float, float]:
    """From above, or iso where level surfaces lie over each other, as storeys do: from above, one
    sees only the highest.
    """
    camera = look_at(vertices, VIEWS["top"], _ROUGHLY, _ROUGHLY)
    screen = camera.screen(vertices)
    area = 0.0
    for start in range(0, len(faces), _FACES):
        a, b, c = screen[faces[start : start + _FACES]].transpose(1, 0, 2)
        normals = np.cross(b - a, c - a)
        normals[:, :2] /= camera.pixel  # depth is in meters, all else in pixels
        is_level = np.abs(normals[:, 2]) > _LEVEL * np.linalg.norm(normals, axis=1)
        area += float(np.abs(normals[is_level, 2]).sum()) / 2
    seen = np.count_nonzero(visible_faces(screen, faces, _ROUGHLY, _ROUGHLY) != NO_FACE)
    return VIEWS["iso" if area > _OVER_EACH_OTHER * seen else "top"]


def axis_names(axes: np.ndarray) -> Tuple[str, str]:
    """Which axes of the frame point right and up; ("", "") in an oblique view."""
    right, up = ("xyz"[row.argmax()] if row.max() == 1 else "" for row in axes[:2])
    return (right, up) if right and up else ("", "")


def view_axes(azimuth: float, elevation: float) -> np.ndarray:
    """(3, 3) float64: right, up and towards the viewer, who is at this azimuth and elevation."""
    a, e = math.radians(azimuth), math.radians(elevation)
    axes = np.array(
        [
            [-math.sin(a), math.cos(a), 0],
            [-math.sin(e) * math.cos(a), -math.sin(e) * math.sin(a), math.cos(e)],
            [math.cos(e) * math.cos(a), math.cos(e) * math.sin(a), math.sin(e)],
        ]
    )
    return np.where(np.abs(axes) < 1e-12, 0, axes)  # straight views are exact
