"""Holes and shadows of a surface closed; rims that are in the way of that taken away."""

import math
from dataclasses import replace
from typing import List, NamedTuple, Optional, Sequence

import numpy as np
from mesh_msgs.derived_mesh import DerivedMesh
from mesh_msgs_hdf5.model.carried_mesh import carried_mesh
from mesh_msgs_hdf5.model.mesh import Mesh
from scipy.spatial import cKDTree

from mesh_map.base.cancel import CancelFlag
from mesh_map.base.errors import Canceled
from mesh_map.geometry.components import drop_components
from mesh_map.geometry.hole_filling import fill_holes
from mesh_map.geometry.topology import Topology
from mesh_map.reconstruction.options import SurfaceOptions
from mesh_map.reconstruction.rim_trimming import without_faces_at
from mesh_map.reconstruction.shadows import fill_shadows

OBSERVATIONS = "observations"  # attribute of vertices: rays that ended near
_ROWS = 2  # of faces beside a folded loop that may be taken away
_TRIES = 3  # to take them away at as many loops as that helps


class ClosedSurface(NamedTuple):
    """A mesh whose holes and shadows are closed, and counts as in SurfaceChanges.

    folded: loops of its shadows that could not be, see Shadows.
    """

    mesh: Mesh
    holes: int = 0
    hole_faces: int = 0
    shadows: int = 0
    shadow_faces: int = 0
    folded: Sequence[np.ndarray] = ()


def closed_surface(
    mesh: Mesh, options: SurfaceOptions, cancel: Optional[CancelFlag]
) -> ClosedSurface:
    """Tries what is folded once more without the faces beside it, which stay where that does not
    help. Those beside loops that are short and cannot be closed even so are no surface."""
    first = _holes_closed(mesh, options, cancel)
    is_short = [_perimeter(first.mesh, loop) < options.fill_holes for loop in first.folded]
    short = [loop for loop, known in zip(first.folded, is_short) if known]
    folded = [loop for loop, known in zip(first.folded, is_short) if not known]
    others: List[np.ndarray] = []
    for _ in range(_TRIES if folded or short else 0):
        again = _opened(first, folded + short, others, options, cancel)
        is_open = _stay_open(first.mesh, folded + short, again.mesh)[: len(folded)]
        if not is_open.any():
            return again
        others += [loop for loop, still in zip(folded, is_open) if still]
        folded = [loop for loop, still in zip(folded, is_open) if not still]
        if not folded and not short:
            break
    return first


def _opened(
    closed: ClosedSurface,
    folded: List[np.ndarray],
    others: List[np.ndarray],
    options: SurfaceOptions,
    cancel: Optional[CancelFlag],
) -> ClosedSurface:
    """Without the faces at some loops, then at those that are folded still; never at others."""
    kept = _places(closed.mesh.vertices[np.concatenate([*others, np.zeros(0, np.uint32)])])
    for _ in range(_ROWS):
        opened = without_faces_at(closed.mesh.vertices, closed.mesh.faces, folded)
        if opened is None:
            break
        mesh = without_small_pieces(carried_mesh(closed.mesh, opened), options)
        closed = _shadows_closed(closed._replace(mesh=mesh), options, cancel)
        places = [_places(closed.mesh.vertices[loop]) for loop in closed.folded]
        folded = [loop for loop, at in zip(closed.folded, places) if not np.isin(at, kept).any()]
        if not folded:
            break
    return closed


def _holes_closed(
    mesh: Mesh, options: SurfaceOptions, cancel: Optional[CancelFlag]
) -> ClosedSurface:
    filled = fill_holes(mesh.vertices, mesh.faces, max_perimeter=options.fill_holes)
    mesh = mesh if filled.derived is None else _with_patches(mesh, filled.derived)
    raise_if_canceled(cancel)
    faces = int(np.count_nonzero(filled.new_faces))
    return _shadows_closed(ClosedSurface(mesh, filled.counts()["filled"], faces), options, cancel)


def _shadows_closed(
    closed: ClosedSurface, options: SurfaceOptions, cancel: Optional[CancelFlag]
) -> ClosedSurface:
    """Adds to what was closed before."""
    mesh = closed.mesh
    lit = fill_shadows(
        mesh.vertices,
        mesh.faces,
        max_width=options.fill_shadows,
        narrow=options.fill_holes / math.pi,
    )
    raise_if_canceled(cancel)
    return closed._replace(
        mesh=mesh if lit.derived is None else _with_patches(mesh, lit.derived),
        shadows=closed.shadows + lit.holes,
        shadow_faces=closed.shadow_faces + lit.faces,
        folded=lit.folded,
    )


def _with_patches(mesh: Mesh, derived: DerivedMesh) -> Mesh:
    """With what vertices have, interpolated; but no ray has ended at new ones."""
    carried = carried_mesh(mesh, derived)
    attributes = dict(carried.vertex_attributes)
    if OBSERVATIONS in attributes:
        is_new = np.arange(len(derived.vertices)) >= len(mesh.vertices)
        attributes[OBSERVATIONS] = np.where(is_new, np.float32(0.0), attributes[OBSERVATIONS])
    return replace(carried, vertex_attributes=attributes)


def _stay_open(mesh: Mesh, loops: List[np.ndarray], other: Mesh) -> np.ndarray:
    """(L,) bool: which loops of the border of `mesh` are the nearest one to a vertex that is at the
    border of `other` alone.

    other: of the same vertices, and others, but with other faces near the loops.
    """
    before, after = (each.vertices[_at_border(each)] for each in (mesh, other))
    added = after[~np.isin(_places(after), _places(before))].astype(np.float64)
    points = mesh.vertices[np.concatenate(loops)].astype(np.float64)
    of = np.repeat(np.arange(len(loops)), [len(loop) for loop in loops])
    longest = max(float(_sides(mesh, loop).max()) for loop in loops)
    gaps, nearest = cKDTree(points).query(added, distance_upper_bound=(_ROWS + 1) * longest)
    found: np.ndarray = np.isin(np.arange(len(loops)), of[nearest[np.isfinite(gaps)]])
    return found


def _sides(mesh: Mesh, loop: np.ndarray) -> np.ndarray:
    """(N,) m."""
    points = mesh.vertices[loop].astype(np.float64)
    lengths: np.ndarray = np.linalg.norm(np.roll(points, -1, axis=0) - points, axis=1)
    return lengths


def _perimeter(mesh: Mesh, loop: np.ndarray) -> float:
    return float(_sides(mesh, loop).sum())


def _at_border(mesh: Mesh) -> np.ndarray:
    topology = Topology(faces=mesh.faces, vertex_count=len(mesh.vertices))
    found: np.ndarray = np.unique(topology.edges[topology.border_edges])
    return found


def _places(vertices: np.ndarray) -> np.ndarray:
    """(V,) of which two are equal where the vertices (V, 3) float32 have the same bits."""
    return np.ascontiguousarray(vertices).view(np.dtype((np.void, 12))).ravel()


def without_small_pieces(mesh: Mesh, options: SurfaceOptions) -> Mesh:
    large = drop_components(
        mesh.vertices, mesh.faces, min_faces=options.min_component, across_vertices=False
    )
    return mesh if large is None else carried_mesh(mesh, large)


def raise_if_canceled(cancel: Optional[CancelFlag]) -> None:
    if cancel is not None and cancel.is_set():
        raise Canceled("the surface was not made")
