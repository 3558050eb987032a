"""Markers that RViz shows: vector fields, points and triangles."""

from typing import Any, Optional, Sequence

import genpy
import numpy as np
from geometry_msgs.msg import Point
from mesh_msgs_hdf5.rendering.render_scale import RAINBOW, scale_colors
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
    faces: Optional[np.ndarray] = None,
) -> Marker:
    """One line per vertex or face that has a direction, colored by its value from purple to red.

    Where there are more than MAX_LINES, only each second, third, … is drawn.

    Args:
        vertices: (V, 3) m.
        vectors: (V, 3) of length 1 or less, zero where there is none; with faces (F, 3).
        values: (V,) >= 0; purple is 0, red the largest one that is drawn, and what is not finite.
        frame_id: of the vertices.
        stamp: of the marker.
        namespace: under which RViz lists it.
        faces: (F, 3), for lines that begin in the middle of faces; the value of a face is the mean
            of those at its corners. None for lines that begin at vertices.
    """
    shown = np.flatnonzero(np.any(vectors != 0, axis=1))
    shown = shown[:: -(-len(shown) // MAX_LINES) or 1]
    if faces is None:
        places, drawn = vertices[shown], values[shown].astype(np.float64)
    else:
        corners = faces[shown]
        places = vertices[corners].astype(np.float64).mean(axis=1)
        drawn = values[corners].astype(np.float64).mean(axis=1)
    marker = _marker(Marker.LINE_LIST, namespace, frame_id, stamp)
    marker.scale.x = 0.01
    begins = places + np.array([0.0, 0.0, LIFT])
    ends = begins + ARROW_LENGTH * vectors[shown]
    points = np.stack([begins, ends], axis=1).reshape(-1, 3)
    finite = np.isfinite(drawn)
    scaled = np.where(finite, drawn / max(float(drawn[finite].max(initial=0.0)), 1e-9), 1.0)
    colors = np.repeat(scale_colors(RAINBOW, scaled), 2, axis=0)
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


def _marker(kind: int, namespace: str, frame_id: str, stamp: genpy.Time) -> Marker:
    marker = Marker(ns=namespace, type=kind, action=Marker.ADD)
    marker.header.frame_id, marker.header.stamp = frame_id, stamp
    marker.pose.orientation.w = 1.0  # four zeros are no rotation, and RViz complains
    return marker
