"""Markers that RViz shows: vector fields, points and triangles."""

from typing import Any, Optional, Sequence

import genpy
import numpy as np
from geometry_msgs.msg import Point
from std_msgs.msg import ColorRGBA
from visualization_msgs.msg import Marker

ARROW_LENGTH = 0.1  # m
LIFT = 0.01  # m above the surface, so that it does not hide the lines
SPHERE_DIAMETER = 0.05  # m
# A marker is a list of objects: more lines than these take seconds and show nothing more.
MAX_LINES = 20_000


def vector_field_marker(
    vertices: np.ndarray,
    vectors: np.ndarray,
    values: np.ndarray,
    frame_id: str,
    stamp: genpy.Time,
    namespace: str = "vector_field",
) -> Marker:
    """One line per vertex that has a direction, colored by its value from purple to red.

    Where there are more than MAX_LINES, only each second, third, … is drawn.

    Args:
        vertices: (V, 3) m.
        vectors: (V, 3) of length 1 or less, zero where there is none.
        values: (V,) >= 0; purple is 0, red the largest one that is drawn, and what is not finite.
        frame_id: of the vertices.
        stamp: of the marker.
        namespace: under which RViz lists it.
    """
    shown = _drawn(vectors)
    marker = _marker(Marker.LINE_LIST, namespace, frame_id, stamp)
    return _with_lines(marker, vertices[shown], vectors[shown], values[shown])


def face_vectors_marker(
    vertices: np.ndarray,
    faces: np.ndarray,
    vectors: np.ndarray,
    values: np.ndarray,
    frame_id: str,
    stamp: genpy.Time,
    namespace: str = "face_vectors",
) -> Marker:
    """As vector_field_marker, with lines that begin in the middle of faces.

    Args:
        vertices, faces: (V, 3) m and (F, 3).
        vectors: (F, 3) of length 1 or less, zero where there is none.
        values: (V,) at the vertices: a line has the color of the mean at the corners of its face.
        frame_id, stamp, namespace: of the marker.
    """
    shown = _drawn(vectors)
    corners = faces[shown]
    centers = vertices[corners].astype(np.float64).mean(axis=1)
    means = values[corners].astype(np.float64).mean(axis=1)
    marker = _marker(Marker.LINE_LIST, namespace, frame_id, stamp)
    return _with_lines(marker, centers, vectors[shown], means)


def _drawn(vectors: np.ndarray) -> np.ndarray:
    """Indices of the vectors to be drawn: MAX_LINES at most of those that are not zero."""
    shown = np.flatnonzero(np.any(vectors != 0, axis=1))
    return shown[:: -(-len(shown) // MAX_LINES) or 1]


def _with_lines(
    marker: Marker, places: np.ndarray, vectors: np.ndarray, values: np.ndarray
) -> Marker:
    """The marker, with a line from each of N places along its vector, colored by its value."""
    marker.scale.x = 0.01
    begins = places + np.array([0.0, 0.0, LIFT])
    ends = begins + ARROW_LENGTH * vectors
    points = np.stack([begins, ends], axis=1).reshape(-1, 3)
    drawn = values.astype(np.float64)
    finite = np.isfinite(drawn)
    scaled = np.where(finite, drawn / max(float(drawn[finite].max(initial=0.0)), 1e-9), 1.0)
    colors = np.repeat(rainbow(scaled), 2, axis=0)
    marker.points = [Point(*point) for point in points.tolist()]
    marker.colors = [ColorRGBA(*color, 1.0) for color in colors.tolist()]
    return marker


def sphere_marker(
    namespace: str,
    position: Any,
    frame_id: str,
    stamp: genpy.Time,
    color: Sequence[float] = (1.0, 0.0, 0.0, 1.0),
) -> Marker:
    """A small sphere.

    Args:
        namespace: under which RViz lists it.
        position: (3,) m, its center.
        frame_id, stamp: of the marker.
        color: red, green, blue, alpha, 0 to 1.
    """
    marker = _marker(Marker.SPHERE, namespace, frame_id, stamp)
    marker.pose.position = Point(*map(float, position))
    marker.scale.x = marker.scale.y = marker.scale.z = SPHERE_DIAMETER
    marker.color = ColorRGBA(*color)
    return marker


def triangles_marker(
    namespace: str,
    corners: Any,
    frame_id: str,
    stamp: genpy.Time,
    color: Sequence[float] = (1.0, 0.0, 0.0, 0.5),
    normal: Optional[Any] = None,
) -> Marker:
    """Triangles.

    Args:
        namespace: under which RViz lists them.
        corners: (3 N, 3) m, three of each.
        frame_id, stamp: of the marker.
        color: red, green, blue, alpha, 0 to 1.
        normal: (3,) of length 1: they are lifted a little along it, so that they can be seen on the
            surface that they are part of; None to leave them where they are.
    """
    marker = _marker(Marker.TRIANGLE_LIST, namespace, frame_id, stamp)
    marker.scale.x = marker.scale.y = marker.scale.z = 1.0
    marker.color = ColorRGBA(*color)
    points = np.asarray(corners, np.float64).reshape(-1, 3)
    if normal is not None:
        points = points + LIFT * np.asarray(normal, np.float64)
    marker.points = [Point(*point) for point in points.tolist()]
    return marker


def no_marker(namespace: str, frame_id: str, stamp: genpy.Time) -> Marker:
    """Takes the one of this namespace away."""
    marker = _marker(Marker.SPHERE, namespace, frame_id, stamp)
    marker.action = Marker.DELETE
    return marker


def rainbow(values: np.ndarray) -> np.ndarray:
    """(N, 3) colors, each channel 0 to 1, of (N,) values from 0 (purple) to 1 (red)."""
    section, fraction = np.divmod(5 * np.asarray(values, dtype=np.float64) + 1, 1)
    n = np.where(section % 2 == 0, fraction, 1 - fraction)[:, None]
    zero, one = np.zeros_like(n), np.ones_like(n)
    of_sections = [[n, zero, one], [zero, n, one], [zero, one, n], [n, one, zero], [one, n, zero]]
    colors = np.stack([np.concatenate(channels, axis=1) for channels in of_sections])
    return colors[np.clip(section.astype(int) - 1, 0, 4), np.arange(len(n))]


def _marker(kind: int, namespace: str, frame_id: str, stamp: genpy.Time) -> Marker:
    marker = Marker(ns=namespace, type=kind, action=Marker.ADD)
    marker.header.frame_id, marker.header.stamp = frame_id, stamp
    marker.pose.orientation.w = 1.0  # four zeros are no rotation, and RViz complains
    return marker
