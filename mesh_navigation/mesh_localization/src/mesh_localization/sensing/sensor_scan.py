"""Clouds and scans of sensors as points that can be used."""

from dataclasses import dataclass
from typing import Any, Optional

import numpy as np
from mesh_map.base.errors import MeshMapError
from mesh_map.scans.cloud_values import CloudValues, cloud_values, usable
from mesh_map.scans.laser_scan import scan_beams
from mesh_map.scans.left_out import LeftOutCounts
from mesh_map.scans.point_times import LONGEST, point_times
from mesh_msgs.point_cloud import PointCloudError, cloud_rows

from mesh_localization.sensing.ray_choice import chosen_rays

# Beams without a return are given out at the largest range by some drivers: of a scan of which
# such a share is at one range, it is that.
_ONE_RANGE, _NEARLY = 0.9, 0.005
_FARTHEST = 1e5  # m; what no sensor measures is no point


@dataclass(frozen=True)
class RangeLimits:
    """Which rays are used.

    Attributes:
        nearest, farthest: m; a limit below 0 is none but what the sensor says itself.
        most: rays of one scan.
    """

    nearest: float = -1.0
    farthest: float = -1.0
    most: int = 2000


@dataclass(frozen=True)
class SensorScan:
    """Points of one message.

    Attributes:
        frame: of the sensor.
        stamp: genpy.Time.
        points: (N, 3) float64 m in the sensor's frame as it was when each was measured, N > 0.
        offsets: (N,) s from the stamp; None: all at the stamp.
    """

    frame: str
    stamp: Any
    points: np.ndarray
    offsets: Optional[np.ndarray]


def cloud_scan(message: Any, limits: RangeLimits) -> SensorScan:
    """The scan in a sensor_msgs/PointCloud2; its fields of times are known as those of drivers are.

    Raises:
        MeshMapError: no cloud, or nothing in it that can be used; it says why.
    """
    try:
        rows = cloud_rows(message)
    except PointCloudError as error:
        raise MeshMapError(str(error)) from error
    if not len(rows):
        raise MeshMapError("it has no point")
    values = usable(cloud_values(rows), LeftOutCounts(), "")
    if not len(values):
        text = "none of its %d points is finite and away from the sensor"
        raise MeshMapError(text % len(rows))
    values = _within(values, limits)
    offsets = None
    if values.times is not None:
        offsets = point_times(values.times, message.header.stamp.to_sec()).offsets
    return _scan(message, values.points, offsets)


def laser_scan(message: Any, limits: RangeLimits) -> SensorScan:
    """The scan in a sensor_msgs/LaserScan.

    Raises:
        MeshMapError: as `cloud_scan`.
    """
    beams = scan_beams(message)
    met = beams.met & (beams.ranges < float(message.range_max))
    if not met.any():
        raise MeshMapError("none of its %d rays has met anything" % len(met))
    step = float(message.time_increment)
    times = None
    if 0 < step * len(met) <= LONGEST:
        times = (step * np.arange(len(met)))[met]
    points = beams.ranges[met, None] * beams.directions[met]
    values = _within(CloudValues(points, times=times), limits)
    return _scan(message, values.points, values.times)


def _scan(message: Any, points: np.ndarray, offsets: Optional[np.ndarray]) -> SensorScan:
    header = message.header
    return SensorScan(header.frame_id.lstrip("/"), header.stamp, points, offsets)


def _within(values: CloudValues, limits: RangeLimits) -> CloudValues:
    """Those within the limits, and of these as many as are used.

    Raises:
        MeshMapError: none is left.
    """
    with np.errstate(over="ignore"):
        ranges = np.sqrt(np.einsum("ij,ij->i", values.points, values.points))
    farthest = float(ranges.max())
    at_farthest = np.count_nonzero(ranges >= farthest * (1 - _NEARLY))
    if len(ranges) > 1 and at_farthest >= _ONE_RANGE * len(ranges):
        text = "%d of its %d points are %.1f m away: it has met nothing"
        raise MeshMapError(text % (at_farthest, len(ranges), farthest))
    near = (ranges >= max(0.0, limits.nearest)) & (ranges < _FARTHEST)
    if limits.farthest >= 0:
        near &= ranges < limits.farthest
    if not near.any():
        text = "none of its %d points is between laser_min_range %g m and laser_max_range %g m"
        raise MeshMapError(text % (len(ranges), limits.nearest, limits.farthest))
    indices = np.flatnonzero(near)
    return values.only(indices[chosen_rays(len(indices), limits.most)])
