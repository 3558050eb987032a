"""Closed surfaces of a mesh: what is solid, as a wall or a box of its own is in CAD and BIM."""

from typing import NamedTuple

import numpy as np

from mesh_map import _kernels
from mesh_map.base.array_checks import read_only
from mesh_map.geometry.mesh_geometry import MeshGeometry
from mesh_map.geometry.topology import Topology

NO_SOLID = int(_kernels._NO_INDEX)


class Solids(NamedTuple):
    """The solids of a mesh, and the mesh in which borders that lie on each other are joined.

    Many formats have vertices of their own for each side of a box, or for each face. So vertices at
    borders that are at the same place count as one here.

    Attributes:
        numbers: (F,) uint32, of each face that of its solid; NO_SOLID for faces of none. A solid is
            a patch of faces that are joined at edges of two faces, all edges of which have two.
        joined: (V,) uint32, for each vertex the one that stands for it: of those at borders at the
            same place the lowest, else itself.
        faces: (F, 3) uint32, of these vertices.
        vertex_face_offsets, vertex_faces: as of Topology, of these faces.
    """

    numbers: np.ndarray
    joined: np.ndarray
    faces: np.ndarray
    vertex_face_offsets: np.ndarray
    vertex_faces: np.ndarray


def find_solids(geometry: MeshGeometry) -> Solids:
    """The solids of a mesh, found once for a geometry."""
    return geometry.made(_find)


def _find(geometry: MeshGeometry) -> Solids:
    topology, faces = geometry.topology, geometry.faces
    numbers = _numbers(topology)
    joined = _joined_borders(geometry)
    if not np.array_equal(joined, np.arange(len(joined))):
        faces = joined[faces]
        topology = Topology(faces=faces, vertex_count=len(joined))
        found = numbers != NO_SOLID
        more = _numbers(topology)
        more[more != NO_SOLID] += np.uint32(numbers[found].max(initial=0) + found.any())
        more = np.where(found, numbers, more)
        found = more != NO_SOLID
        more[found] = np.unique(more[found], return_inverse=True)[1]
        numbers = more
    rows = topology.vertex_face_offsets, topology.vertex_faces
    return Solids(read_only(numbers), read_only(joined), read_only(faces), *rows)


def _numbers(topology: Topology) -> np.ndarray:
    return _kernels._solids(topology.face_edges, topology.face_flags, topology.edge_count)


def _joined_borders(geometry: MeshGeometry) -> np.ndarray:
    topology = geometry.topology
    joined = np.arange(len(geometry.vertices), dtype=np.uint32)
    at_border = np.unique(topology.edges[topology.border_edges])
    places = np.ascontiguousarray(geometry.vertices[at_border] + np.float32(0))  # no -0
    _, first, inverse = np.unique(
        places.view(np.dtype((np.void, 12))).ravel(), return_index=True, return_inverse=True
    )
    joined[at_border] = at_border[first[inverse]]
    return joined
