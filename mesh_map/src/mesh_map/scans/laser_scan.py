"""The points of a sensor_msgs/LaserScan as an array."""

import math
from typing import Any, NamedTuple, Tuple

import numpy as np

from mesh_map.base.errors import MeshMapError


class Beams(NamedTuple):
    """The beams of a scan.

    directions: (N, 3) float64, of length 1, in the frame of the scan.
    ranges: (N,) float64 m, as they are.
    met: (N,) bool, which have met something.
    """

    directions: np.ndarray
    ranges: np.ndarray
    met: np.ndarray


def scan_points(message: Any, inf_is_valid: bool = False) -> Tuple[np.ndarray, np.ndarray]:
    """What the rays of a scan met, and where those end that met nothing.

    Ranges below range_min, above range_max and NaN say nothing of what is there. All rays count as
    of the stamp.

    Args:
        message: sensor_msgs/LaserScan.
        inf_is_valid: +inf says that there is nothing up to range_max.
    Returns:
        (N, 3) and (K, 3) float64 meters, in the frame of the scan.
    Raises:
        MeshMapError: as `scan_beams`.
    """
    directions, ranges, met = scan_beams(message)
    farthest = float(message.range_max)
    free = np.isposinf(ranges) & (inf_is_valid and math.isfinite(farthest))
    return ranges[met, None] * directions[met], farthest * directions[free]


def scan_beams(message: Any) -> Beams:
    """All beams of a scan, in their order.

    Args:
        message: sensor_msgs/LaserScan.
    Raises:
        MeshMapError: angles or limits that make no scan, or nothing but NaN and what is below
            range_min, such as 0 and -inf: the sensor is blind, or covered.
    """
    first, step = float(message.angle_min), float(message.angle_increment)
    nearest, farthest = float(message.range_min), float(message.range_max)
    ranges = np.asarray(message.ranges, np.float64)
    if not (math.isfinite(first) and math.isfinite(step) and (step or len(ranges) < 2)):
        raise MeshMapError("the scan has angles from %g rad, %g rad apart" % (first, step))
    if not 0.0 <= nearest < farthest:
        raise MeshMapError("the scan has ranges from %g to %g m" % (nearest, farthest))
    if not ((ranges >= nearest) & (ranges > 0.0)).any():  # also where there are none
        text = "none of the %d ranges of the scan is %g m (range_min) or more"
        raise MeshMapError(text % (len(ranges), nearest), "the sensor is blind, or covered")
    angles = first + step * np.arange(len(ranges))
    directions = np.stack([np.cos(angles), np.sin(angles), np.zeros(len(ranges))], axis=1)
    met = np.isfinite(ranges) & (ranges >= nearest) & (ranges <= farthest)
    return Beams(directions, ranges, met)
