"""The identity of a geometry: a UUID that follows from its content.

The same vertices and faces have the same UUID in every process, in a file and on the wire, so
attributes (colors, costs, labels) can be checked against the geometry they were made for.
"""

import hashlib
import struct
import uuid

import numpy as np

from mesh_msgs.checks.mesh_arrays import as_faces, as_vertices

# Part of the file format: another namespace would give every known geometry another UUID.
GEOMETRY_NAMESPACE = uuid.UUID("5a3f0c0e-7b5d-4c7e-9d7a-2f6c1f0b8e61")


def geometry_uuid(vertices: np.ndarray, faces: np.ndarray) -> str:
    """Return the version 5 UUID of a geometry.

    The name below :data:`GEOMETRY_NAMESPACE` is the lower-case hexadecimal BLAKE2b-128 digest of:
    the number of vertices and the number of faces (two little-endian uint64), the vertices as
    little-endian float32, the faces as little-endian uint32, both in C order. Version 5 UUIDs: RFC
    4122, section 4.3.

    :param vertices: (V, 3), any real dtype; rounded to float32 (-0.0 and 0.0 differ, as their bytes
      do).
    :param faces: (F, 3) vertex indices, any dtype that holds whole numbers.
    :raises ValueError: where a shape is wrong, or a value does not fit float32 or uint32.
    """
    given, vertices = np.asarray(vertices), as_vertices(vertices)
    if given.dtype.kind == "f" and given.dtype.itemsize > 4:
        overflown = (np.isinf(vertices) & ~np.isinf(given.reshape(-1, 3))).any(axis=1)
        if overflown.any():
            raise ValueError(
                f"vertex {overflown.argmax()} has a coordinate that float32 cannot hold "
                f"({np.count_nonzero(overflown)} such vertices in all); scale the mesh to meters"
            )
    faces = as_faces(faces, "iuf")
    digest = hashlib.blake2b(struct.pack("<QQ", len(vertices), len(faces)), digest_size=16)
    digest.update(vertices.astype("<f4", copy=False).reshape(-1).view(np.uint8))
    digest.update(faces.astype("<u4", copy=False).reshape(-1).view(np.uint8))
    return str(uuid.uuid5(GEOMETRY_NAMESPACE, digest.hexdigest()))
