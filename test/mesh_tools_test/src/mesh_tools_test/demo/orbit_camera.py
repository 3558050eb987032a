"""RViz's Orbit camera: fitted to a whole map, and where in its picture a point is."""
from typing import NamedTuple, Tuple

import numpy as np

HALF = np.tan(np.radians(45) / 2)  # half the height that the camera sees, at a distance of 1
PITCH = 0.9  # rad, down from the horizon
ASIDE = np.radians(np.arange(-30, 31, 5))  # off the azimuth square to the way
LEFT, RIGHT, TOP, BOTTOM = 16, 150, 16, 16  # pixels that stay free: at the right is the legend


class OrbitCamera(NamedTuple):
    """focal_point: (3,) m; distance: of the eye from there [m]; yaw, pitch: of the eye, seen from
    there [rad]; size: width and height of the 3D view [pixels]."""

    focal_point: np.ndarray
    distance: float
    yaw: float
    pitch: float
    size: Tuple[int, int]

    @property
    def axes(self):
        """(3, 3): right, up and towards the eye, as rows."""
        return _axes(self.yaw, self.pitch)

    def meters(self, points):
        """How long a pixel is at the depth of points (N, 3): (N,) m."""
        depth = self.distance - (np.asarray(points) - self.focal_point) @ self.axes[2]
        return 2 * HALF * depth / self.size[1]

    @property
    def pixel(self):
        """How long a pixel is at the focal point [m]."""
        return float(2 * HALF * self.distance / self.size[1])

    def pixels(self, points):
        """(N, 2) columns and rows of points (N, 3), from the upper left corner of the 3D view."""
        points = np.asarray(points, dtype=float)
        seen = (points - self.focal_point) @ self.axes[:2].T / self.meters(points)[:, None]
        return np.array(self.size) / 2 + seen * (1, -1)

    def view(self):
        """The camera in a .rviz file."""
        return {
            "Class": "rviz/Orbit",
            "Name": "Current View",
            "Target Frame": "<Fixed Frame>",
            "Distance": float(self.distance),
            "Focal Point": dict(zip("XYZ", map(float, self.focal_point))),
            "Pitch": float(self.pitch),
            "Yaw": float(self.yaw % (2 * np.pi)),
            "Near Clip Distance": float(0.005 * self.distance),
        }


def whole_map(vertices, start, goal, size):
    """The OrbitCamera that shows a map (V, 3) as large as it gets, from about the side of the way.

    start (3,) is to the left of goal (3,); size: of the 3D view, width and height [pixels].
    """
    along = np.arctan2(goal[1] - start[1], goal[0] - start[0])
    cameras = [fitted(vertices, along - np.pi / 2 + aside, size) for aside in ASIDE]
    return min(cameras, key=lambda camera: camera.distance)


def fitted(vertices, yaw, size):
    """The nearest OrbitCamera of an azimuth [rad] that has all points (V, 3) in the free pixels."""
    axes, (width, height) = _axes(yaw, PITCH), size
    x, y, near = axes @ np.asarray(vertices, dtype=float).T
    slope = 2 * HALF / height  # of the ray through a pixel, for each pixel off the middle
    # Each edge of the free pixels is a plane through the eye, behind which no point may be; the
    # eye is at (x, y, near) too. Where these four planes meet, it is nearest.
    sides = (x, slope * (width / 2 - LEFT), slope * (width / 2 - RIGHT))
    heights = (y, slope * (height / 2 - BOTTOM), slope * (height / 2 - TOP))
    bounds = [
        ((values - least * near).min(), (values + most * near).max(), least, most)
        for values, least, most in (sides, heights)
    ]
    eye_near = max((high - low) / (least + most) for low, high, least, most in bounds)
    eye = [
        (low + least * eye_near + high - most * eye_near) / 2 for low, high, least, most in bounds
    ]
    focus = (near.min() + near.max()) / 2
    return OrbitCamera(
        np.array([*eye, focus]) @ axes, eye_near - focus, yaw, PITCH, (width, height)
    )


def _axes(yaw, pitch):
    towards = np.cos(yaw) * np.cos(pitch), np.sin(yaw) * np.cos(pitch), np.sin(pitch)
    right = -np.sin(yaw), np.cos(yaw), 0.0
    return np.array([right, np.cross(towards, right), towards])
