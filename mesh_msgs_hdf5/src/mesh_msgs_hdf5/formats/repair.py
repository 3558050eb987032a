"""Repairs that lose nothing anyone needs; every change is counted in the report."""
from typing import Tuple

import numpy as np

from mesh_msgs_hdf5.formats.base.edges import edges_of
from mesh_msgs_hdf5.formats.base.equal_rows import equal_rows
from mesh_msgs_hdf5.formats.base.remap import take_faces, take_vertices
from mesh_msgs_hdf5.formats.base.report import ImportReport
from mesh_msgs_hdf5.model.errors import MapFileError, PathLike
from mesh_msgs_hdf5.model.mesh import Mesh


def repair(path: PathLike, mesh: Mesh, report: ImportReport) -> Mesh:
    """A Mesh without what makes trouble; order is kept, layers, colors and labels follow.

    Copies of vertices along seams of textures are one vertex with their original here.

    Dropped: faces at vertices that are not finite, faces without area, faces that name the same
    three vertices as an earlier one (their labels go to that one), then vertices without faces.
    Turned: faces that run against their neighbors, so that fewer are turned than left.
    """
    mesh = _without_bad_values(mesh, report)
    finite = np.isfinite(mesh.vertices).all(axis=1)
    mesh = _drop(mesh, finite[mesh.faces].all(axis=1), "at vertices that are not finite", report)
    mesh = _drop(mesh, _has_area(mesh), "without area", report)
    mesh = _without_duplicates(mesh, report)
    if not len(mesh.faces):
        raise MapFileError("no_faces", path, "repairing leaves no face", "is it a mesh?")
    mesh = _without_vertices(mesh, report)
    flip, one_sided = faces_to_flip(mesh.parent_faces)
    if one_sided:
        report.note("repair: %d faces are of one-sided surfaces and were not turned", one_sided)
    if flip.any():
        mesh.faces = mesh.faces.copy()
        mesh.faces[flip, 1:] = mesh.faces[flip, :0:-1]
        report.flipped += int(np.count_nonzero(flip))
        report.note(
            "repair: %d faces were turned over, first face %d",
            np.count_nonzero(flip),
            np.flatnonzero(flip)[0],
        )
    return mesh


def _without_bad_values(mesh, report):
    """Normals and texture coordinates that are not finite are left out by the readers already."""
    for name, costs in list(mesh.vertex_costs.items()):
        wrong = costs == -np.inf
        if wrong.any():
            mesh.vertex_costs[name] = np.where(wrong, np.float32(np.nan), costs)
            report.note(
                "repair: %d values -inf of layer %s became unknown (NaN)",
                np.count_nonzero(wrong),
                name,
            )
    return mesh


def _drop(mesh, keep, what, report):
    """The mesh with the faces to keep (F,)."""
    if keep.all():
        return mesh
    gone = np.flatnonzero(~keep)
    report.dropped_faces += len(gone)
    report.note("repair: %d faces %s were dropped, first face %d", len(gone), what, gone[0])
    return take_faces(mesh, np.flatnonzero(keep))


def _has_area(mesh):
    """(F,) False where the corners are on a line, or two of them are the same."""
    corners = mesh.vertices[mesh.faces].astype(np.float64)
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    return (cross != 0).any(axis=1)


def _without_duplicates(mesh, report):
    first, group = equal_rows(np.sort(mesh.parent_faces, axis=1).T)
    if len(first) == len(group):
        return mesh
    twins = first[group]
    keep = twins == np.arange(len(twins))
    gone = np.flatnonzero(~keep)
    report.dropped_faces += len(gone)
    report.note("repair: %d duplicate faces were dropped, first face %d", len(gone), gone[0])
    return take_faces(mesh, np.flatnonzero(keep), twins)


def _without_vertices(mesh, report):
    """The mesh without vertices that no face has; a copy may take the place of its original."""
    used = np.zeros(len(mesh.vertices), bool)
    used[mesh.faces] = True
    if used.all():
        return mesh
    own = len(mesh.parent_vertices)
    of_parent = np.arange(own)
    if mesh.seam_originals is not None:
        of_parent = np.concatenate([of_parent, mesh.seam_originals.astype(np.int64)])
    # of each vertex of the parent that stays the first one that is used, and then the others
    kept = np.flatnonzero(used)
    parents, first = np.unique(of_parent[kept], return_index=True)
    is_copy = np.ones(len(kept), bool)
    is_copy[first] = False
    copies = kept[is_copy]
    _note_dropped(np.setdiff1d(np.arange(own), parents), len(used) - own - len(copies), report)
    rows = np.concatenate([kept[first], copies])
    number = np.zeros(len(used), np.int64)
    number[rows] = np.arange(len(rows))
    faces, coordinates = number[mesh.faces].astype(np.uint32), mesh.texture_coordinates
    mesh = take_vertices(mesh, np.concatenate([parents, copies]))
    mesh.faces = faces
    mesh.texture_coordinates = None if coordinates is None else coordinates[rows]
    if len(copies):
        mesh.seam_originals = np.searchsorted(parents, of_parent[copies]).astype(np.uint32)
    return mesh


def _note_dropped(gone, copies, report):
    report.dropped_vertices += len(gone)
    if len(gone):
        report.note(
            "repair: %d vertices without faces were dropped, first vertex %d", len(gone), gone[0]
        )
    if copies > 0:
        report.note("repair: there are %d copies less along seams of textures", copies)


def faces_to_flip(faces: np.ndarray) -> Tuple[np.ndarray, int]:
    """(which faces (F,) to turn over, number of faces of one-sided surfaces, which stay).

    faces: (F, 3), each of three different vertices. Two faces that share an edge which no third one
    has agree if they run through it in opposite directions. In each set of faces connected in this
    way the fewer are turned; if as many, those that leave the first face as it is.

    Each face is two nodes of a graph, as it is and turned over; an edge joins the nodes of two
    faces that agree. A surface is one-sided if both nodes of a face are connected.
    """
    # this takes a while to import, and few imports repair
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components

    count = len(faces)
    one, other, opposite = _neighbors(faces)
    turned = np.where(opposite, 0, count)
    rows = np.concatenate([one, one + count])
    columns = np.concatenate([other + turned, other + count - turned])
    graph = coo_matrix((np.ones(len(rows), np.int8), (rows, columns)), (2 * count, 2 * count))
    groups, group = connected_components(graph, directed=False)
    as_is, over = group[:count], group[count:]
    # a group has a mirror image, in which each face is turned over: take the one with more as is
    kept = np.bincount(as_is, minlength=groups)
    first = np.full(groups, count)
    np.minimum.at(first, as_is, np.arange(count))
    better = (kept[over] > kept[as_is]) | (
        (kept[over] == kept[as_is]) & (first[over] < first[as_is])
    )
    one_sided = as_is == over
    return better & ~one_sided, int(np.count_nonzero(one_sided))


def _neighbors(faces):
    """(face, face, whether they run through their edge in opposite directions) (N,) each."""
    edges = edges_of(faces, np.arange(len(faces)))
    pair = edges.start[edges.count == 2]
    opposite = edges.forward[pair] != edges.forward[pair + 1]
    return edges.side[pair] // 3, edges.side[pair + 1] // 3, opposite
