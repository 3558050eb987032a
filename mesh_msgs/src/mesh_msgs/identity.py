"""The identity of a geometry: a UUID that follows from its content.

The same vertices and faces have the same UUID in every process, in a file and on the wire, so
attributes (colors, costs, labels) can be checked against the geometry they were made for.
"""

import hashlib
import struct
import uuid

import numpy as np

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
    vertices = _rows_of_three("vertices", vertices)
    faces = _rows_of_three("faces", faces)
    vertices = _as_float32(vertices)
    faces = _as_uint32(faces)
    digest = hashlib.blake2b(struct.pack("<QQ", len(vertices), len(faces)), digest_size=16)
    digest.update(vertices.reshape(-1).view(np.uint8))
    digest.update(faces.reshape(-1).view(np.uint8))
    return str(uuid.uuid5(GEOMETRY_NAMESPACE, digest.hexdigest()))


def _rows_of_three(name: str, array: np.ndarray) -> np.ndarray:
    array = np.asarray(array)
    if array.size == 0 and array.shape in ((0,), (0, 3)):
        return array.reshape(0, 3)
    if array.ndim != 2 or array.shape[1] != 3:
        raise ValueError(f"{name} have the shape {array.shape}, but (N, 3) is needed")
    if array.dtype.kind not in "fiu":
        raise ValueError(f"{name} are of dtype {array.dtype}, but real numbers are needed")
    return array


def _as_float32(vertices: np.ndarray) -> np.ndarray:
    if vertices.dtype.kind == "f" and vertices.dtype.itemsize > 4:
        # Overflow is looked for below, with the index in the message.
        with np.errstate(over="ignore"):
            converted = np.ascontiguousarray(vertices, dtype="<f4")
        overflown = np.isinf(converted) & ~np.isinf(vertices)
        if overflown.any():
            rows = np.flatnonzero(overflown.any(axis=1))
            raise ValueError(
                f"vertex {rows[0]} has a coordinate that float32 cannot hold "
                f"({len(rows)} such vertices in all); scale the mesh to meters"
            )
        return converted
    return np.ascontiguousarray(vertices, dtype="<f4")


def _as_uint32(faces: np.ndarray) -> np.ndarray:
    if faces.dtype.kind == "u" and faces.dtype.itemsize <= 4:
        return np.ascontiguousarray(faces, dtype="<u4")
    valid = (faces >= 0) & (faces <= 0xFFFFFFFF)
    if faces.dtype.kind == "f":
        valid &= faces == np.floor(faces)
    if not valid.all():
        rows = np.flatnonzero(~valid.all(axis=1))
        raise ValueError(
            f"face {rows[0]} has an index that uint32 cannot hold "
            f"({len(rows)} such faces in all); vertex indices are whole numbers from 0"
        )
    return np.ascontiguousarray(faces, dtype="<u4")
