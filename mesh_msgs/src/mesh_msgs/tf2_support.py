"""Meshes in tf2: importing this module makes `buffer.transform(mesh, "map")` work.

As tf2_geometry_msgs does it for points. Needs rospy, since tf2_ros does.
"""

from typing import Any, Optional

import rospy
import tf2_ros

from mesh_msgs.transform import TRANSFORMS

_NO_WAIT = rospy.Duration(0)


def transform_at(
    buffer: tf2_ros.BufferInterface,
    message: Any,
    target_frame: str,
    time: Optional[rospy.Time] = None,
    timeout: rospy.Duration = _NO_WAIT,
) -> Any:
    """The message in target_frame, by the transform of one time; its stamp is kept.

    message: MeshGeometryStamped, VectorFieldStamped (of the generated or the array class) or
        TriangleMeshStamped.
    time: None is the message's stamp, rospy.Time(0) the latest there is.

    Raises:
        tf2_ros.TransformException: as buffer.lookup_transform.
        tf2_ros.TypeException: another message, which tf2 cannot transform.
        mesh_msgs.transform.TransformError: the transform in the buffer is no rigid motion.
    """
    stamp = message.header.stamp if time is None else time
    found = buffer.lookup_transform(target_frame, message.header.frame_id, stamp, timeout)
    return _function(message)(message, found)


def transform_between_times(
    buffer: tf2_ros.BufferInterface,
    message: Any,
    target_frame: str,
    target_time: rospy.Time,
    fixed_frame: str,
    timeout: rospy.Duration = _NO_WAIT,
) -> Any:
    """The message, as it stood in fixed_frame at its stamp, in target_frame at target_time.

    Its stamp becomes target_time (buffer.transform_full would keep it). Errors as transform_at.
    """
    found = buffer.lookup_transform_full(
        target_frame,
        target_time,
        message.header.frame_id,
        message.header.stamp,
        fixed_frame,
        timeout,
    )
    result = _function(message)(message, found)
    result.header.stamp = target_time
    return result


def _function(message):
    return tf2_ros.TransformRegistration().get(type(message))


for _kind, _transform in TRANSFORMS.items():
    tf2_ros.TransformRegistration().add(_kind, _transform)
