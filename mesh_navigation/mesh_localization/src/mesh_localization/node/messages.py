"""What the node tells, as ROS messages. No rospy: messages are plain data."""

import math
from typing import Any, Mapping

import numpy as np
from geometry_msgs.msg import (
    Point,
    Pose,
    PoseWithCovariance,
    PoseWithCovarianceStamped,
    Quaternion,
    Transform,
    TransformStamped,
    Vector3,
)
from mesh_map.base.errors import MeshMapError
from mesh_map.registration.rigid import moved
from mesh_map.scans.trajectory import quaternions_of, rotations_of
from mesh_msgs.msg import LocalizationState
from sensor_msgs.msg import PointCloud2, PointField
from std_msgs.msg import Header

from mesh_localization.node.session import Report
from mesh_localization.node.start_pose import turned_covariance
from mesh_localization.tracking.localizer import Estimate
from mesh_localization.tracking.ray_fates import RayFate

_KINDS = {"<f4": PointField.FLOAT32, "<u4": PointField.UINT32, "|u1": PointField.UINT8}
_NO_ROTATION = 1e-6  # length of a quaternion


def transform_message(parent: str, child: str, pose: np.ndarray, stamp: Any) -> TransformStamped:
    """The child's pose (4, 4) in the parent, for TF."""
    turned = Transform(Vector3(*pose[:3, 3].tolist()), _quaternion(pose))
    return TransformStamped(Header(0, stamp, parent), child, turned)


def pose_message(estimate: Estimate, frame: str, stamp: Any) -> PoseWithCovarianceStamped:
    """Where the base is in the map, with a covariance about the axes of the map."""
    place = Pose(Point(*estimate.pose[:3, 3].tolist()), _quaternion(estimate.pose))
    covariance = turned_covariance(estimate.covariance, estimate.pose).reshape(-1).tolist()
    return PoseWithCovarianceStamped(Header(0, stamp, frame), PoseWithCovariance(place, covariance))


def state_message(report: Report, frame: str, stamp: Any) -> LocalizationState:
    """Whether the robot knows where it is."""
    estimate = report.estimate
    position = rotation = math.nan
    if estimate is not None:
        position, rotation = estimate.deviations
    return LocalizationState(
        Header(0, stamp, frame),
        int(report.state),
        report.reason,
        report.explained,
        report.residual,
        position,
        rotation,
    )


def matched_cloud(points: np.ndarray, estimate: Estimate, frame: str, stamp: Any) -> PointCloud2:
    """The points of a scan in the map, with how far they are off it.

    Fields: x, y, z, residual (float32 m, from the plane that the ray meets, without a sign), fate
    (uint8, a RayFate). Rays that meet no surface are left out.

    Args:
        points: (N, 3) m in the frame of the base.
        estimate: with the fates of their rays.
    """
    assert estimate.fates is not None
    known = estimate.fates.fates != RayFate.OFF_MAP
    places = moved(estimate.pose, points[known])
    more = {
        "residual": np.abs(estimate.fates.distances[known]).astype("<f4"),
        "fate": estimate.fates.fates[known],
    }
    return cloud_message(places, more, frame, stamp)


def cloud_message(
    points: np.ndarray, more: Mapping[str, np.ndarray], frame: str, stamp: Any
) -> PointCloud2:
    """A cloud with fields x, y, z and others.

    Args:
        points: (N, 3) m.
        more: name of a field -> (N,) float32, uint32 or uint8.
    """
    parts = [(name, "<f4") for name in "xyz"]
    parts += [(name, values.dtype.newbyteorder("<").str) for name, values in more.items()]
    point = np.dtype(parts)
    rows = np.zeros(len(points), point)
    for axis, name in enumerate("xyz"):
        rows[name] = points[:, axis]
    for name, values in more.items():
        rows[name] = values
    assert point.fields is not None
    fields = [
        PointField(name, point.fields[name][1], _KINDS[point.fields[name][0].str], 1)
        for name, _ in parts
    ]
    size, count = point.itemsize, len(rows)
    header = Header(0, stamp, frame)
    return PointCloud2(header, 1, count, fields, False, size, size * count, rows.tobytes(), True)


def pose_matrix(pose: Pose) -> np.ndarray:
    """(4, 4) of a pose; its quaternion may have any length but 0.

    Raises:
        MeshMapError: it is none; the end of a sentence says why.
    """
    p, q = pose.position, pose.orientation
    quaternion = np.array([q.x, q.y, q.z, q.w], np.float64)
    matrix = np.eye(4)
    matrix[:3, 3] = p.x, p.y, p.z
    if not (np.isfinite(matrix).all() and np.isfinite(quaternion).all()):
        raise MeshMapError("it has numbers that are not finite")
    length = np.linalg.norm(quaternion)
    if not length > _NO_ROTATION:
        raise MeshMapError("its orientation is no rotation (none at all: w = 1)")
    matrix[:3, :3] = rotations_of(quaternion[None] / length)[0]
    return matrix


def _quaternion(pose: np.ndarray) -> Quaternion:
    return Quaternion(*quaternions_of(pose[None, :3, :3])[0].tolist())
