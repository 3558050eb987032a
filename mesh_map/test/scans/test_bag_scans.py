"""Bags as scans: poses of tf, odometry and files, and all that bags have wrong."""

from pathlib import Path

import genpy
import numpy as np
import pytest
import rosbag
from mesh_msgs_hdf5.formats.clouds.poses import ScanPose, pose_lines
from mesh_msgs_hdf5.model.errors import MapFileError
from scan_bags import (
    BASE,
    LIDAR,
    MOUNT,
    ODOM,
    START,
    TOPIC,
    cloud_message,
    drive,
    laser_message,
    message_of,
    transform,
    write_bag,
)
from tf2_msgs.msg import TFMessage

from mesh_map.scans.left_out import LeftOutCounts
from mesh_map.scans.scan_inputs import InputOptions, open_inputs

POINTS = np.random.default_rng(0).uniform(1, 9, (60, 3)).astype(np.float32)


def read(path, start=0, **options):
    """(scans, lines of what was left out, notes, frame) of a bag."""
    left_out = LeftOutCounts()
    inputs = open_inputs([str(path)], InputOptions(**options), left_out)
    source = inputs.sources[0]
    scans = [step.scan for step in source.steps(start) if step.scan is not None]
    return scans, left_out.lines(), [*inputs.notes, *source.notes], inputs.frame


def assert_drive(found, expected):
    assert len(found) == len(expected)
    for one, other in zip(found, expected):
        assert np.array_equal(one.points, other.points)
        assert np.array_equal(one.colors, other.colors)
        assert np.array_equal(one.intensities, other.intensities)
        np.testing.assert_allclose(one.pose, other.pose, atol=1e-9)
        assert one.time == pytest.approx(START + other.time, abs=1e-6)


class Writer:
    """A bag of messages, one after the other; tf of a base that drives along x at 1 m/s."""

    def __init__(self, path: Path) -> None:
        self.path = str(path)
        self._bag = rosbag.Bag(self.path, "w")

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self._bag.close()

    def add(self, topic, message, time):
        self._bag.write(topic, message, genpy.Time.from_sec(time))

    def tf(self, times, parent=ODOM, child=BASE, speed=1.0):
        for time in times:
            pose = np.eye(4)
            pose[0, 3] = speed * (time - START)
            self.add("/tf", TFMessage([transform(parent, child, pose, time)]), time)

    def static(self, parent=BASE, child=LIDAR, topic="/tf_static"):
        pose = np.eye(4)
        pose[:3, 3] = MOUNT
        self.add(topic, TFMessage([transform(parent, child, pose, START)]), START)


@pytest.mark.parametrize("compression", ["none", "bz2", "lz4"])
def test_a_drive_by_tf(tmp_path, compression):
    path = write_bag(tmp_path / "a.bag", drive(), compression=compression)
    scans, left, notes, frame = read(path)
    assert_drive(scans, drive())
    assert left == [] and frame == ODOM
    assert set(notes) == {"%s: the map is in frame odom (--frame names another)" % path}
    assert_drive(read(path, start=5)[0], drive()[5:])
    assert read(path, frame=BASE)[0][0].pose[:3, 3].tolist() == MOUNT.tolist()
    with pytest.raises(MapFileError, match="tf has no frame world .*frames are: base_link, lidar"):
        read(path, frame="world")


def test_scans_minutes_apart(tmp_path):
    """Longer than transforms are kept: each is used while those around it are."""
    path = tmp_path / "a.bag"
    with Writer(path) as bag:
        bag.static()
        for second in range(301):
            if second % 150 == 149:
                time = START + second - 0.75  # between two transforms
                bag.add(TOPIC, cloud_message(POINTS, stamp=time), time)
            bag.tf([START + second])
    scans, left, _, _ = read(path)
    assert left == [] and len(scans) == 2
    places = [scan.pose[0, 3] - MOUNT[0] for scan in scans]
    assert places == pytest.approx([148.25, 298.25])


def test_a_drive_by_odometry(tmp_path):
    path = write_bag(tmp_path / "a.bag", drive(), poses="odometry")
    scans, left, notes, frame = read(path)
    assert_drive(scans, drive())
    assert frame == ODOM and "poses are those of /odom" in notes[0]


def test_odometry_without_a_place_of_the_sensor(tmp_path):
    from scan_bags import odometry

    path = tmp_path / "a.bag"
    with Writer(path) as bag:
        for time in (START, START + 1):
            bag.add("/odom", odometry(np.eye(4), time), time)
        bag.add(TOPIC, cloud_message(POINTS, stamp=START + 0.5), START + 0.5)
    scans, _, notes, frame = read(path)
    assert np.array_equal(scans[0].pose, np.eye(4)) and frame == ODOM
    assert any("nothing says where frame lidar is on base_link" in note for note in notes)


def test_no_poses_at_all(tmp_path):
    path = write_bag(tmp_path / "a.bag", drive()[:3], poses="none")
    with pytest.raises(MapFileError, match="neither tf nor odometry"):
        read(path)
    scans, _, _, frame = read(path, frame=LIDAR)  # it stood still
    assert frame == LIDAR and all(np.array_equal(scan.pose, np.eye(4)) for scan in scans)


@pytest.mark.parametrize("form", ["tum", "kitti"])
def test_poses_of_a_file(tmp_path, form):
    path = write_bag(tmp_path / "a.bag", drive(), poses="none")
    file = tmp_path / "poses.txt"
    poses = [ScanPose(scan.pose, START + scan.time) for scan in drive()]
    file.write_text(pose_lines(poses, form))
    scans, left, _, frame = read(path, poses=str(file))
    assert_drive(scans, drive())
    assert left == [] and frame == "map"
    file.write_text(pose_lines(poses[:4], form))
    if form == "kitti":
        with pytest.raises(MapFileError, match="4 poses without times .* but 8 scans on /points"):
            read(path, poses=str(file))
        return
    scans, left, _, _ = read(path, poses=str(file))
    assert len(scans) == 4
    assert left == [
        "left out: 4 scans (first: scan 5 of /points) without a pose: the poses are of 1000.000 to"
        " 1000.300 s, its time is 1000.400 s"
    ]


def test_clocks_that_differ(tmp_path):
    path = write_bag(tmp_path / "a.bag", drive(), later=-500.0)
    text = "the scans are of 1000.000 to 1000.700 s, but tf of 500.000 to 500.700 s: their clocks"
    with pytest.raises(MapFileError, match=text):
        read(path)
    late = write_bag(
        tmp_path / "b.bag", drive(), message=lambda scan: message_of(scan, stamp=5000 + scan.time)
    )
    with pytest.raises(MapFileError, match="--clock received"):
        read(late)
    scans, _, _, _ = read(late, clock="received")
    assert_drive(scans, drive())


def test_a_bag_that_ends_in_the_middle(tmp_path):
    whole = Path(write_bag(tmp_path / "a.bag", drive())).read_bytes()
    for share in (0.4, 0.7, 0.95):
        cut = tmp_path / "cut.bag"
        cut.write_bytes(whole[: int(share * len(whole))])
        scans, _, notes, _ = read(cut)
        assert 0 < len(scans) < 8 or share > 0.9
        assert_drive(scans, drive()[: len(scans)])
        assert any("was not closed, or ends in the middle" in note for note in notes)
        assert cut.read_bytes() == whole[: int(share * len(whole))]
    cut.write_bytes(whole[:5000])
    with pytest.raises(MapFileError, match="before its first message"):
        read(cut)
    broken = bytearray(whole)
    middle = len(whole) // 2
    broken[middle : middle + 40_000] = bytes(40_000)
    cut.write_bytes(bytes(broken))
    scans, _, notes, _ = read(cut)
    assert 0 < len(scans) < 8 and any("is damaged behind" in note for note in notes)


def test_scans_that_cannot_be_used_are_counted(tmp_path):
    path = tmp_path / "a.bag"
    bad = POINTS.copy()
    bad[:5], bad[5:8] = np.nan, np.inf
    broken = cloud_message(POINTS, stamp=START + 0.4)
    broken.data = broken.data[:-1]
    with Writer(path) as bag:
        bag.static()
        bag.tf(START + 0.1 * np.arange(12))
        for i, message in enumerate(
            [
                cloud_message(bad),
                cloud_message(POINTS[:0]),
                cloud_message(bad[:8]),
                cloud_message(POINTS, frame="camera"),
                broken,
            ]
        ):
            message.header.stamp = genpy.Time.from_sec(START + 0.1 * i)
            bag.add(TOPIC, message, START + 0.1 * i)
        bag.add(TOPIC, cloud_message(POINTS, stamp=START + 99), START + 1.1)
    scans, left, _, _ = read(path)
    assert [len(scan.points) for scan in scans] == [52]
    assert left[0].startswith("left out: 16 points that are not finite, in 2 scans")
    assert left[1].startswith("left out: 2 scans (first: scan 2 of /points) without a point")
    assert left[2].startswith(
        "left out: 2 scans (first: scan 4 of /points) without a pose: tf has no frame camera"
    )
    assert left[3].startswith("left out: 1 scan (scan 5 of /points) that cannot be read: the cloud")


def test_frames_of_two_trees(tmp_path):
    path = tmp_path / "a.bag"
    with Writer(path) as bag:
        bag.static()
        bag.tf([START, START + 1])
        bag.tf([START, START + 1], parent="world", child="camera")
        bag.add(TOPIC, cloud_message(POINTS, stamp=START + 0.5), START + 0.5)
        bag.add(TOPIC, cloud_message(POINTS, frame="camera", stamp=START + 0.5), START + 0.6)
    scans, left, _, _ = read(path)
    assert len(scans) == 1 and "odom and camera are in different trees of tf" in left[0]


def test_transforms_that_are_none(tmp_path):
    path = tmp_path / "a.bag"
    with Writer(path) as bag:
        bag.static()
        bag.tf([START])
        odd = transform(ODOM, BASE, np.eye(4), START + 0.5)
        odd.transform.rotation.w = 0.0
        bag.add("/tf", TFMessage([odd]), START + 0.5)
        odd = transform(ODOM, BASE, np.eye(4), START + 0.5)
        odd.transform.translation.x = np.nan
        bag.add("/tf", TFMessage([odd, transform(BASE, BASE, np.eye(4), START)]), START + 0.5)
        bag.tf([START + 1])
        bag.add(TOPIC, cloud_message(POINTS, stamp=START + 0.5), START + 0.5)
    scans, left, _, _ = read(path)
    np.testing.assert_allclose(scans[0].pose[:3, 3], MOUNT + [0.5, 0, 0], atol=1e-9)
    assert left[0].startswith("left out: 3 transforms that are no rotation and translation: ")


def test_motion_within_a_scan(tmp_path):
    """Points of a wall that a sensor at 10 m/s has seen one after the other are in one plane."""
    offsets = np.linspace(0, 0.1, 60)
    wall = np.stack([np.full(60, 20.0), np.linspace(-5, 5, 60), np.ones(60)], axis=1)
    seen = wall - MOUNT
    seen[:, 0] -= 10.0 * offsets
    nanoseconds = np.rint(offsets * 1e9).astype(np.uint32)
    path = tmp_path / "a.bag"
    with Writer(path) as bag:
        bag.static()
        bag.add(TOPIC, cloud_message(seen, number="f8", times=nanoseconds), START + 0.1)
        bag.tf(START + 0.02 * np.arange(8), speed=10.0)
    scans, left, _, _ = read(path)
    assert left == []
    np.testing.assert_allclose(scans[0].in_map(), wall, atol=2e-6)
    origins = scans[0].origins_in_map()
    np.testing.assert_allclose(origins[:, 0], MOUNT[0] + 10 * offsets, atol=2e-6)
    odd = tmp_path / "b.bag"
    with Writer(odd) as bag:
        bag.static()
        bag.tf(START + 0.02 * np.arange(8))
        bag.add(TOPIC, cloud_message(seen, times=nanoseconds * np.uint32(40)), START + 0.1)
    scans, left, _, _ = read(odd)
    assert scans[0].origins is None
    assert left[0].startswith("motion within 1 scan (scan 1 of /points) is not undone: the times")


def test_laser_scans(tmp_path):
    path = tmp_path / "a.bag"
    with Writer(path) as bag:
        bag.static()
        bag.tf([START, START + 1])
        bag.add("/scan", laser_message([1.0, np.inf, 2.0, np.nan, 3.0], START), START)
        bag.add("/scan", laser_message([0.0, 0.0], START), START + 0.1)
    scans, left, _, _ = read(path)
    assert np.linalg.norm(scans[0].points, axis=1) == pytest.approx([1, 2, 3])
    assert "1 scan (scan 2 of /scan) that cannot be read: none of the 2 ranges" in left[0]


def test_topics(tmp_path):
    path = tmp_path / "a.bag"
    with Writer(path) as bag:
        bag.static()
        bag.tf([START, START + 1])
        for topic in ("/left", "/right"):
            bag.add(topic, cloud_message(POINTS, stamp=START + 0.5), START + 0.5)
        bag.add("/scan", laser_message([1.0, 2.0], START + 0.5), START + 0.5)
    with pytest.raises(MapFileError, match=r"2 topics with scans.*/left \(1\), /right \(1\)"):
        read(path)
    assert len(read(path, topics=["left", "/right"])[0]) == 2
    assert len(read(path, topics=["/scan"])[0]) == 1
    with pytest.raises(MapFileError, match="there is no topic /points"):
        read(path, topics=["points"])
    with pytest.raises(MapFileError, match="topic /tf has tf2_msgs/TFMessage, which are no scans"):
        read(path, topics=["/tf"])
    empty = tmp_path / "b.bag"
    with Writer(empty) as bag:
        bag.tf([START])
    with pytest.raises(MapFileError, match="no topic with PointCloud2 or LaserScan"):
        read(empty)


def test_static_transforms_of_the_first_of_several_bags(tmp_path):
    for name, begin in (("a.bag", START), ("b.bag", START + 1)):
        with Writer(tmp_path / name) as bag:
            if name == "a.bag":
                bag.static()
            bag.tf([begin, begin + 1])
            bag.add(TOPIC, cloud_message(POINTS, stamp=begin + 0.5), begin + 0.5)
    left_out = LeftOutCounts()
    paths = [str(tmp_path / name) for name in ("a.bag", "b.bag")]
    inputs = open_inputs(paths, InputOptions(), left_out)
    scans = [step.scan for source in inputs.sources for step in source.steps()]
    assert [scan.pose[0, 3] for scan in scans] == pytest.approx([0.5 + MOUNT[0], 1.5 + MOUNT[0]])
    assert left_out.lines() == []


def test_a_frame_with_two_parents_is_told(tmp_path):
    path = tmp_path / "a.bag"
    with Writer(path) as bag:
        bag.static()
        bag.tf([START, START + 1])
        bag.tf([START, START + 1], parent="map", child=BASE)
        bag.add(TOPIC, cloud_message(POINTS, stamp=START + 0.5), START + 0.5)
    notes = read(path, frame=ODOM)[2]
    assert any("frame base_link has several parents in tf (map, odom)" in note for note in notes)
