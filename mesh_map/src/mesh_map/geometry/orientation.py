"""Faces that all show the same side."""

from typing import Any, NamedTuple

import numpy as np
from mesh_msgs.checks.mesh_arrays import as_faces, as_vertices

from mesh_map import _kernels
from mesh_map.geometry.normals import checked_up
from mesh_map.geometry.topology import Topology, quantity
from mesh_map.spatial.spatial_index import SpatialIndex

# Both sides of a patch are shown alike where they differ by less than this part of it.
_AS_MUCH = 1e-6


class Orientation(NamedTuple):
    """Which faces list their corners the wrong way round.

    turned: (F,) bool, the faces to be turned.
    patch_count: sets of faces that edges of exactly two faces connect.
    conflicts: edges whose two faces disagree even then, as on a Moebius strip.
    patches: (F,) uint32, the patch of each face, numbered in the order of their lowest faces; the
        largest number that there is for degenerate faces.
    """

    turned: np.ndarray
    patch_count: int
    conflicts: int
    patches: np.ndarray

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


def orient_towards(
    vertices: Any, faces: Any, topology: Topology, sensors: Any, up: Any = (0.0, 0.0, 1.0)
) -> Orientation:
    """As orient_faces(), but each patch shows its front to the sensors that have seen it.

    A face counts for the sensor that is nearest to its middle, with the area that it shows to it.
    Where a patch shows as much of both sides, it is turned as orient_faces() does.

    Args:
        vertices: (V, 3) meters.
        faces: (F, 3) vertex indices.
        topology: of these faces.
        sensors: (S, 3) meters, positions of sensors; at least one.
        up: (3,) of any length.
    Raises:
        ValueError: arrays of wrong shapes or of another mesh, sensors that are not finite.
    """
    vertices, faces = as_vertices(vertices), as_faces(faces)
    positions = np.asarray(sensors, np.float64)
    if positions.ndim != 2 or positions.shape[1] != 3 or not len(positions):
        raise ValueError("sensors need the shape (S, 3), not %s" % (positions.shape,))
    if not np.isfinite(positions).all():
        raise ValueError(
            "position %d of the sensors is not finite" % np.isfinite(positions).all(1).argmin()
        )
    found = orient_faces(vertices, faces, topology, checked_up(up))
    if not len(faces):
        return found
    a, b, c = vertices[found.applied_to(faces)].astype(np.float64).transpose(1, 0, 2)
    middles = (a + b + c) / 3.0
    points = np.repeat(np.arange(len(positions))[:, None], 3, axis=1)  # as faces without area
    nearest = SpatialIndex(positions, points).closest_batch(points=middles).faces
    to_sensor = positions[nearest] - middles
    distances = np.linalg.norm(to_sensor, axis=1)
    shown = np.einsum("ij,ij->i", np.cross(b - a, c - a), to_sensor) / np.maximum(distances, 1e-12)
    counts = found.patches < found.patch_count
    patches, shown = found.patches[counts], shown[counts]
    front = np.bincount(patches, shown, found.patch_count)
    area = np.bincount(patches, np.abs(shown), found.patch_count)
    turned = found.turned.copy()
    turned[counts] ^= (front < -_AS_MUCH * area)[patches]
    return found._replace(turned=turned)


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
    turned, patch_count, conflicts, patches = _kernels._orientation(
        as_vertices(vertices),
        as_faces(faces),
        topology.face_edges,
        topology.edge_face_counts,
        topology.edge_flags,
        np.ascontiguousarray(up, np.float64),
    )
    return Orientation(turned.view(np.bool_), patch_count, conflicts, patches)
