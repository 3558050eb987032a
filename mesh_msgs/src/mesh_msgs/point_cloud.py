"""The points of a sensor_msgs/PointCloud2 as an array."""

from typing import Any, List

import numpy as np

_FLOATS = {7: "f4", 8: "f8"}  # PointField.FLOAT32, FLOAT64
_NUMBERS = {1: "i1", 2: "u1", 3: "i2", 4: "u2", 5: "i4", 6: "u4", **_FLOATS}
_MAX_FIELDS = 1000
_LARGEST_STEP = (1 << 31) - 1  # bytes
_MAX_COUNT = 1 << 16


class PointCloudError(ValueError):
    """A message that is no cloud of points; one line says why."""


def cloud_points(message: Any) -> np.ndarray:
    """(N, 3) float64: x, y and z of each point, row by row.

    Points that are not finite are among them. Fields may be in any order, with gaps between points
    and rows, in either byte order.

    Args:
        message: sensor_msgs/PointCloud2 with fields x, y and z of type FLOAT32 or FLOAT64.
    Raises:
        PointCloudError: a field that is missing or of another type, or sizes that do not fit the
            data.
    """
    height, width = int(message.height), int(message.width)
    if not height or not width:
        return np.zeros((0, 3))
    rows = _rows(message, _position_dtype(message))
    points = np.zeros((height * width, 3))
    for column, name in enumerate("xyz"):
        points[:, column] = rows[name].reshape(-1)
    return points


def cloud_rows(message: Any) -> np.ndarray:
    """(N,) records: all fields of each point, row by row, of organized clouds too.

    A field of several numbers has a row of them. Fields that nobody can name or read (of a type
    that is none, beyond the end of a point, of a name that is there before) are not among them.

    Args:
        message: sensor_msgs/PointCloud2, as for `cloud_points`.
    Raises:
        PointCloudError: as `cloud_points`.
    """
    if not int(message.height) or not int(message.width):
        return np.zeros(0, [(name, "<f4") for name in "xyz"])
    position = _position_dtype(message)
    names: List[str] = []
    formats: List[Any] = []
    offsets: List[int] = []
    order, step = (">" if message.is_bigendian else "<"), int(message.point_step)
    for field in message.fields:
        name, offset, count = str(field.name), int(field.offset), max(1, int(field.count))
        kind = _NUMBERS.get(field.datatype)
        if kind is None or not name or name in names or count > _MAX_COUNT:
            continue
        number = np.dtype(order + kind)
        if offset + count * number.itemsize <= step:
            names.append(name)
            formats.append(number if count == 1 or name in "xyz" else (number, (count,)))
            offsets.append(offset)
    dtype = np.dtype({"names": names, "formats": formats, "offsets": offsets, "itemsize": step})
    return _rows(message, dtype if set("xyz") <= set(names) else position).reshape(-1)


def _position_dtype(message: Any) -> np.dtype:
    """Of x, y and z in a point."""
    step = int(message.point_step)
    if step > max(len(message.data), _LARGEST_STEP):  # no dtype can be as large
        raise PointCloudError(
            "the cloud has %d bytes, but a point of it has %d" % (len(message.data), step)
        )
    if len(message.fields) > _MAX_FIELDS:
        raise PointCloudError("the cloud has %d fields" % len(message.fields))
    order = ">" if message.is_bigendian else "<"
    formats, offsets = [], []
    for name in "xyz":
        found = [field for field in message.fields if field.name == name]
        if len(found) != 1:
            raise PointCloudError(
                "the cloud has %d fields %s, but one is needed (its fields are: %s)"
                % (len(found), name, ", ".join(str(field.name) for field in message.fields))
            )
        field = found[0]
        if field.datatype not in _FLOATS:
            raise PointCloudError(
                "field %s of the cloud has the datatype %d (FLOAT32 (7) or FLOAT64 (8) is needed)"
                % (name, field.datatype)
            )
        number = np.dtype(order + _FLOATS[field.datatype])
        if field.offset + number.itemsize > step:
            raise PointCloudError(
                "field %s of the cloud is at byte %d of points of %d bytes"
                % (name, field.offset, step)
            )
        formats.append(number)
        offsets.append(int(field.offset))
    return np.dtype(
        {"names": list("xyz"), "formats": formats, "offsets": offsets, "itemsize": step}
    )


def _rows(message: Any, point: np.dtype) -> np.ndarray:
    """(height, width) records in the data of a cloud."""
    height, width = int(message.height), int(message.width)
    step, row_step = int(message.point_step), int(message.row_step)
    if height > 1 and row_step < width * step:
        raise PointCloudError(
            "rows of %d bytes hold no %d points of %d bytes" % (row_step, width, step)
        )
    needed = (height - 1) * row_step + width * step
    if len(message.data) < needed:
        raise PointCloudError(
            "the cloud has %d bytes for %d x %d points, which need %d"
            % (len(message.data), height, width, needed)
        )
    return np.ndarray((height, width), point, bytes(message.data), strides=(row_step, step))
