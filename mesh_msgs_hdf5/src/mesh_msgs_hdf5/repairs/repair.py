"""Repairs that lose nothing anyone needs; every change is counted in the report."""
import numpy as np

from mesh_msgs_hdf5.errors import MapFileError, PathLike
from mesh_msgs_hdf5.mesh import Mesh
from mesh_msgs_hdf5.repairs.orientation import faces_to_flip
from mesh_msgs_hdf5.repairs.remap import take_faces, take_vertices
from mesh_msgs_hdf5.report import ImportReport


def repair(path: PathLike, mesh: Mesh, report: ImportReport) -> Mesh:
    """A Mesh without what makes trouble; order is kept, layers, colors and labels follow.

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
    used = np.zeros(len(mesh.vertices), bool)
    used[mesh.faces] = True
    if not used.all():
        mesh = _without_vertices(mesh, used, report)
    flip, one_sided = faces_to_flip(mesh.faces)
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
    named = np.sort(mesh.faces, axis=1)
    order = np.lexsort(named.T[::-1])  # stable: the first of each group is the first in the mesh
    ordered = named[order]
    new = np.ones(len(named), bool)
    new[1:] = (ordered[1:] != ordered[:-1]).any(axis=1)
    if new.all():
        return mesh
    twins = np.zeros(len(named), np.int64)
    twins[order] = order[new][np.cumsum(new) - 1]
    keep = twins == np.arange(len(twins))
    gone = np.flatnonzero(~keep)
    report.dropped_faces += len(gone)
    report.note("repair: %d duplicate faces were dropped, first face %d", len(gone), gone[0])
    return take_faces(mesh, np.flatnonzero(keep), twins)


def _without_vertices(mesh, used, report):
    gone = np.flatnonzero(~used)
    report.dropped_vertices += len(gone)
    report.note(
        "repair: %d vertices without faces were dropped, first vertex %d", len(gone), gone[0]
    )
    number = np.cumsum(used) - 1
    faces = number[mesh.faces].astype(np.uint32)
    mesh = take_vertices(mesh, np.flatnonzero(used))
    mesh.faces = faces
    return mesh
