"""A recording as a bag of ROS, as `rosbag record` makes it of a robot's topics."""

import os
from typing import Callable, Iterator, Tuple

import numpy as np
import rosbag
from genpy import Duration, Time
from geometry_msgs.msg import (
    Point,
    Pose,
    PoseStamped,
    Quaternion,
    Transform,
    TransformStamped,
    Twist,
    Vector3,
)
from mesh_msgs_hdf5.files.save import save_file
from nav_msgs.msg import Odometry
from std_msgs.msg import Header
from tf2_msgs.msg import TFMessage

from mesh_map.scans.cloud_message import cloud_message
from mesh_map.scans.recording import Recording
from mesh_map.scans.trajectory import Trajectory, quaternions_of, rotations_of

CLOUD, ODOMETRY, TRUTH = "/cloud", "/odom", "/truth"
ODOM_FRAME, BASE_FRAME, SENSOR_FRAME = "odom", "base_link", "laser"


def write_bag(
    path: str,
    recording: Recording,
    overwrite: bool = False,
    tell: Callable[[int], None] = lambda count: None,
) -> int:
    """Write a bag, and return its number of points.

    Topics: /cloud (sensor_msgs/PointCloud2, as the lidar gave it out, see cloud_message), /odom
    (nav_msgs/Odometry), /truth (geometry_msgs/PoseStamped, where base_link really is in the map),
    /tf (map to odom, where the drive began; odom to base_link, as odometry counts) and /tf_static
    (base_link to laser). A cloud is stamped when its revolution begins, and comes when it ends.

    Args:
        path: of the bag; one that is there is replaced if `overwrite`.
        recording: its scans are gone through.
        overwrite: see path.
        tell: called with the number of scans after each.

    Raises:
        MapFileError: exists, save (the disk).
    """
    points = 0

    def fill(descriptor: int) -> None:
        nonlocal points
        with os.fdopen(os.dup(descriptor), "w+b") as stream, rosbag.Bag(stream, "w") as bag:
            points = _fill(bag, recording, tell)

    save_file(path, fill, overwrite=overwrite)
    return points


def _fill(bag: "rosbag.Bag", recording: Recording, tell: Callable[[int], None]) -> int:
    begin = Time.from_sec(float(recording.truth.times[0]))
    above = Transform(Vector3(0.0, 0.0, recording.sensor_height), Quaternion(0.0, 0.0, 0.0, 1.0))
    mounted = TransformStamped(Header(0, begin, BASE_FRAME), SENSOR_FRAME, above)
    bag.write("/tf_static", TFMessage([mounted]), begin)
    told, points = _moments(bag, recording), 0
    now = next(told, None)
    for number, recorded in enumerate(recording.scans):
        measured = recorded.measured
        stamp = Time.from_sec(measured.time)
        # What comes from a driver comes when the last column is measured.
        end = measured.time + (float(measured.times.max()) if len(measured.times) else 0.0)
        while now is not None and now <= end:
            now = next(told, None)
        arrival = stamp + Duration.from_sec(end - measured.time)
        bag.write(CLOUD, cloud_message(measured, SENSOR_FRAME, stamp), arrival)
        points += len(measured.points)
        tell(number + 1)
    while now is not None:
        now = next(told, None)
    return points


def _moments(bag: "rosbag.Bag", recording: Recording) -> Iterator[float]:
    """Writes pose after pose; gives out each time (s) before that."""
    truth, frame = recording.truth, recording.frame_id
    start = truth.poses(truth.times[:1])[0]
    counted = _within(recording.odometry, start)
    linear, angular = _velocities(counted)
    origin = _transform(start[:3, 3], quaternions_of(start[None, :3, :3])[0])
    for k, time in enumerate(truth.times.tolist()):
        yield time
        stamp = Time.from_sec(time)
        position, orientation = counted.positions[k], counted.orientations[k]
        in_map = TransformStamped(Header(0, stamp, frame), ODOM_FRAME, origin)
        moved = _transform(position, orientation)
        in_odom = TransformStamped(Header(0, stamp, ODOM_FRAME), BASE_FRAME, moved)
        bag.write("/tf", TFMessage([in_map, in_odom]), stamp)
        odometry = Odometry(header=Header(0, stamp, ODOM_FRAME), child_frame_id=BASE_FRAME)
        odometry.pose.pose = _pose(position, orientation)
        odometry.twist.twist = Twist(Vector3(*linear[k].tolist()), Vector3(*angular[k].tolist()))
        bag.write(ODOMETRY, odometry, stamp)
        true = PoseStamped(
            Header(0, stamp, frame), _pose(truth.positions[k], truth.orientations[k])
        )
        bag.write(TRUTH, true, stamp)


def _within(trajectory: Trajectory, frame: np.ndarray) -> Trajectory:
    """The trajectory as seen from a frame (4, 4)."""
    poses = np.linalg.inv(frame) @ trajectory.poses(trajectory.times)
    return Trajectory(trajectory.times, poses[:, :3, 3], quaternions_of(poses[:, :3, :3]))


def _velocities(trajectory: Trajectory) -> Tuple[np.ndarray, np.ndarray]:
    """(K, 3) m/s and (K, 3) rad/s in the moving frame, each of the step that ends there."""
    rotations = rotations_of(trajectory.orientations)
    seconds = np.diff(trajectory.times)[:, None]
    moved = np.diff(trajectory.positions, axis=0)
    linear = np.einsum("nji,nj->ni", rotations[1:], moved) / seconds
    turns = rotations[:-1].transpose(0, 2, 1) @ rotations[1:]
    quaternions = quaternions_of(turns) if len(turns) else np.zeros((0, 4))
    sines = np.linalg.norm(quaternions[:, :3], axis=1)
    angles = 2 * np.arctan2(sines, quaternions[:, 3])
    factors = np.where(sines > 0, angles / np.where(sines > 0, sines, 1.0), 0.0)
    angular = factors[:, None] * quaternions[:, :3] / seconds
    still = np.zeros((1, 3))
    return np.concatenate([still, linear]), np.concatenate([still, angular])


def _transform(position: np.ndarray, orientation: np.ndarray) -> Transform:
    return Transform(Vector3(*position.tolist()), Quaternion(*orientation.tolist()))


def _pose(position: np.ndarray, orientation: np.ndarray) -> Pose:
    return Pose(Point(*position.tolist()), Quaternion(*orientation.tolist()))
