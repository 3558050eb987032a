"""Polygons of more than three corners: which a fan cuts right, and how the others are cut.

Everything is seen along the polygon's own normal (M. Newell: the sum of the cross products), in
bulk; what neither a fan nor the other diagonal of a quad cuts right goes to ear clipping (module
_polygons, in C++).
"""
from typing import Iterator, NamedTuple, Tuple

import numpy as np

from mesh_msgs_hdf5.formats.base.report import ImportReport

_BLOCK_CORNERS = 1 << 20
_THIN = 1e-12  # of the polygon's area: less is no triangle
_CROSSING = 1e-7  # of the polygon's area: a triangle of less, turned over, is rounding
_BENT = 1e-2  # of the polygon's extent: corners off its plane that are told
_ROUND = 2 * np.pi - 1e-6
_CROSS_THEMSELVES = (
    "cross themselves, have no area or too many corners, and were cut as well as can be"
)
_ARE_BENT = "are not planar, and were cut as seen along their normal"


class Shapes(NamedTuple):
    """(P,) bool of polygons: turned: quads that the other diagonal cuts right; concave: those that
    need more than a fan; crossing: quads that no diagonal cuts right, and what has no area;
    bent: not planar. axes: (P, 2, 3) of the plane, in which they go around counterclockwise.
    """

    turned: np.ndarray
    concave: np.ndarray
    crossing: np.ndarray
    bent: np.ndarray
    axes: np.ndarray


def recut(
    counts: np.ndarray,
    starts: np.ndarray,
    corners: np.ndarray,
    positions: np.ndarray,
    places: np.ndarray,
    report: ImportReport,
) -> int:
    """Put right the triangles of polygons that their fans cut wrong; returns how many these are.

    counts, starts: (N,) of each polygon and where its corners begin; corners: the vertices of all
    of them; positions: (V, 3) of the vertices; places: (F, 3) among the corners, the fans of all
    polygons in their order, changed here. The report names those that cross themselves and those
    that are bent.
    """
    triangle_starts = np.cumsum(np.maximum(counts - 2, 0))
    triangle_starts = np.concatenate([[0], triangle_starts[:-1]])
    found, crossing, bent = 0, [], []
    for chosen in _blocks(np.flatnonzero(counts > 3), counts):
        n, first = counts[chosen], starts[chosen]
        local = np.cumsum(n) - n
        at = np.arange(n.sum()) + np.repeat(first - local, n)
        points = positions[corners[at]].astype(np.float64)
        shapes = _shapes(n, local, points)
        quads = chosen[shapes.turned]
        rows, begin = triangle_starts[quads], starts[quads][:, None]
        places[rows] = begin + [1, 2, 3]
        places[rows + 1] = begin + [1, 3, 0]
        wrong = shapes.crossing.copy()
        concave = np.flatnonzero(shapes.concave)
        if len(concave):
            cut, wrong[concave] = _clipped(n[concave], local[concave], points, shapes.axes[concave])
            sizes = n[concave] - 2
            rows = _ranges(triangle_starts[chosen[concave]], sizes)
            begin = np.repeat(first[concave] - (np.cumsum(n[concave]) - n[concave]), sizes)
            places[rows] = cut + begin[:, None]
        found += len(quads) + len(concave)
        crossing.append(chosen[wrong])
        bent.append(chosen[shapes.bent])
    for what, parts in ((_CROSS_THEMSELVES, crossing), (_ARE_BENT, bent)):
        which = np.concatenate(parts) if parts else np.zeros(0, np.int64)
        if len(which):
            text = "%d faces of more than three corners %s, first face %d"
            report.note(text, len(which), what, which[0])
    return found


def _blocks(polygons: np.ndarray, counts: np.ndarray) -> Iterator[np.ndarray]:
    """The polygons in parts, none of many more corners than _BLOCK_CORNERS."""
    block = np.cumsum(counts[polygons]) // _BLOCK_CORNERS
    return iter(np.split(polygons, np.flatnonzero(np.diff(block)) + 1) if len(polygons) else [])


def _ranges(starts: np.ndarray, sizes: np.ndarray) -> np.ndarray:
    """start, start + 1, ... start + size - 1 of each, one after the other."""
    return np.repeat(starts - (np.cumsum(sizes) - sizes), sizes) + np.arange(sizes.sum())


def _shapes(counts: np.ndarray, starts: np.ndarray, points: np.ndarray) -> Shapes:
    """counts: (P,), four or more each; starts: (P,); points: (C, 3) float64 of all corners."""
    with np.errstate(all="ignore"):
        return _shapes_of(counts, starts, points)


def _shapes_of(counts, starts, points):
    of = np.repeat(np.arange(len(counts)), counts)
    last = starts + counts - 1
    behind = np.arange(1, len(points) + 1)
    behind[last] = starts
    away = points - points[starts][of]
    crosses = np.cross(away, away[behind])
    normals = np.add.reduceat(crosses, starts)
    area = np.linalg.norm(normals, axis=1)
    extent = np.maximum.reduceat(np.abs(away).max(axis=1), starts)
    # what rounding leaves of the area of a line, or of two halves that turn against each other
    has_area = area > _THIN * extent * extent
    normals /= np.where(has_area, area, np.inf)[:, None]
    along = normals[of]
    height = (away * along).sum(axis=1)
    depth = np.maximum.reduceat(height, starts) - np.minimum.reduceat(height, starts)
    bent = depth > _BENT * extent
    # doubled areas of the fan's triangles, as seen along the normal
    areas = (crosses * along).sum(axis=1)
    angles = np.arctan2(areas, (away * away[behind]).sum(axis=1))
    areas[starts], areas[last] = np.inf, np.inf
    angles[starts], angles[last] = 0, 0
    least = np.minimum.reduceat(areas, starts)
    sound = (least > _THIN * area) & (np.add.reduceat(angles, starts) < _ROUND)
    is_quad = counts == 4
    turned, crossing = np.zeros((2, len(counts)), bool)
    at = np.flatnonzero(is_quad & ~sound & has_area)
    if len(at):
        other = _other_diagonal(points[starts[at][:, None] + np.arange(4)], normals[at])
        turned[at] = other > np.maximum(least[at], _THIN * area[at])
        crossing[at] = ~turned[at] & (np.minimum(least[at], other) < -_CROSSING * area[at])
    finite = np.isfinite(area) & (area > 0)
    concave = ~is_quad & ~sound & has_area & finite
    return Shapes(
        turned, concave, crossing | ~has_area, bent & finite, _axes(normals, bent & finite)
    )


def _other_diagonal(quads: np.ndarray, normals: np.ndarray) -> np.ndarray:
    """(Q,) the lesser doubled area of the triangles 1 2 3 and 1 3 0 of quads (Q, 4, 3)."""
    a, b, c = (quads[:, i] - quads[:, 1] for i in (2, 3, 0))
    areas = [(np.cross(*pair) * normals).sum(axis=1) for pair in ((a, b), (b, c))]
    return np.minimum(*areas)


def _axes(normals: np.ndarray, bent: np.ndarray) -> np.ndarray:
    """(P, 2, 3): for planar polygons two axes of the frame, which keeps coordinates as they are, to
    the last bit; else two in the plane of the normal.
    """
    largest = np.abs(normals).argmax(axis=1)
    rows = np.arange(len(normals))
    first, second = np.zeros((2, len(normals), 3))
    first[rows, (largest + 1) % 3] = 1
    second[rows, (largest + 2) % 3] = np.where(normals[rows, largest] < 0, -1, 1)
    at = np.flatnonzero(bent)
    if len(at):
        side = np.cross(first[at], normals[at])
        first[at] = side / np.linalg.norm(side, axis=1, keepdims=True)
        second[at] = np.cross(normals[at], first[at])
    return np.stack([first, second], axis=1)


def _clipped(
    counts: np.ndarray, starts: np.ndarray, points: np.ndarray, axes: np.ndarray
) -> Tuple[np.ndarray, np.ndarray]:
    """(triangles (T, 3) as places among the corners of these polygons, (P,) bool which cross
    themselves).
    """
    from mesh_msgs_hdf5 import _polygons

    of = np.repeat(np.arange(len(counts)), counts)
    chosen = points[_ranges(starts, counts)]
    away = chosen - points[starts][of]
    # a power of two changes no digit, and keeps products within float64
    _, exponent = np.frexp(np.abs(away).max(axis=1))
    begins = np.cumsum(counts) - counts
    away = np.ldexp(away, -np.maximum.reduceat(exponent, begins)[of][:, None])
    flat = np.einsum("ci,cji->cj", away, axes[of])
    triangles, unsound = _polygons._triangulate(np.ascontiguousarray(flat), counts)
    return triangles, unsound.astype(bool)
