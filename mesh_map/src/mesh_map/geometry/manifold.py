"""Meshes made manifold: no edge of more than two faces, no vertex with several fans."""

from typing import Any, Dict, NamedTuple, Optional

import numpy as np
from mesh_msgs.derived_mesh import DerivedMesh, derived_uuid

from mesh_map import _kernels
from mesh_map.base.digest import digest
from mesh_map.base.errors import MeshMapError
from mesh_map.geometry.normals import checked_up
from mesh_map.geometry.components import face_areas
from mesh_map.geometry.orientation import Orientation, orient_faces, orient_towards
from mesh_map.geometry.submesh import checked_mesh
from mesh_map.geometry.topology import Topology, quantity

_VERSION = 1  # another number gives all results other UUIDs


class Manifold(NamedTuple):
    """What make_manifold() has made, and of how many faults.

    derived: the mesh, or None where there is nothing to be done.
    degenerate_faces, duplicate_faces: left out.
    split_vertices: copies that vertices have got.
    split_edges: edges that have got a vertex in their middle.
    turned_faces: now turned otherwise.
    """

    derived: Optional[DerivedMesh]
    degenerate_faces: int
    duplicate_faces: int
    split_vertices: int
    split_edges: int
    turned_faces: int

    def report(self) -> str:
        """One line for people."""
        parts = (
            (self.degenerate_faces, "degenerate faces", "left out"),
            (self.duplicate_faces, "duplicate faces", "left out"),
            (self.split_vertices, "vertices", "copied"),
            (self.split_edges, "edges", "split"),
            (self.turned_faces, "faces", "turned"),
        )
        found = ["%s %s" % (quantity(count, what), done) for count, what, done in parts if count]
        return ", ".join(found) or "nothing to be done"


def make_manifold(
    vertices: Any,
    faces: Any,
    *,
    orient: bool = True,
    sensors: Optional[Any] = None,
    up: Optional[Any] = None,
    parent_uuid: str = "",
) -> Manifold:
    """A mesh without non-manifold edges and vertices, at the same places.

    Faces that name a vertex twice, or have the three vertices of a face before them, are left out.
    At an edge of more than two faces, those two stay connected that are turned alike and bend the
    least, then the next two; a face that is left gets a border there. Vertices get a copy for each
    further fan of faces. Where that does not part them (the way around both ends of the edge leads
    from one pair to the other), each further pair gets a vertex of its own in the middle of the
    edge.

    Args:
        vertices: (V, 3) meters.
        faces: (F, 3) vertex indices.
        orient: turn faces so that neighbors agree. Faces that are turned against each other part at
            edges of more than two faces: they are turned before, too.
        sensors: (S, 3) meters, where sensors were: each piece shows its front to them then.
        up: (3,) of any length: without sensors, pieces face there. With neither, each piece stays
            as most of it is.
        parent_uuid: identity of the mesh; that of the result follows from it.
    Raises:
        MeshMapError: no mesh: what is wrong; only faces that name a vertex twice.
        ValueError: sensors of a wrong shape, or not finite.
    """
    vertices, faces = checked_mesh(vertices, faces)

    def turned(points: np.ndarray, triangles: np.ndarray) -> np.ndarray:
        if not orient:
            return np.zeros(len(triangles), bool)
        topology = Topology(faces=triangles, vertex_count=len(points))
        if sensors is not None:
            return orient_towards(points, triangles, topology, sensors).turned
        if up is not None:
            return orient_faces(points, triangles, topology, checked_up(up)).turned
        found = orient_faces(points, triangles, topology, checked_up((0.0, 0.0, 1.0)))
        return _fewest(found, face_areas(points, triangles))

    before = turned(vertices, faces)
    made = _kernels._manifold(vertices, _applied(before, faces))
    if not len(made["faces"]):
        raise MeshMapError(
            "all %d faces name a vertex twice: nothing of the mesh is left" % len(faces)
        )
    parents = made["vertex_parents"]
    is_new = np.arange(len(parents)) >= len(vertices)
    points = vertices[parents[:, 0]]
    ends = parents[is_new]
    points[is_new] = (
        0.5 * (vertices[ends[:, 0]].astype(np.float64) + vertices[ends[:, 1]])
    ).astype(np.float32)
    after = turned(points, made["faces"])
    triangles = _applied(after, made["faces"])
    counts = [made[name] for name in Manifold._fields[1:5]]
    turned_count = int(np.count_nonzero(before[made["face_parents"]] ^ after))
    if not any(counts) and not turned_count:
        return Manifold(None, 0, 0, 0, 0, 0)
    parameters: Dict[str, Any] = {"orient": orient, "version": _VERSION}
    if up is not None:
        parameters["up"] = checked_up(up).tolist()
    if sensors is not None:
        parameters["sensors"] = digest(np.asarray(sensors, np.float64))
    halves = np.where(parents[:, 0] == parents[:, 1], 1.0, 0.5)
    derived = DerivedMesh(
        derived_uuid(parent_uuid, "manifold", parameters),
        parent_uuid,
        points,
        triangles,
        face_parents=made["face_parents"],
        vertex_parents=parents,
        vertex_weights=np.stack([halves, 1.0 - halves], axis=1),
        parent_vertex_count=len(vertices),
        parent_face_count=len(faces),
    )
    return Manifold(derived, *counts, turned_count)


def _fewest(found: Orientation, areas: np.ndarray) -> np.ndarray:
    """(F,) bool: faces to be turned so that in each patch the smaller part of its area is."""
    counts = found.patches < found.patch_count
    patches = found.patches[counts]
    of_patch = np.bincount(patches, areas[counts], found.patch_count)
    turned_area = np.bincount(patches, areas[counts] * found.turned[counts], found.patch_count)
    turned = found.turned.copy()
    turned[counts] ^= (turned_area > 0.5 * of_patch)[patches]
    return turned


def _applied(turned: np.ndarray, faces: np.ndarray) -> np.ndarray:
    return np.where(turned[:, None], faces[:, [0, 2, 1]], faces)
