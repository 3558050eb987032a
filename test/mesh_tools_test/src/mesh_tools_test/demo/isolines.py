"""Lines of equal cost on a mesh, for RViz."""
import numpy as np
from geometry_msgs.msg import Point
from std_msgs.msg import ColorRGBA
from visualization_msgs.msg import Marker

from mesh_msgs_hdf5.rendering.render_figure import round_length

TOPIC = "/isolines"
LINES = 20  # at least, up to the highest value that is known
BLACK, WHITE = ColorRGBA(0, 0, 0, 1), ColorRGBA(1, 1, 1, 1)


def step(highest):
    """The round difference [m] between neighboring lines up to the highest value [m]."""
    return round_length(highest / LINES)


def isolines(vertices, faces, values, difference):
    """Where linear values on faces are multiples of a difference.

    :param vertices: (V, 3) m; faces: (F, 3); values: (V,), those not finite have no lines near them
    :returns: (N, 2, 3) m: ends of N segments; (N,) the value of each
    """
    corners = np.asarray(values, dtype=float)[faces]
    usable = np.isfinite(corners).all(axis=1)
    order = np.argsort(corners[usable], axis=1)
    low, middle, high = np.take_along_axis(corners[usable], order, axis=1).T
    points = vertices[np.take_along_axis(faces[usable], order, axis=1)].astype(float)
    # A face has the lines that are above its lowest value and not above its highest one.
    first, last = np.floor(low / difference) + 1, np.floor(high / difference)
    counts = np.maximum(last - first + 1, 0).astype(int)
    face = np.repeat(np.arange(len(low)), counts)
    number = np.arange(len(face)) - np.repeat(np.cumsum(counts) - counts, counts)
    value = difference * (first[face] + number)
    low, middle, high, points = low[face], middle[face], high[face], points[face]
    on_longest = _between(points[:, 0], points[:, 2], low, high, value)
    on_another = np.where(
        (value <= middle)[:, None],
        _between(points[:, 0], points[:, 1], low, middle, value),
        _between(points[:, 1], points[:, 2], middle, high, value),
    )
    return np.stack([on_longest, on_another], axis=1), value


def _between(start, end, low, high, value):
    span = high - low
    share = np.divide(value - low, span, out=np.zeros_like(span), where=span > 0)
    return start + np.clip(share, 0, 1)[:, None] * (end - start)


def marker(segments, dark, frame, width, height):
    """The segments (N, 2, 3) as a marker of lines of a width at a height [m] above the surface.

    :param dark: (N,) bool, whether the surface is dark there: the line is white, not black
    """
    message = Marker(type=Marker.LINE_LIST, action=Marker.ADD, ns="isolines")
    message.header.frame_id = frame
    message.pose.orientation.w = 1.0
    message.pose.position.z = height
    message.scale.x = width
    message.color = BLACK
    message.points = [Point(*point) for point in segments.reshape(-1, 3)]
    message.colors = [WHITE if each else BLACK for each in np.repeat(dark, 2)]
    return message
