"""Polygons and triangle soups to indexed triangles, vectorized."""
from typing import NamedTuple, Optional, Tuple

import numpy as np

from mesh_msgs_hdf5.formats.base.concave import recut
from mesh_msgs_hdf5.formats.base.equal_rows import by_appearance, equal_rows
from mesh_msgs_hdf5.formats.base.report import ImportReport
from mesh_msgs_hdf5.model.errors import MapFileError, PathLike


def check_corners(
    path: PathLike,
    counts: np.ndarray,
    corners: np.ndarray,
    vertex_count: int,
    shown: Optional[np.ndarray] = None,
) -> None:
    """Refuse polygons that refer to no vertex.

    counts: (N,) corners of each polygon; corners: all their vertex indices, one after the other,
    signed or wide enough;
    shown: the indices as they stand in the file, where they differ (for the message).
    """
    wrong = corners >= vertex_count
    if corners.dtype.kind == "i":
        wrong |= corners < 0
    if not wrong.any():
        return
    at = np.flatnonzero(wrong)
    polygons = np.searchsorted(np.cumsum(counts), at, side="right")
    raise MapFileError(
        "index",
        path,
        "face %d refers to vertex %d, but the file has %d vertices; %d faces do so"
        % (
            polygons[0],
            (corners if shown is None else shown)[at[0]],
            vertex_count,
            len(np.unique(polygons)),
        ),
        "repair the mesh where it was made",
    )


def polygon_edges(counts: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """(N, 2) both ends of every edge of polygons; as check_corners has them."""
    behind = np.arange(1, len(corners) + 1)
    ends = np.cumsum(counts)
    has_corners = counts > 0
    behind[ends[has_corners] - 1] = (ends - counts)[has_corners]
    return np.stack([corners, corners[behind]], axis=1)


def triangle_edges(faces: np.ndarray) -> np.ndarray:
    """(3 F, 2) both ends of every edge of triangles (F, 3)."""
    return np.stack([faces, np.roll(faces, -1, axis=1)], axis=2).reshape(-1, 2)


class Triangles(NamedTuple):
    """faces: (F, 3) uint32; polygons: (F,) from which polygon each comes, places: (F, 3) from which
    place in the list of all corners; both None if every polygon is a triangle.
    """

    faces: np.ndarray
    polygons: Optional[np.ndarray] = None
    places: Optional[np.ndarray] = None

    def of_polygons(self, values: np.ndarray) -> np.ndarray:
        """Values (F, ...) of the triangles from values of the polygons."""
        return values if self.polygons is None else values[self.polygons]

    def of_corners(self, values: np.ndarray) -> np.ndarray:
        """Values (3 F, ...) of the triangles' corners from values of the polygons' corners."""
        return values if self.places is None else values[self.places.reshape(-1)]


def triangulate(
    counts: np.ndarray, corners: np.ndarray, positions: np.ndarray, report: ImportReport
) -> Triangles:
    """The triangles of polygons in their order: fans from the first corner where these are right,
    else as recut says.

    counts: (N,) corners of each polygon; corners: all their vertices, one after the other;
    positions: (V, 3) of the vertices. Polygons of more than three corners are counted, those of
    fewer are left out; the report says both.
    """
    counts = np.asarray(counts, dtype=np.int64)
    large, small = np.count_nonzero(counts > 3), np.flatnonzero(counts < 3)
    if not large and not len(small):
        return Triangles(np.ascontiguousarray(corners, dtype="<u4").reshape(-1, 3))
    triangles = np.maximum(counts - 2, 0)
    begins = np.cumsum(counts) - counts
    starts = np.repeat(begins, triangles)
    step = np.arange(triangles.sum()) - np.repeat(np.cumsum(triangles) - triangles, triangles)
    places = np.stack([starts, starts + step + 1, starts + step + 2], axis=1)
    if large:
        report.triangulated += int(large)
        at = len(report.notes)
        recuts = recut(counts, begins, corners, positions, places, report)
        text = "%d faces of more than three corners were cut into triangles (fans%s)" % (
            large,
            ", but for %d concave ones" % recuts if recuts else "",
        )
        report.notes.insert(at, text)
    if len(small):
        report.note(
            "%d faces of fewer than three corners were left out, first face %d",
            len(small),
            small[0],
        )
    polygons = np.repeat(np.arange(len(counts)), triangles)
    return Triangles(np.ascontiguousarray(corners[places], dtype="<u4"), polygons, places)


def strip_triangles(index: np.ndarray) -> np.ndarray:
    """(F, 3) of triangle strips (N,), one after the other with -1 between.

    Every second triangle of a strip is turned, so that all go around the same way. Triangles that
    name a vertex twice, by which strips are put together, are none.
    """
    if len(index) < 3:
        return np.zeros((0, 3), index.dtype)
    faces = np.stack([index[:-2], index[1:-1], index[2:]], axis=1)
    place = np.arange(len(index))
    starts = np.maximum.accumulate(np.where(index == -1, place + 1, 0))
    odd = (place - starts)[:-2] % 2 == 1
    faces[odd, 1:] = faces[odd, :0:-1].copy()
    whole = (faces != -1).all(axis=1) & (faces != np.roll(faces, 1, axis=1)).all(axis=1)
    return faces[whole]


def weld(corners: np.ndarray, report: ImportReport) -> Tuple[np.ndarray, np.ndarray]:
    """Vertices and faces of a triangle soup: corners at the same position become one vertex.

    corners: (N, 3) float32 positions. Returns (vertices (V, 3) float32 in the order in which they
    come first, index (N,) int64 of each corner's vertex).
    """
    positions = corners + np.float32(0)  # -0.0 and 0.0 are one place
    first, index = by_appearance(*equal_rows(positions.T))
    report.merged += len(corners) - len(first)
    report.note(
        "welded: %d corners at %d different positions; the order of vertices is that of the faces",
        len(corners),
        len(first),
    )
    return np.ascontiguousarray(positions[first]), index
