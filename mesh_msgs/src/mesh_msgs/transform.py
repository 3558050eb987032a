"""Meshes moved into another frame by a given transform, without tf2 (with it: `tf2_support`).

The result keeps stamp and UUID, and so everything that refers to them; its frame is that of the
transform. Nothing of it is shared with the message that was given.
"""

import copy
from typing import Any, Callable, Dict, Tuple

import mesh_msgs.msg
import numpy as np
from geometry_msgs.msg import Point, TransformStamped

from mesh_msgs import arrays
from mesh_msgs.wire.array_field import array_of

_UNIT_TOLERANCE = 1e-3


class TransformError(ValueError):
    """A transform that is no rigid motion of the message's frame; one line says why."""


def rotation_and_translation(transform: TransformStamped) -> Tuple[np.ndarray, np.ndarray]:
    """(3, 3) rotation matrix and (3,) translation in meters, float64, of a TransformStamped.

    A quaternion of a length within 0.1 % of 1 is normalized.

    Raises:
        TransformError: a number that is not finite, a quaternion that is none of unit length.
    """
    q, t = transform.transform.rotation, transform.transform.translation
    quaternion = np.array([q.x, q.y, q.z, q.w], dtype=np.float64)
    translation = np.array([t.x, t.y, t.z], dtype=np.float64)
    length = np.sqrt(np.sum(quaternion**2))
    if not (np.isfinite(translation).all() and np.isfinite(length)):
        raise TransformError("the transform to %r is not finite" % transform.header.frame_id)
    if abs(length - 1) > _UNIT_TOLERANCE:
        raise TransformError(
            "the rotation to %r is a quaternion of length %g, not 1"
            % (transform.header.frame_id, length)
        )
    x, y, z, w = quaternion / length
    rotation = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )
    return rotation, translation


def transform_geometry(
    message: mesh_msgs.msg.MeshGeometryStamped, transform: TransformStamped
) -> arrays.MeshGeometryStamped:
    """Vertices rotated and moved, normals rotated only; faces as they are.

    message: of the generated or the array class. transform: from the message's frame (an empty
    child_frame_id means that) to the frame in its header.

    Raises:
        TransformError: see rotation_and_translation, or a transform of another frame.
        arrays.ArrayError: a message of the generated class with arrays that are none.
    """
    rotation, translation = _checked(message, transform)
    old = arrays.MeshGeometryStamped.from_message(message).mesh_geometry
    return arrays.MeshGeometryStamped(
        header=_header(message, transform),
        uuid=message.uuid,
        mesh_geometry=arrays.MeshGeometry(
            vertices=_moved(old.vertices, rotation, translation),
            vertex_normals=_moved(old.vertex_normals, rotation),
            faces=np.array(old.faces),
        ),
    )


def transform_vector_field(
    message: mesh_msgs.msg.VectorFieldStamped, transform: TransformStamped
) -> arrays.VectorFieldStamped:
    """Positions rotated and moved, vectors rotated only. Arguments and errors as above."""
    rotation, translation = _checked(message, transform)
    old = arrays.VectorFieldStamped.from_message(message).vector_field
    return arrays.VectorFieldStamped(
        header=_header(message, transform),
        vector_field=arrays.VectorField(
            positions=_moved(old.positions, rotation, translation),
            vectors=_moved(old.vectors, rotation),
        ),
    )


def transform_triangle_mesh(
    message: mesh_msgs.msg.TriangleMeshStamped, transform: TransformStamped
) -> mesh_msgs.msg.TriangleMeshStamped:
    """Vertices rotated and moved, normals rotated only, all else copied. For 1.0's message.

    It has a Python object for each vertex, and is slow. Arguments and errors as above.
    """
    rotation, translation = _checked(message, transform)
    result = copy.deepcopy(message)
    result.header = _header(message, transform)
    for name, shift in (("vertices", translation), ("vertex_normals", None)):
        points = array_of(getattr(message.mesh, name), ("x", "y", "z")).reshape(-1, 3)
        moved = _moved(points, rotation, shift)
        setattr(result.mesh, name, [Point(*row) for row in moved.tolist()])
    return result


# the function for each class of message
TRANSFORMS: Dict[type, Callable[[Any, TransformStamped], Any]] = {
    mesh_msgs.msg.MeshGeometryStamped: transform_geometry,
    arrays.MeshGeometryStamped: transform_geometry,
    mesh_msgs.msg.VectorFieldStamped: transform_vector_field,
    arrays.VectorFieldStamped: transform_vector_field,
    mesh_msgs.msg.TriangleMeshStamped: transform_triangle_mesh,
}


def _checked(message, transform):
    source, child = message.header.frame_id, transform.child_frame_id
    if child and child.lstrip("/") != source.lstrip("/"):
        raise TransformError(
            "the transform is from %r to %r, but the message is in %r"
            % (child, transform.header.frame_id, source)
        )
    return rotation_and_translation(transform)


def _header(message, transform):
    header = copy.deepcopy(message.header)
    header.frame_id = transform.header.frame_id
    return header


def _moved(points, rotation, translation=None):
    """(N, 3) float64."""
    result = np.asarray(points, dtype=np.float64) @ rotation.T
    if translation is not None:
        result += translation
    return result
