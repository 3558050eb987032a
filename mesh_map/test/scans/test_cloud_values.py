"""What fields of clouds mean: colors, intensities, times of all drivers, motion undone."""

import numpy as np
import pytest
from mesh_msgs.point_cloud import PointCloudError, cloud_points, cloud_rows
from scan_bags import cloud_message

from mesh_map.scans.cloud_values import CloudValues, cloud_values, usable
from mesh_map.scans.left_out import LeftOutCounts
from mesh_map.scans.motion import undo_motion
from mesh_map.scans.point_times import point_times
from mesh_map.scans.trajectory import rotations_of

POINTS = np.random.default_rng(0).normal(size=(24, 3)).astype(np.float32)
COLORS = np.random.default_rng(1).integers(0, 256, (24, 3)).astype(np.uint8)
STAMP = 1_700_000_000.25


@pytest.mark.parametrize("number", ["f4", "f8"])
@pytest.mark.parametrize("big", [False, True])
@pytest.mark.parametrize("rows, gap", [(1, 0), (4, 5)])
def test_layouts_of_clouds_say_the_same(number, big, rows, gap):
    strengths = np.arange(24, dtype=np.float32)
    message = cloud_message(
        POINTS,
        colors=COLORS,
        intensities=strengths,
        times=np.arange(24, dtype=np.uint32),
        number=number,
        big=big,
        rows=rows,
        gap=gap,
    )
    values = cloud_values(cloud_rows(message))
    assert np.array_equal(values.points, POINTS) and values.points.dtype == np.float64
    assert np.array_equal(values.points, cloud_points(message))
    assert np.array_equal(values.colors, COLORS)
    assert np.array_equal(values.intensities, strengths)
    assert values.times.tolist() == list(range(24))


def test_clouds_that_are_none_are_refused_and_odd_fields_left_out():
    message = cloud_message(POINTS, colors=COLORS)
    message.fields[3].datatype = 99
    assert cloud_values(cloud_rows(message)).colors is None
    message.fields[3].datatype, message.fields[3].offset = 7, 100
    assert cloud_values(cloud_rows(message)).colors is None
    message.data = message.data[:-1]
    with pytest.raises(PointCloudError, match="which need"):
        cloud_rows(message)
    message.fields = message.fields[:2]
    with pytest.raises(PointCloudError, match="0 fields z"):
        cloud_rows(message)
    assert len(cloud_rows(cloud_message(POINTS[:0]))) == 0


def test_colors_of_16_bits_and_parts_of_one():
    kinds = [(name, "<f4") for name in "xyz"]
    wide = np.zeros(2, kinds + [(name, "<u2") for name in ("red", "green", "blue")])
    wide["red"] = [65535, 512]
    assert cloud_values(wide).colors.tolist() == [[255, 0, 0], [2, 0, 0]]
    parts = np.zeros(2, kinds + [(name, "<f4") for name in "rgb"])
    parts["g"] = [1.0, 0.5]
    assert cloud_values(parts).colors.tolist() == [[0, 255, 0], [0, 128, 0]]


def test_points_that_say_nothing_are_counted():
    left_out, points = LeftOutCounts(), POINTS.astype(np.float64)
    points[2], points[3, 1], points[5] = np.nan, np.inf, 0.0
    used = usable(CloudValues(points, COLORS), left_out, "scan 1 of /points")
    kept = np.delete(np.arange(24), [2, 3, 5])
    assert np.array_equal(used.points, points[kept]) and np.array_equal(used.colors, COLORS[kept])
    left_out.add("not_finite", "scan 2 of /points", 5)
    assert left_out.lines() == [
        "left out: 7 points that are not finite, in 2 scans (first: scan 1 of /points)",
        "left out: 1 point at the sensor itself, which say nothing, in 1 scan (scan 1 of /points)",
    ]
    assert LeftOutCounts(left_out.stored()).lines() == left_out.lines()


SECONDS = np.linspace(0.0, 0.1, 5)


@pytest.mark.parametrize(
    "values, exact",
    [
        (SECONDS.astype(np.float32) - np.float32(0.1), 1e-8),  # velodyne: before the stamp
        (np.rint(SECONDS * 1e9).astype(np.uint32), 1e-12),  # ouster, livox: ns
        ((SECONDS * 1e3).astype(np.float32), 1e-8),  # ms
        ((SECONDS * 1e6).astype(np.float32), 1e-8),  # us
        (STAMP + SECONDS, 3e-7),  # hesai, robosense: s since the epoch
        ((STAMP + SECONDS) * 1e9, 5e-7),  # livox 2: ns since the epoch, as floats
        (np.int64(STAMP * 1e9) + np.rint(SECONDS * 1e9).astype(np.int64), 3e-7),
        (np.rint((STAMP + SECONDS) * 1e6).astype(np.uint64), 6e-7),
        (5000.0 + SECONDS + 1e9, 3e-7),  # another clock: the stamp is that of the first point
    ],
)
def test_times_of_all_drivers(values, exact):
    found = point_times(values, STAMP)
    begin = -0.1 if values[0] < 0 else 0.0
    np.testing.assert_allclose(found.offsets, SECONDS + begin, rtol=0, atol=exact)


@pytest.mark.parametrize("values", [np.float32([0, np.nan]), np.uint32([0, 4_000_000_000])])
def test_times_that_are_none_say_why(values):
    found = point_times(values, STAMP)
    assert found.offsets is None and "times" in found.reason


def test_motion_within_a_scan_is_undone():
    """A sensor that drives and turns while it looks at fixed points sees them where they are."""
    rng = np.random.default_rng(3)
    truth = rng.uniform(-20, 20, (2000, 3))
    offsets = np.sort(rng.uniform(-0.02, 0.08, 2000))

    def pose_at(offset):
        pose, half = np.eye(4), 0.5 * (0.3 + 1.5 * offset)
        pose[:3, :3] = rotations_of(np.array([[0, 0, np.sin(half), np.cos(half)]]))[0]
        pose[:3, 3] = 2.0 * offset, 1.0, 0.5 * offset
        return pose

    seen = np.array(
        [np.linalg.inv(pose_at(t)) @ [*point, 1.0] for t, point in zip(offsets, truth)]
    )[:, :3]
    still = undo_motion(CloudValues(seen), offsets, pose_at)
    assert still.offset == 0.0 and np.array_equal(still.pose, pose_at(0.0))
    in_map = still.values.points @ still.pose[:3, :3].T + still.pose[:3, 3]
    assert np.abs(in_map - truth).max() < 30 * (1.5 * 0.005) ** 2 / 8 + 1e-9
    origins = still.values.origins @ still.pose[:3, :3].T + still.pose[:3, 3]
    expected = np.array([pose_at(offset)[:3, 3] for offset in offsets])
    np.testing.assert_allclose(origins, expected, atol=1e-9)
    resting = undo_motion(CloudValues(seen), offsets, lambda _: np.eye(4))
    assert resting.values.origins is None and np.array_equal(resting.values.points, seen)
