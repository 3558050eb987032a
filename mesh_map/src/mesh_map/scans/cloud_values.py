"""What the fields of a point cloud mean, whoever named them: records to points, colors, times."""

from dataclasses import dataclass, replace
from typing import Optional, Sequence

import numpy as np

from mesh_map.scans.left_out import LeftOutCounts

_COLORS = (("red", "green", "blue"), ("r", "g", "b"))
_PACKED = ("rgb", "rgba")  # PCL: 0xAARRGGBB, as float32 or uint32
_INTENSITIES = ("intensity", "intensities", "reflectivity", "reflectance", "scalar_Intensity", "i")
# velodyne: time; ouster: t; hesai, robosense, livox_ros_driver2: timestamp; livox: offset_time
TIMES = ("t", "time", "timestamp", "time_stamp", "timeStamp", "offset_time", "time_offset")
ORIGINS = "origins"  # (3,) numbers: where the sensor was, as maps of ours keep it


# m; what has been moved into another frame and back is not exactly 0 any more.
_AT_SENSOR = 1e-3


@dataclass(frozen=True)
class CloudValues:
    """The points of a cloud.

    Attributes:
        points: (N, 3) float64 m in the frame of the cloud.
        colors: (N, 3) uint8 red, green, blue, or None.
        intensities: (N,) float32, or None.
        times: (N,) numbers as they are stored, or None.
        origins: (N, 3) float64 m where the sensor was, or None: at 0.
    """

    points: np.ndarray
    colors: Optional[np.ndarray] = None
    intensities: Optional[np.ndarray] = None
    times: Optional[np.ndarray] = None
    origins: Optional[np.ndarray] = None

    def __len__(self) -> int:
        return len(self.points)

    def only(self, which: np.ndarray) -> "CloudValues":
        """Those of a mask or of indices."""
        arrays = {
            name: value[which]
            for name, value in vars(self).items()
            if isinstance(value, np.ndarray)
        }
        return replace(self, **arrays)


def cloud_values(rows: np.ndarray) -> CloudValues:
    """The points of records with fields x, y and z, in either byte order.

    Args:
        rows: (N,) records.
    """
    points = np.zeros((len(rows), 3))
    for column, name in enumerate("xyz"):
        points[:, column] = rows[name]
    return CloudValues(
        points, _colors(rows), _intensities(rows), _first(rows, TIMES), _origins(rows)
    )


def usable(values: CloudValues, left_out: LeftOutCounts, name: str) -> CloudValues:
    """Without points that are not finite, and those at the sensor itself, as lidars send them for
    beams that have met nothing; both are counted."""
    finite = np.isfinite(values.points).all(axis=1)
    if values.origins is not None:
        finite &= np.isfinite(values.origins).all(axis=1)
    with np.errstate(all="ignore"):
        ways = values.points - (0 if values.origins is None else values.origins)
        away = np.abs(ways).max(axis=1, initial=0.0) > _AT_SENSOR
    left_out.add("not_finite", name, int(np.count_nonzero(~finite)))
    left_out.add("no_return", name, int(np.count_nonzero(finite & ~away)))
    used = finite & away
    return values if used.all() else values.only(used)


def _first(rows: np.ndarray, names: Sequence[str]) -> Optional[np.ndarray]:
    """The first of these fields that is one number for each point."""
    for name in names:
        if name in rows.dtype.names and not rows.dtype[name].shape:
            return np.ascontiguousarray(rows[name])
    return None


def _intensities(rows: np.ndarray) -> Optional[np.ndarray]:
    found = _first(rows, _INTENSITIES)
    if found is None:
        return None
    with np.errstate(over="ignore", invalid="ignore"):
        return np.nan_to_num(found.astype(np.float32), nan=0.0, posinf=0.0, neginf=0.0)


def _colors(rows: np.ndarray) -> Optional[np.ndarray]:
    for names in _COLORS:
        if set(names) <= set(rows.dtype.names) and not any(rows.dtype[n].shape for n in names):
            return _as_bytes(np.stack([rows[name] for name in names], axis=1))
    packed = _first(rows, _PACKED)
    if packed is None or packed.dtype.itemsize != 4:
        return None
    native = packed.astype(packed.dtype.newbyteorder("="), copy=False).view(np.uint32)
    return np.stack([(native >> shift) & 255 for shift in (16, 8, 0)], axis=1).astype(np.uint8)


def _as_bytes(colors: np.ndarray) -> np.ndarray:
    """uint8 of bytes, of 16 bits as LAS has them, or of parts of 1."""
    if colors.dtype.kind == "f":
        with np.errstate(invalid="ignore"):
            scaled = np.nan_to_num(colors) * (255 if np.nanmax(colors, initial=0) <= 1 else 1)
        return np.clip(np.rint(scaled), 0, 255).astype(np.uint8)
    if colors.dtype.itemsize > 1 and colors.max(initial=0) > 255:
        colors = colors >> 8
    return np.clip(colors, 0, 255).astype(np.uint8)


def _origins(rows: np.ndarray) -> Optional[np.ndarray]:
    names = rows.dtype.names
    if ORIGINS in names and rows.dtype[ORIGINS].shape == (3,):
        return rows[ORIGINS].astype(np.float64)
    columns = ["%s_%d" % (ORIGINS, i) for i in range(3)]  # as PLY has them
    if not set(columns) <= set(names):
        return None
    return np.stack([rows[column].astype(np.float64) for column in columns], axis=1)
