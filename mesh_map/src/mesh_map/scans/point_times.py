"""When each point of a cloud was measured: what drivers put into its field of times.

| driver | field | type | unit |
|---|---|---|---|
| velodyne_pointcloud | time | float32 | s from the stamp |
| ouster_ros | t | uint32 | ns from the stamp |
| hesai, rslidar_sdk | timestamp | float64 | s since the epoch |
| livox_ros_driver2 | timestamp | float64 | ns since the epoch |
| livox_ros_driver | offset_time | uint32 | ns from the stamp |
| others | time, t | float32 | ms or us from the stamp |
"""

from typing import NamedTuple, Optional

import numpy as np

LONGEST = 2.0  # s; a scan that takes longer is none
_SINCE_EPOCH = ((1e17, 1e-9), (1e14, 1e-6), (1e11, 1e-3), (1e8, 1.0))  # from, s per unit
_OFFSETS = (1.0, 1e-3, 1e-6, 1e-9)
_OTHER_CLOCK = 10.0  # s


class PointTimes(NamedTuple):
    """offsets: (N,) float64 s from the stamp, or None; reason: why there are none."""

    offsets: Optional[np.ndarray]
    reason: str = ""


def point_times(values: np.ndarray, stamp: float) -> PointTimes:
    """Offsets from the stamp of a cloud.

    Numbers since the epoch are known by their size; floats from the stamp by the largest unit with
    which the scan takes 2 s at most; whole numbers from the stamp are nanoseconds. Where times
    since the epoch are of another clock than the stamp, the stamp is that of the first point.

    Args:
        values: (N,) as the cloud has them, at least one.
        stamp: s.
    """
    numbers = values.astype(np.float64)
    if not np.isfinite(numbers).all():
        return PointTimes(None, "times of points are not finite")
    low, high = float(numbers.min()), float(numbers.max())
    wide = values.dtype.itemsize == 8
    unit = next((unit for least, unit in _SINCE_EPOCH if wide and low >= least), None)
    if unit == 1.0 and (values.dtype.kind != "f" or high - low > LONGEST):
        unit = None  # nanoseconds from the stamp may be as large
    if unit is not None:
        # in whole units first: float64 since the epoch has 0.2 us
        offsets = (values - values.min()).astype(np.float64) * unit
        begin = low * unit - stamp
        offsets += begin if abs(begin) <= _OTHER_CLOCK else 0.0
    elif values.dtype.kind in "iu":
        offsets = numbers * 1e-9
    else:
        unit = next((u for u in _OFFSETS if (high - low) * u <= LONGEST), _OFFSETS[-1])
        offsets = numbers * unit
    span = float(offsets.max() - offsets.min())
    if span > LONGEST or abs(offsets).max() > _OTHER_CLOCK:
        text = "the times of its points cover %.3g s, from %.3g s after the stamp on"
        return PointTimes(None, text % (span, offsets.min()))
    return PointTimes(offsets)
