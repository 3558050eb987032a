"""Arrays of PointCloud2 messages, whatever their layout."""

import itertools
import struct

import numpy as np
import pytest
from mesh_map.base.errors import MeshMapError
from mesh_map.io.point_cloud import cloud_points
from sensor_msgs.msg import PointCloud2, PointField

FLOAT32, FLOAT64 = PointField.FLOAT32, PointField.FLOAT64
POINTS = np.array(
    [[1, 2, 3], [-4.5, 0.25, 1e6], [np.nan, 0, 1], [7, np.inf, -np.inf], [0, 0, 0], [8, 9, 10]]
)


def cloud(points, fields, step, width=None, row_gap=0, big=False, end_gap=True):
    """A message, each number packed on its own.

    fields: (name, datatype, offset); names other than x, y and z get rubbish.
    """
    width = len(points) if width is None else width
    height = len(points) // width if width else 0
    order = ">" if big else "<"
    data = bytearray()
    for row in range(height):
        for column in range(width):
            point = bytearray(b"\xab" * step)
            values = dict(zip("xyz", points[row * width + column]))
            for name, datatype, offset in fields:
                form = order + ("f" if datatype == FLOAT32 else "d")
                struct.pack_into(form, point, offset, values.get(name, -77.0))
            data += point
        data += b"\xcd" * (row_gap if end_gap or row < height - 1 else 0)
    return PointCloud2(
        height=height,
        width=width,
        fields=[PointField(n, offset, datatype, 1) for n, datatype, offset in fields],
        is_bigendian=big,
        point_step=step,
        row_step=width * step + row_gap,
        data=bytes(data),
    )


PLAIN = [("x", FLOAT32, 0), ("y", FLOAT32, 4), ("z", FLOAT32, 8)]
LAYOUTS = {
    "plain": (PLAIN, 12),
    "padded": (PLAIN, 32),
    "doubles": ([("x", FLOAT64, 0), ("y", FLOAT64, 8), ("z", FLOAT64, 16)], 24),
    "mixed": ([("z", FLOAT64, 5), ("intensity", FLOAT32, 0), ("x", FLOAT32, 13)], 23),
}
LAYOUTS["mixed"][0].append(("y", FLOAT32, 19))


@pytest.mark.parametrize(
    "layout, big, width, row_gap, end_gap",
    itertools.product(LAYOUTS, [False, True], [6, 3, 1], [0, 7], [False, True]),
)
def test_any_layout_gives_the_same_points(layout, big, width, row_gap, end_gap):
    message = cloud(POINTS, *LAYOUTS[layout], width, row_gap, big, end_gap)
    points = cloud_points(message)
    assert points.dtype == np.float64 and points.flags.c_contiguous
    np.testing.assert_array_equal(points, POINTS)


def test_clouds_without_points():
    for width, height in ((0, 1), (0, 0), (5, 0)):
        message = PointCloud2(width=width, height=height)
        assert cloud_points(message).shape == (0, 3)


def test_a_row_step_of_zero_is_fine_in_one_row():
    message = cloud(POINTS, PLAIN, 12)
    message.row_step = 0
    np.testing.assert_array_equal(cloud_points(message), POINTS)


def refused(change, match, **layout):
    message = cloud(POINTS, PLAIN, 12, **layout)
    change(message)
    with pytest.raises(MeshMapError, match=match):
        cloud_points(message)


def test_what_is_no_cloud_is_refused():
    def attribute(name, value):
        return lambda message: setattr(message, name, value)

    def field(index, name, value):
        return lambda message: setattr(message.fields[index], name, value)

    refused(lambda m: m.fields.pop(), r"has 0 fields z.*\(its fields are: x, y\)")
    refused(lambda m: m.fields.append(m.fields[0]), "has 2 fields x")
    refused(attribute("fields", [PointField()] * 2000), "2000 fields")
    refused(field(1, "datatype", PointField.INT32), r"field y .* datatype 5 \(FLOAT32 \(7\)")
    refused(field(2, "offset", 9), "field z of the cloud is at byte 9 of points of 12 bytes")
    refused(field(2, "datatype", FLOAT64), "field z .* byte 8 of points of 12 bytes")
    refused(attribute("point_step", 0), "field x .* of 0 bytes")
    refused(attribute("point_step", 1 << 31), "but a point of it has 2147483648")
    refused(attribute("data", b"123"), "has 3 bytes for 1 x 6 points, which need 72")
    refused(attribute("width", 2**32 - 1), "which need 51539607540")
    refused(attribute("row_step", 23), "rows of 23 bytes hold no 2 points", width=2)
    refused(attribute("height", 2**32 - 1), "which need", width=2)
