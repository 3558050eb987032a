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
    values; vertices of different texture coordinates never merge. Faces that have no area left are
    dropped. Vertices that are not finite stay.
    """
    # groups are numbered by their first vertex, so that the order of vertices stays
    groups = np.unique(_groups(path, mesh, tolerance), return_index=True, return_inverse=True)
    first, number = by_appearance(*groups[1:])
    count = len(mesh.vertices) - len(first)
    if not count:
        report.note("merging within %g m: there was nothing to merge", tolerance)
        return mesh
    report.merged += count
    report.note("merging within %g m: %d vertices fell into others", tolerance, count)
    sound = _distinct(mesh.faces)
    faces = number[mesh.faces].astype(np.uint32)
    result = take_vertices(mesh, first)
    result.faces = faces
    gone = sound & ~_distinct(faces)
    if gone.any() and gone.all():
        raise MapFileError(
            "value",
            path,
            "merging within %g m leaves no face of %d" % (tolerance, len(faces)),
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


def _distinct(faces):
    """(F,) which faces name three vertices."""
    return (faces != np.roll(faces, 1, axis=1)).all(axis=1)


def _groups(path, mesh, tolerance):
    """(V,) a number for each vertex: the same for those that become one."""
    keys = [mesh.vertices + np.float32(0)]
    if mesh.texture_coordinates is not None:
        keys.append(mesh.texture_coordinates + np.float32(0))
    first, group = equal_rows(np.concatenate(keys, axis=1).T)
    if not tolerance:
        return group
    positions = mesh.vertices[first].astype(np.float64)
    finite = np.flatnonzero(np.isfinite(positions).all(axis=1))
    near = _near_groups(path, positions[finite], tolerance, keys[1:], first[finite])
    joined = np.arange(len(first))
    # the lowest number in each group stands for it
    lowest = np.full(len(finite), len(first), np.int64)
    np.minimum.at(lowest, near, finite)
    joined[finite] = lowest[near]
    return joined[group]


def _near_groups(path, positions, tolerance, more_keys, rows):
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
    for key in more_keys:
        same = (key[rows[near[:, 0]]] == key[rows[near[:, 1]]]).all(axis=1)
        near = near[same]
    shape = (len(positions), len(positions))
    graph = coo_matrix((np.ones(len(near), np.int8), (near[:, 0], near[:, 1])), shape)
    return connected_components(graph, directed=False)[1]
