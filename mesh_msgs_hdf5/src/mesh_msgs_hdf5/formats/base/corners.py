"""Values of corners of faces as values of vertices: where they agree, or by splitting vertices."""
from typing import NamedTuple, Optional, Tuple

import numpy as np

from mesh_msgs_hdf5.formats.base.equal_rows import equal_rows
from mesh_msgs_hdf5.formats.base.polygons import Triangles
from mesh_msgs_hdf5.formats.base.remap import take_vertices
from mesh_msgs_hdf5.formats.base.report import ImportReport
from mesh_msgs_hdf5.model.mending import mended_coordinates
from mesh_msgs_hdf5.model.mesh import Mesh


def agreed(index: np.ndarray, values: np.ndarray, vertex_count: int) -> Optional[np.ndarray]:
    """Values (vertex_count, ...) of vertices from values (N, ...) of corners.

    index: (N,) vertex of each corner. None if a vertex has corners of different values; 0 where a
    vertex has no corner. NaN is the same as NaN.
    """
    result = np.zeros((vertex_count,) + values.shape[1:], values.dtype)
    result[index] = values
    found = result[index]
    same = found == values
    if values.dtype.kind == "f":
        same |= np.isnan(found) & np.isnan(values)
    return result if same.all() else None


def note_seams(count: int, report: ImportReport) -> None:
    """Say that texture coordinates are left out because so many vertices have several."""
    text = "texture coordinates left out: %d vertices have several (seams); --split-seams"
    report.note(text + " keeps them", count)


def note_missing(count: int, report: ImportReport) -> None:
    """Say how many corners have no texture coordinates."""
    if count:
        report.note("%d face corners have no texture coordinates", count)


class CornerVertices(NamedTuple):
    """The outcome of texture_vertices.

    coordinates: (V + len(originals), 2), or None: left out; index: (N,) vertex of each corner, as
    it was or with the copies; originals: the vertex that each copy is one of.
    """

    coordinates: Optional[np.ndarray]
    index: np.ndarray
    originals: np.ndarray

    def given_to(self, mesh: Mesh, faces: np.ndarray) -> Mesh:
        """The mesh with the coordinates and the copies that they need; faces: (F, 3) of index."""
        if len(self.originals):
            rows = np.append(np.arange(len(mesh.vertices)), self.originals)
            mesh = take_vertices(mesh, rows)
            mesh.faces = faces.astype(np.uint32)
            mesh.seam_originals = self.originals.astype(np.uint32)
        mesh.texture_coordinates = self.coordinates
        return mesh


def texture_vertices(
    index: np.ndarray,
    coordinates: np.ndarray,
    known: Optional[np.ndarray],
    vertex_count: int,
    faces: np.ndarray,
    split: bool,
    report: ImportReport,
) -> CornerVertices:
    """Texture coordinates of vertices from those of corners.

    index: (N,) vertex of each corner; coordinates: (N, 2) float32; known: (N,) bool, which corners
    have one, or None for all; faces: (F, 3) which corners are those of a triangle: one that is not
    finite gets the mean of those beside it, with a note. A vertex whose corners differ is split if
    asked for: the first coordinates stay with it, a copy for each further pair is appended behind
    all others; else the coordinates are left out, and the report says how many.
    """
    none = np.zeros(0, np.int64)
    coordinates = np.ascontiguousarray(coordinates + np.float32(0))  # -0.0 is 0.0
    at = np.arange(len(index)) if known is None else np.flatnonzero(known)
    wrong = at[~np.isfinite(coordinates[at]).all(axis=1)]
    if len(wrong) and len(wrong) == len(at):
        report.note("texture coordinates left out: those of all %d corners are not finite", len(at))
        return CornerVertices(None, index, none)
    if len(wrong):
        text = "texture coordinates of %d corners are not finite: the mean of those beside them, "
        report.note(text + "first corner %d", len(wrong), wrong[0])
        coordinates[wrong] = _mended(index, coordinates, at, wrong, vertex_count, faces)
    if not coordinates[at].any():
        if len(at):  # what some programs write where there are none
            report.note("texture coordinates left out: all of them are 0")
        return CornerVertices(None, index, none)
    note_missing(len(index) - len(at), report)
    result = agreed(index[at], coordinates[at], vertex_count)
    if result is not None:
        return CornerVertices(result, index, none)
    vertex, pair, first = _pairs(index[at], coordinates[at])
    own = np.ones(len(vertex), bool)
    own[1:] = vertex[1:] != vertex[:-1]
    if not split:
        note_seams(len(np.unique(vertex[~own])), report)
        return CornerVertices(None, index, none)
    # the pairs that need a vertex of their own, in the order in which they come first
    extra = np.flatnonzero(~own)[np.argsort(first[~own], kind="stable")]
    place = vertex.copy()
    place[extra] = vertex_count + np.arange(len(extra))
    result = np.zeros((vertex_count + len(extra), 2), np.float32)
    result[place] = coordinates[at][first]
    moved = index.astype(np.int64)
    moved[at] = place[pair]
    report.split += len(extra)
    return CornerVertices(result, moved, vertex[extra])


def _mended(index, coordinates, known, wrong, vertex_count, faces):
    """(len(wrong), 2) coordinates of wrong corners; those of one vertex are one."""
    place = vertex_count + np.arange(len(index))
    place[wrong] = index[wrong]
    table = np.zeros((vertex_count + len(index), 2), np.float32)
    table[place] = coordinates
    bad = np.ones(len(table), bool)
    bad[place[known]] = False
    bad[place[wrong]] = True
    return mended_coordinates(table, bad, place[faces])[place[wrong]]


def with_corner_coordinates(
    mesh: Mesh,
    triangles: Triangles,
    coordinates: np.ndarray,
    known: np.ndarray,
    split: bool,
    report: ImportReport,
) -> Mesh:
    """The mesh, whose faces are these triangles, with texture coordinates; seams may be split.

    coordinates: (N, 2) float32 of the corners of all polygons; known: (N,) bool.
    """
    found = texture_vertices(
        mesh.faces.reshape(-1),
        triangles.of_corners(coordinates),
        None if known.all() else triangles.of_corners(known),
        len(mesh.vertices),
        np.arange(mesh.faces.size).reshape(-1, 3),
        split,
        report,
    )
    return found.given_to(mesh, found.index.reshape(-1, 3))


def _pairs(index: np.ndarray, coordinates: np.ndarray) -> Tuple[np.ndarray, ...]:
    """The different pairs of vertex and coordinates, by vertex and then by first appearance.

    Returns (vertex (P,), pair of each corner (N,), first corner of each pair (P,)).
    """
    first, group = equal_rows((index, coordinates[:, 0], coordinates[:, 1]))
    by_appearance = np.lexsort((first, index[first]))
    rank = np.zeros(len(first), np.int64)
    rank[by_appearance] = np.arange(len(first))
    first = first[by_appearance]
    return index[first].astype(np.int64), rank[group], first
