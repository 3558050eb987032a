"""The motion of a sensor undone that moved while it measured."""

from dataclasses import replace
from typing import Callable, NamedTuple, Optional

import numpy as np

from mesh_map.base.rotation import rotated
from mesh_map.scans.cloud_values import CloudValues

# Between such, points are moved along straight lines: off by r a^2 / 8 for a turn by a, at 1 rad/s
# and r = 100 m 0.3 mm
KNOT_SECONDS = 0.005


class StillScan(NamedTuple):
    """values: points and origins in the sensor's frame at one moment; pose: (4, 4) of then, into
    the map; offset: s of that moment from the stamp."""

    values: CloudValues
    pose: np.ndarray
    offset: float


def undo_motion(
    values: CloudValues,
    offsets: Optional[np.ndarray],
    pose_at: Callable[[float], np.ndarray],
) -> StillScan:
    """Points as if they had all been measured at once: at the stamp, or as near to it as they were.

    Args:
        values: in the sensor's frame at the time of each point.
        offsets: (N,) s from the stamp; None: all at the stamp.
        pose_at: (4, 4) float64 of the sensor at an offset; what it raises is raised.
    """
    if offsets is None or not len(values):
        return StillScan(values, pose_at(0.0), 0.0)
    first, last = float(offsets.min()), float(offsets.max())
    reference = min(max(0.0, first), last)
    pose = pose_at(reference)
    if first == last:
        return StillScan(values, pose, reference)
    knots = np.linspace(first, last, int(np.ceil((last - first) / KNOT_SECONDS)) + 1)
    matrices = np.array([pose_at(float(knot)) for knot in knots])
    if (matrices == matrices[0]).all():
        return StillScan(values, pose, reference)
    relative = np.linalg.inv(pose) @ matrices
    before = np.clip(np.searchsorted(knots, offsets, side="right") - 1, 0, len(knots) - 2)
    part = ((offsets - knots[before]) / (knots[1] - knots[0]))[:, None]
    places = [values.points, np.zeros((1, 3)) if values.origins is None else values.origins]
    moved = [np.zeros_like(values.points), np.zeros_like(values.points)]
    for knot in range(len(knots) - 1):
        here = np.flatnonzero(before == knot)
        for result, still in zip(moved, places):
            chosen = still if len(still) == 1 < len(values) else still[here]
            ends = [
                rotated(chosen, matrix[:3, :3]) + matrix[:3, 3]
                for matrix in relative[knot : knot + 2]
            ]
            result[here] = (1 - part[here]) * ends[0] + part[here] * ends[1]
    still_values = replace(values, points=moved[0], times=None, origins=moved[1])
    return StillScan(still_values, pose, reference)
