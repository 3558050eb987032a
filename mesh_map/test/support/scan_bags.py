"""A short drive over a small world, and bags, clouds and maps of it."""

import functools
from pathlib import Path
from typing import Any, Callable, List, Optional, Sequence, Tuple

import genpy
import numpy as np
import rosbag
from geometry_msgs.msg import TransformStamped
from mesh_msgs.outdoor_world import outdoor_world
from mesh_msgs_hdf5.formats.clouds.poses import ScanPose, pose_lines, quaternion_of
from nav_msgs.msg import Odometry
from sensor_msgs.msg import LaserScan, PointCloud2, PointField
from tf2_msgs.msg import TFMessage

from mesh_map.map.mesh_map import MeshMap
from mesh_map.scans.lidar import LidarModel
from mesh_map.scans.recording import record_scans
from mesh_map.scans.scan import Scan

START = 1000.0  # s, of the first scan
TOPIC, LIDAR, BASE, ODOM = "/points", "lidar", "base_link", "odom"
MOUNT = np.array([0.2, 0.0, 0.5])  # m, of the lidar on the base
_DATATYPES = {"f4": 7, "f8": 8, "u4": 6, "u1": 2, "u2": 4}


@functools.lru_cache(maxsize=None)
def drive(count: int = 8) -> Tuple[Scan, ...]:
    """Scans along an arc, 0.1 s apart, with colors and intensities; poses are exact."""
    world = outdoor_world(20_000, 0, size=24.0, trees=False)
    poses = np.tile(np.eye(4), (count, 1, 1))
    angles = np.linspace(0.0, 1.2, count)
    poses[:, 0, 3], poses[:, 1, 3], poses[:, 2, 3] = 3 * np.cos(angles), 3 * np.sin(angles), 3.0
    poses[:, 0, 0] = poses[:, 1, 1] = np.cos(angles)
    poses[:, 1, 0] = np.sin(angles)
    poses[:, 0, 1] = -poses[:, 1, 0]
    lidar = LidarModel(rings=16, columns=256, noise=0.005, max_range=15)
    surface = MeshMap(world.vertices, world.faces)
    recorded = record_scans(surface, poses, lidar=lidar, seed=1, colors=world.colors)
    return tuple(each.scan for each in recorded)


def cloud_message(
    points: np.ndarray,
    frame: str = LIDAR,
    stamp: float = START,
    *,
    colors: Optional[np.ndarray] = None,
    times: Optional[np.ndarray] = None,
    time_name: str = "t",
    intensities: Optional[np.ndarray] = None,
    number: str = "f4",
    big: bool = False,
    rows: int = 1,
    gap: int = 0,
) -> PointCloud2:
    """A cloud with these fields; gap: bytes behind each point; rows: of an organized cloud."""
    order = ">" if big else "<"
    columns = [(name, order + number, points[:, i]) for i, name in enumerate("xyz")]
    if colors is not None:
        packed = np.left_shift(colors.astype(np.uint32), [16, 8, 0]).sum(1, dtype=np.uint32)
        columns.append(("rgb", order + "f4", packed.view(np.float32)))
    if intensities is not None:
        columns.append(("intensity", order + "f4", intensities))
    if times is not None:
        columns.append((time_name, times.dtype.newbyteorder(order).str, times))
    dtype = np.dtype([(name, kind) for name, kind, _ in columns] + [("gap", "V%d" % gap)])
    data = np.zeros(len(points), dtype)
    for name, _, values in columns:
        data[name] = values
    fields = [
        PointField(name, dtype.fields[name][1], _DATATYPES[np.dtype(kind).str[1:]], 1)
        for name, kind, _ in columns
    ]
    message = PointCloud2(height=rows, width=len(points) // rows, fields=fields)
    message.is_bigendian, message.point_step = big, dtype.itemsize
    message.row_step = dtype.itemsize * message.width
    message.data = data.tobytes()
    message.header.frame_id, message.header.stamp = frame, genpy.Time.from_sec(stamp)
    return message


def message_of(scan: Scan, **keywords: Any) -> PointCloud2:
    """The cloud of a scan, with its colors and intensities."""
    stamp = START + (scan.time or 0.0)
    keywords = {"colors": scan.colors, "intensities": scan.intensities, **keywords}
    return cloud_message(scan.points, stamp=keywords.pop("stamp", stamp), **keywords)


def transform(parent: str, child: str, pose: np.ndarray, stamp: float) -> TransformStamped:
    """The pose (4, 4) of a frame in its parent."""
    made = TransformStamped(child_frame_id=child)
    made.header.frame_id, made.header.stamp = parent, genpy.Time.from_sec(stamp)
    place, turn = made.transform.translation, made.transform.rotation
    place.x, place.y, place.z = pose[:3, 3]
    turn.x, turn.y, turn.z, turn.w = quaternion_of(pose[:3, :3])
    return made


def odometry(pose: np.ndarray, stamp: float) -> Odometry:
    """The pose of the base in odom."""
    made, moved = Odometry(child_frame_id=BASE), transform(ODOM, BASE, pose, stamp)
    made.header = moved.header
    place = moved.transform.translation
    made.pose.pose.position.x = place.x
    made.pose.pose.position.y = place.y
    made.pose.pose.position.z = place.z
    made.pose.pose.orientation = moved.transform.rotation
    return made


def mount() -> np.ndarray:
    """(4, 4) of the lidar in the base."""
    pose = np.eye(4)
    pose[:3, 3] = MOUNT
    return pose


def write_bag(
    path: Path,
    scans: Sequence[Scan],
    *,
    poses: str = "tf",
    later: float = 0.0,
    compression: str = "none",
    message: Callable[..., Any] = message_of,
    chunk: int = 1 << 14,
) -> str:
    """A bag of scans.

    poses: tf (odom -> base_link, and static base_link -> lidar), odometry (with the latter), or
    none. later: s by which the clock of tf is ahead.
    """
    with rosbag.Bag(str(path), "w", compression=compression, chunk_threshold=chunk) as bag:
        first = genpy.Time.from_sec(START)
        if poses != "none":
            static = transform(BASE, LIDAR, mount(), START)
            bag.write("/tf_static", TFMessage([static]), first)
        for scan in scans:
            time = START + (scan.time or 0.0)
            base = scan.pose @ np.linalg.inv(mount())
            stamp = genpy.Time.from_sec(time)
            bag.write(TOPIC, message(scan), stamp)
            if poses == "tf":
                moved = transform(ODOM, BASE, base, time + later)
                bag.write("/tf", TFMessage([moved]), stamp + genpy.Duration.from_sec(0.01))
            elif poses == "odometry":
                bag.write("/odom", odometry(base, time + later), stamp)
    return str(path)


def write_clouds(folder: Path, scans: Sequence[Scan], poses: bool = True) -> str:
    """A PCD file of each scan, and poses.txt (KITTI)."""
    from mesh_map.scans.kept_scans import _records
    from mesh_msgs_hdf5.formats.clouds.pcd_cloud import write_pcd_cloud

    folder.mkdir(exist_ok=True)
    for number, scan in enumerate(scans):
        rows = _records(scan)
        file = folder / ("scan%d.pcd" % number)
        with open(file, "wb") as stream:
            write_pcd_cloud(str(file), stream, len(rows), rows.dtype, iter([rows]))
    if poses:
        lines = pose_lines([ScanPose(scan.pose) for scan in scans], "kitti")
        (folder / "poses.txt").write_text(lines)
    return str(folder)


def laser_message(ranges: List[float], stamp: float) -> LaserScan:
    """A scan of a half circle."""
    made = LaserScan(angle_min=-1.5, angle_increment=3.0 / max(1, len(ranges) - 1))
    made.range_min, made.range_max, made.ranges = 0.1, 30.0, ranges
    made.header.frame_id, made.header.stamp = LIDAR, genpy.Time.from_sec(stamp)
    return made
