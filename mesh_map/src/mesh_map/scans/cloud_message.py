"""What a lidar measured as sensor_msgs/PointCloud2. No rospy: messages are plain data."""

from typing import Any

import numpy as np
from sensor_msgs.msg import PointCloud2, PointField
from std_msgs.msg import Header

from mesh_map.scans.lidar import LidarScan

# The fields of velodyne_pointcloud, in its order, packed; what reads clouds of drivers reads these.
_FIELDS = [(name, "<f4") for name in ("x", "y", "z", "intensity")]
_FIELDS += [("ring", "<u2"), ("time", "<f4")]
_COLOR = [("rgb", "<u4")]
_TYPES = {"<f4": PointField.FLOAT32, "<u2": PointField.UINT16, "<u4": PointField.FLOAT32}


def cloud_message(scan: LidarScan, frame_id: str, stamp: Any) -> PointCloud2:
    """Points as the sensor gave them out, each in its frame as it was at `stamp` + `time`.

    Fields: x, y, z (float32 m), intensity (float32, 0 to 255), ring (uint16, 0 is the lowest), time
    (float32 s after the stamp); of a mesh with colors also rgb (float32 with the bits 0xRRGGBB, as
    of PCL).

    Args:
        scan: what was measured.
        frame_id: of the sensor.
        stamp: when the revolution began.
    """
    point = np.dtype(_FIELDS + (_COLOR if scan.colors is not None else []))
    rows = np.zeros(len(scan.points), point)
    for axis, name in enumerate("xyz"):
        rows[name] = scan.points[:, axis]
    rows["intensity"], rows["ring"], rows["time"] = scan.intensities, scan.rings, scan.times
    if scan.colors is not None:
        red, green, blue = scan.colors.T.astype(np.uint32)
        rows["rgb"] = red << 16 | green << 8 | blue
    assert point.fields is not None and point.names is not None
    fields = [
        PointField(name, point.fields[name][1], _TYPES[point.fields[name][0].str], 1)
        for name in point.names
    ]
    header, size = Header(0, stamp, frame_id), point.itemsize
    count = len(rows)
    return PointCloud2(header, 1, count, fields, False, size, size * count, rows.tobytes(), True)
