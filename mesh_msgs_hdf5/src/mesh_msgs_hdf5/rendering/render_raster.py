"""Which face each pixel of a picture shows: scan conversion of triangles with a depth buffer.

A pixel belongs to a triangle if its center does. The ends of a row are computed from an edge alone,
so that two faces with a common edge leave neither a gap nor a double pixel between them.
"""
from typing import Callable, Iterator, Tuple

import numpy as np

_FACES, _ROWS, _PIXELS = 1 << 19, 1 << 16, 1 << 16  # handled at a time: in the caches
NO_FACE = -1


def visible_faces(
    screen: np.ndarray,
    faces: np.ndarray,
    width: int,
    height: int,
    progress: Callable[[float], None] = lambda part: None,
) -> np.ndarray:
    """(height, width) int32: the nearest face at each pixel's center, NO_FACE where there is none.

    screen: (V, 3) float64: x to the right and y down in pixels from the picture's corner, depth
    (any unit; smaller is nearer). faces: (F, 3). progress: is told the part done, from 0 to 1.
    """
    nearest = np.full(width * height, np.inf)
    shown = np.full(width * height, NO_FACE, dtype=np.int32)
    for start in range(0, len(faces), _FACES):
        corners = screen[faces[start : start + _FACES]]
        for index, pixel, depth in _pixels(corners, width, height):
            _put(nearest, shown, pixel, depth, index + start)
        progress(min(1.0, (start + _FACES) / len(faces)))
    return shown.reshape(height, width)


def _put(nearest, shown, pixel, depth, face):
    """Write what is nearer than what stands there; of several for one pixel the nearest stays."""
    while len(pixel):
        nearer = depth < nearest[pixel]
        pixel, depth, face = pixel[nearer], depth[nearer], face[nearer]
        nearest[pixel] = depth  # where a pixel comes several times, one of them
        written = nearest[pixel] == depth
        shown[pixel[written]] = face[written]


def _pixels(corners, width, height) -> Iterator[Tuple[np.ndarray, np.ndarray, np.ndarray]]:
    """Blocks of (face, pixel, depth); face counts within corners (N, 3, 3)."""
    low, high = corners.min(axis=1), corners.max(axis=1)
    first = np.ceil(low[:, :2] - 0.5).clip(0, (width, height)).astype(np.int64)
    end = np.ceil(high[:, :2] - 0.5).clip(0, (width, height)).astype(np.int64)
    kept = np.flatnonzero((end > first).all(axis=1))
    if not len(kept):
        return
    corners, first_row = corners[kept], first[kept, 1]
    order = np.argsort(corners[:, :, 1], axis=1, kind="stable")
    corners = np.take_along_axis(corners, order[:, :, None], axis=1)
    slopes = _slopes(corners)
    depths = low[kept, 2], high[kept, 2]
    for index, row in _expand(end[kept, 1] - first_row, first_row, _ROWS):
        begin, stop = _ends(corners[index], row + 0.5)
        column = np.ceil(begin - 0.5).clip(0, width).astype(np.int64)
        count = np.ceil(stop - 0.5).clip(0, width).astype(np.int64) - column
        for span, x in _expand(count, column, _PIXELS):
            face, y = index[span], row[span]
            a = corners[face, 0]
            depth = a[:, 2] + slopes[face, 0] * (x + 0.5 - a[:, 0])
            depth += slopes[face, 1] * (y + 0.5 - a[:, 1])
            # thin faces have steep planes: no pixel is outside the face's own depths
            depth = np.clip(depth, depths[0][face], depths[1][face])
            yield kept[face], y * width + x, depth


def _slopes(corners):
    """(N, 2): how depth changes with x and y on each face's plane."""
    a = corners[:, 0]
    b, c = corners[:, 1] - a, corners[:, 2] - a
    area = b[:, 0] * c[:, 1] - c[:, 0] * b[:, 1]
    along_x = b[:, 2] * c[:, 1] - c[:, 2] * b[:, 1]
    along_y = b[:, 0] * c[:, 2] - c[:, 0] * b[:, 2]
    area = np.where(area == 0, np.inf, area)  # seen from its edge: flat
    return np.stack([along_x / area, along_y / area], axis=1)


def _ends(corners, y):
    """Where rows enter and leave faces whose corners a, b, c are sorted by y."""
    a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]
    upper = (y < b[:, 1])[:, None]
    long_edge = _crossing(a, c, y)
    short_edge = _crossing(np.where(upper, a, b), np.where(upper, b, c), y)
    return np.minimum(long_edge, short_edge), np.maximum(long_edge, short_edge)


def _crossing(a, b, y):
    return a[:, 0] + (y - a[:, 1]) * (b[:, 0] - a[:, 0]) / (b[:, 1] - a[:, 1])


def _expand(counts, starts, most):
    """Blocks of about most (index, value): value runs from starts[index], counts[index] times."""
    ends = np.cumsum(counts)
    done = 0
    while done < len(counts):
        before = ends[done - 1] if done else 0
        stop = max(done + 1, int(np.searchsorted(ends, before + most, side="right")))
        here = counts[done:stop]
        index = np.repeat(np.arange(done, stop), here)
        offset = np.arange(len(index)) - np.repeat(np.cumsum(here) - here, here)
        if len(index):
            yield index, starts[index] + offset
        done = stop
