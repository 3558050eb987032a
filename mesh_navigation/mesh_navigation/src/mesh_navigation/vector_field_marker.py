"""A vector field as a marker that RViz shows."""

import genpy
import numpy as np
from geometry_msgs.msg import Point
from std_msgs.msg import ColorRGBA
from visualization_msgs.msg import Marker

ARROW_LENGTH = 0.1  # m
LIFT = 0.01  # m above the surface, so that it does not hide the lines
# A marker is a list of objects: more lines than these take seconds and show nothing more.
MAX_LINES = 20_000


def vector_field_marker(
    vertices: np.ndarray,
    vectors: np.ndarray,
    potential: np.ndarray,
    frame_id: str,
    stamp: genpy.Time,
) -> Marker:
    """One line per vertex that has a direction, colored by the potential from purple to red.

    Args:
        vertices: (V,3) m.
        vectors: (V,3) unit vectors, zero where there is none.
        potential: (V,) finite where there is a vector.
        frame_id: of the vertices.
        stamp: of the marker.
    """
    marker = Marker(ns="vector_field", type=Marker.LINE_LIST, action=Marker.ADD)
    marker.header.frame_id, marker.header.stamp = frame_id, stamp
    marker.pose.orientation.w = 1.0
    marker.scale.x = 0.01
    shown = np.flatnonzero(np.any(vectors != 0, axis=1))
    shown = shown[:: -(-len(shown) // MAX_LINES) or 1]
    begins = vertices[shown] + np.array([0.0, 0.0, LIFT])
    ends = begins + ARROW_LENGTH * vectors[shown]
    points = np.stack([begins, ends], axis=1).reshape(-1, 3)
    values = potential[shown] / max(float(potential[shown].max(initial=0.0)), 1e-9)
    colors = np.repeat(rainbow(values), 2, axis=0)
    marker.points = [Point(*point) for point in points.tolist()]
    marker.colors = [ColorRGBA(*color, 1.0) for color in colors.tolist()]
    return marker


def rainbow(values: np.ndarray) -> np.ndarray:
    """(N,3) colors, each channel 0 to 1, of (N,) values from 0 (purple) to 1 (red)."""
    section, fraction = np.divmod(5 * np.asarray(values, dtype=np.float64) + 1, 1)
    n = np.where(section % 2 == 0, fraction, 1 - fraction)[:, None]
    zero, one = np.zeros_like(n), np.ones_like(n)
    of_sections = [[n, zero, one], [zero, n, one], [zero, one, n], [n, one, zero], [one, n, zero]]
    colors = np.stack([np.concatenate(channels, axis=1) for channels in of_sections])
    return colors[np.clip(section.astype(int) - 1, 0, 4), np.arange(len(n))]
