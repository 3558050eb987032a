"""Meshes with copies of vertices along the seams of textures: refined, and put together again."""

from typing import Any, Tuple

import numpy as np
from mesh_msgs.checks.mesh_arrays import as_faces, as_vertices
from mesh_msgs.derived_mesh import DerivedMesh
from mesh_msgs.split_mesh import SplitMesh

from mesh_map.geometry.orientation import Orientation


def refined_split(split: SplitMesh, refined: DerivedMesh) -> Tuple[SplitMesh, DerivedMesh]:
    """A refinement with copies of its vertices along the same seams.

    Args:
        split: a mesh with copies.
        refined: of the parent of that one, see refine().
    Returns:
        (the refinement with copies, as one made of the refinement without; the same, as one made of
        the split mesh, of which texture coordinates are carried to it).
    """
    originals, of_split = derived_with_copies(split, refined)
    whole = SplitMesh(refined.uuid, refined.uuid, of_split.vertices, of_split.faces, originals)
    return whole, of_split


def derived_with_copies(split: SplitMesh, refined: DerivedMesh) -> Tuple[np.ndarray, DerivedMesh]:
    """A mesh that was derived of the parent of a mesh with copies, with copies along those seams.

    Returns:
        ((C,) of which of its vertices the last C are copies: none where no seam is left; it, as one
        made of the split mesh).
    """
    whole, parts = split.parent_faces, split.faces
    near = (whole != parts).any(axis=1)[refined.face_parents]  # only these may need copies
    corners = refined.faces[near]
    parents = refined.face_parents[near]
    sources = refined.vertex_parents[corners]  # (N, 3, K): of the parent, ...
    matches = sources[..., None] == whole[parents][:, None, None, :]
    place = matches.argmax(axis=-1)
    found = parts[parents[:, None, None], place]  # ... and the same in the split mesh
    found = np.where(matches.any(axis=-1), found, sources).reshape(-1, sources.shape[2])
    is_copy = (found != sources.reshape(found.shape)).any(axis=1)
    keys = np.concatenate([corners.reshape(-1, 1), found], axis=1)[is_copy]
    rows, number = np.unique(keys, axis=0, return_inverse=True)
    originals, count = rows[:, 0], len(refined.vertices)
    faces = refined.faces.copy()
    moved = corners.reshape(-1).copy()
    moved[is_copy] = (count + number.reshape(-1)).astype(np.uint32)
    faces[near] = moved.reshape(-1, 3)
    vertices = np.concatenate([refined.vertices, refined.vertices[originals]])
    of_split = DerivedMesh(
        refined.uuid,
        split.uuid,
        vertices,
        faces,
        face_parents=refined.face_parents,
        vertex_parents=np.concatenate([refined.vertex_parents, rows[:, 1:]]),
        vertex_weights=np.concatenate([refined.vertex_weights, refined.vertex_weights[originals]]),
        parent_vertex_count=len(split.vertices),
        parent_face_count=len(parts),
    )
    return originals, of_split


def turned(split: SplitMesh, orientation: Orientation) -> SplitMesh:
    """The mesh with its faces turned as those of its parent were."""
    faces = orientation.applied_to(split.faces)
    return SplitMesh(split.uuid, split.parent_uuid, split.vertices, faces, split.originals)


def stitched_faces(vertices: Any, faces: Any) -> np.ndarray:
    """(F, 3) uint32: the faces with one vertex for those at the same place, wherever exactly two
    edges with one face each lie on each other.

    For those who have a mesh with copies along seams, but do not know which vertices are copies.
    Vertices keep their numbers; some belong to no face then.

    Args:
        vertices: (V, 3) meters.
        faces: (F, 3) vertex indices.
    """
    # half a second to import, and few need it
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components

    vertices, faces = as_vertices(vertices), as_faces(faces)
    ends = np.stack([faces, np.roll(faces, -1, axis=1)], axis=2).reshape(-1, 2).astype(np.int64)
    count = len(vertices)
    keys = ends.min(axis=1) * count + ends.max(axis=1)
    _, first, number = np.unique(keys, return_index=True, return_counts=True)
    borders = ends[first[number == 1]]
    at, place = np.unique(borders, return_inverse=True)
    _, same = np.unique(vertices[at] + np.float32(0), axis=0, return_inverse=True)
    places = same.reshape(-1)[place.reshape(borders.shape)]  # numbers of the places of both ends
    turn = places[:, 0] > places[:, 1]
    borders[turn], places[turn] = borders[turn][:, ::-1], places[turn][:, ::-1]
    keys = places[:, 0] * (len(at) + 1) + places[:, 1]
    order = np.argsort(keys, kind="stable")
    _, start, number = np.unique(keys[order], return_index=True, return_counts=True)
    pairs = start[(number == 2)]
    one, other = borders[order[pairs]], borders[order[pairs + 1]]
    long = places[order[pairs], 0] != places[order[pairs], 1]
    one, other = one[long].reshape(-1), other[long].reshape(-1)
    graph = coo_matrix((np.ones(len(one), np.int8), (one, other)), (count, count))
    group = connected_components(graph, directed=False)[1]
    lowest = np.full(count, count, np.int64)
    np.minimum.at(lowest, group, np.arange(count))
    return lowest[group].astype(np.uint32)[faces]
