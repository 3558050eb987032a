"""Vertices that are close together become one."""
import numpy as np

from mesh_msgs_hdf5.formats.base.equal_rows import by_appearance, equal_rows
from mesh_msgs_hdf5.formats.base.remap import take_faces, take_vertices
from mesh_msgs_hdf5.formats.base.report import ImportReport
from mesh_msgs_hdf5.model.errors import MapFileError, PathLike
from mesh_msgs_hdf5.model.mesh import Mesh

# more pairs of neighbors than this are a distance in the size of the faces, or a mistake
MAX_PAIRS = 50_000_000
_SMALLER = "choose a distance far below the length of the edges"


def merge_vertices(path: PathLike, mesh: Mesh, tolerance: float, report: ImportReport) -> Mesh:
    """A Mesh in which vertices at most tolerance meters apart are one (0: at the same position).

    Chains merge too: a and c through b. The first vertex of each group stays, with its position and
    values. Those with other texture coordinates become copies of it along a seam (see Mesh), at its
    position. Faces that have no area left are dropped. Vertices that are not finite stay.
    """
    first, group = _groups(path, mesh, tolerance)
    rows, number, originals = _copies(mesh, first, group)
    count = len(mesh.vertices) - len(rows)
    if not count and np.array_equal(originals, _none_if(mesh.seam_originals)):
        report.note("merging within %g m: there was nothing to merge", tolerance)
        return mesh
    report.merged += count
    report.note("merging within %g m: %d vertices fell into others", tolerance, count)
    result = take_vertices(mesh, rows)
    result.faces = number[mesh.faces].astype(np.uint32)
    if len(originals):
        own = len(rows) - len(originals)
        result.vertices[own:] = result.vertices[originals]
        result.seam_originals = originals.astype(np.uint32)
        text = "merging: %d more are copies of them along seams of textures"
        report.note(text, len(originals))
    gone = _distinct(mesh.parent_faces) & ~_distinct(result.parent_faces)
    if gone.any() and gone.all():
        raise MapFileError(
            "value",
            path,
            "merging within %g m leaves no face of %d" % (tolerance, len(mesh.faces)),
            _SMALLER,
        )
    if gone.any():
        report.dropped_faces += int(np.count_nonzero(gone))
        report.note(
            "merging: %d faces without area were dropped, first face %d",
            np.count_nonzero(gone),
            np.flatnonzero(gone)[0],
        )
        result = take_faces(result, np.flatnonzero(~gone))
    return result


def _none_if(originals):
    return np.zeros(0) if originals is None else originals


def _distinct(faces):
    """(F,) which faces name three vertices."""
    return (faces != np.roll(faces, 1, axis=1)).all(axis=1)


def _groups(path, mesh, tolerance):
    """(first vertex of each group, group of each vertex (V,)) of those that become one, in the
    order of the first ones."""
    first, group = equal_rows((mesh.vertices + np.float32(0)).T)
    if tolerance:
        positions = mesh.vertices[first].astype(np.float64)
        finite = np.flatnonzero(np.isfinite(positions).all(axis=1))
        near = _near_groups(path, positions[finite], tolerance)
        joined = np.arange(len(first))
        # the lowest number in each group stands for it
        lowest = np.full(len(finite), len(first), np.int64)
        np.minimum.at(lowest, near, finite)
        joined[finite] = lowest[near]
        group = joined[group]
    if mesh.seam_originals is not None:  # also of vertices that are not finite
        group[len(mesh.parent_vertices) :] = group[mesh.seam_originals]
    return by_appearance(*np.unique(group, return_index=True, return_inverse=True)[1:])


def _copies(mesh, first, group):
    """(rows of the mesh that stay, number of each vertex among them (V,), of which of them the last
    ones are copies): one for each group, and one for each further pair of texture coordinates."""
    coordinates = mesh.texture_coordinates
    if coordinates is None:
        return first, group, np.zeros(0, np.int64)
    columns = (group, *(coordinates + np.float32(0)).T)
    rows, pair = by_appearance(*equal_rows(columns))
    is_copy = rows != first[group[rows]]
    order = np.argsort(is_copy, kind="stable")
    number = np.zeros(len(order), np.int64)
    number[order] = np.arange(len(order))
    return rows[order], number[pair], group[rows[is_copy]]


def _near_groups(path, positions, tolerance):
    """(N,) groups of positions that chains of neighbors connect."""
    # these take half a second to import, and few imports merge
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components
    from scipy.spatial import cKDTree

    tree = cKDTree(positions, balanced_tree=False, compact_nodes=False)
    pairs = (tree.count_neighbors(tree, tolerance) - len(positions)) // 2
    if pairs > MAX_PAIRS:
        raise MapFileError(
            "value",
            path,
            "merging within %g m joins %d pairs of vertices, more than %d"
            % (tolerance, pairs, MAX_PAIRS),
            _SMALLER,
        )
    near = tree.query_pairs(tolerance, output_type="ndarray")
    shape = (len(positions), len(positions))
    graph = coo_matrix((np.ones(len(near), np.int8), (near[:, 0], near[:, 1])), shape)
    return connected_components(graph, directed=False)[1]
