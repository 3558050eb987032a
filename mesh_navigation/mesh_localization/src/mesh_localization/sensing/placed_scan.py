"""A scan in the frame of the robot's base, with the motion meanwhile undone."""

from typing import Any, Callable, NamedTuple, Sequence

import genpy
import numpy as np
from mesh_map.registration.rigid import inverse, moved
from mesh_map.scans.cloud_values import CloudValues
from mesh_map.scans.motion import undo_motion

from mesh_localization.sensing.sensor_scan import SensorScan
from mesh_localization.tracking.localizer import BaseScan

PoseAt = Callable[[float], np.ndarray]
"""(4, 4) in the odometry's frame, of an offset (s) from a stamp."""


class PlacedScan(NamedTuple):
    """
    Attributes:
        scan: in the frame of the base.
        odometry: (4, 4) of the base in the odometry's frame, at the time of the scan.
        sensor: (4, 4) of the sensor in the base.
        stamp: genpy.Time of that time.
        frame: of the sensor.
    """

    scan: BaseScan
    odometry: np.ndarray
    sensor: np.ndarray
    stamp: Any
    frame: str


def placed_scan(scan: SensorScan, sensor_at: PoseAt, base_at: PoseAt) -> PlacedScan:
    """The scan as if all of it had been measured at once.

    Args:
        scan: of a sensor.
        sensor_at, base_at: where both are; what these raise is raised.
    """
    still = undo_motion(CloudValues(scan.points), scan.offsets, sensor_at)
    odometry = base_at(still.offset)
    sensor = inverse(odometry) @ still.pose
    origins = sensor[:3, 3]
    if still.values.origins is not None:
        origins = moved(sensor, still.values.origins)
    stamp = scan.stamp
    if still.offset:
        stamp = stamp + genpy.Duration.from_sec(still.offset)
    points = moved(sensor, still.values.points)
    base_scan = BaseScan(points, origins, stamp.to_sec(), scan.frame)
    return PlacedScan(base_scan, odometry, sensor, stamp, scan.frame)


def joined_scan(scans: Sequence[PlacedScan]) -> PlacedScan:
    """Scans of several sensors as one at the time of the newest.

    Args:
        scans: at least one; of a robot that has moved by its odometry meanwhile.
    """
    newest = max(scans, key=lambda one: one.scan.time)
    points, origins = [], []
    for one in scans:
        step = inverse(newest.odometry) @ one.odometry
        points.append(moved(step, one.scan.points))
        starts = np.broadcast_to(one.scan.origins, one.scan.points.shape)
        origins.append(moved(step, starts))
    scan = BaseScan(np.concatenate(points), np.concatenate(origins), newest.scan.time)
    return newest._replace(scan=scan)
