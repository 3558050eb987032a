"""Faces that all show the same side."""

from typing import Any, NamedTuple

import numpy as np
from mesh_msgs.checks.mesh_arrays import as_faces, as_vertices

from mesh_map import _kernels
from mesh_map.geometry.topology import Topology, quantity


class Orientation(NamedTuple):
    """Which faces list their corners the wrong way round.

    turned: (F,) bool, the faces to be turned.
    patch_count: sets of faces that edges of exactly two faces connect.
    conflicts: edges whose two faces disagree even then, as on a Moebius strip.
    """

    turned: np.ndarray
    patch_count: int
    conflicts: int

    def applied_to(self, faces: np.ndarray) -> np.ndarray:
        """The faces (F, 3), with the last two corners of those that are turned exchanged."""
        result = faces.copy()
        result[self.turned, 1], result[self.turned, 2] = (
            faces[self.turned, 2],
            faces[self.turned, 1],
        )
        return result

    def report(self) -> str:
        """One line for people."""
        text = "%s turned in %s" % (
            quantity(int(self.turned.sum()), "faces"),
            quantity(self.patch_count, "pieces"),
        )
        if self.conflicts:
            text += ", %s of one-sided pieces" % quantity(self.conflicts, "edges")
        return text


def orient_faces(vertices: Any, faces: Any, topology: Topology, up: np.ndarray) -> Orientation:
    """Makes the two faces of each edge agree, and most of each patch face up.

    In each patch, all faces are made to agree with that of lowest index as far as that is possible.
    Then the patch is turned as a whole if it shows more of its back than of its front when seen
    from above. Of one that shows as much of both, such as a closed surface, the outside becomes the
    front; one without volume, such as an upright wall, stays as its first face is. Degenerate faces
    stay as they are.

    Args:
        vertices: (V, 3) meters.
        faces: (F, 3) vertex indices.
        topology: of these faces.
        up: (3,) float64 of length 1.
    Raises:
        ValueError: arrays of wrong shapes, or of another mesh.
    """
    turned, patch_count, conflicts = _kernels._orientation(
        as_vertices(vertices),
        as_faces(faces),
        topology.face_edges,
        topology.edge_face_counts,
        topology.edge_flags,
        np.ascontiguousarray(up, np.float64),
    )
    return Orientation(turned.view(np.bool_), patch_count, conflicts)
