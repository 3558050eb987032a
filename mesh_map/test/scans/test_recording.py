"""Drives that are recorded: in memory, as a folder of clouds and as a bag."""

import errno
import hashlib
import io
import os
import subprocess
import sys

import numpy as np
import pytest
import rosbag
import rospy
import tf2_ros
from mesh_msgs_hdf5.formats.clouds.pcd_cloud import read_pcd_cloud
from mesh_msgs_hdf5.formats.clouds.ply_cloud import read_ply_cloud
from mesh_msgs_hdf5.formats.clouds.poses import read_poses
from mesh_msgs_hdf5.model.errors import MapFileError
from tf2_msgs.msg import TFMessage

from mesh_map.base.errors import MeshMapError
from mesh_map.geometry.mesh_geometry import MeshGeometry
from mesh_map.scans import scan_folder
from mesh_map.scans.bag_ros import write_bag
from mesh_map.scans.lidar import Lidar, LidarModel
from mesh_map.scans.odometry_drift import OdometryDrift
from mesh_map.scans.recording import Recording, record_scans
from mesh_map.scans.scan_folder import write_scan_folder
from mesh_map.scans.trajectory import Trajectory
from mesh_msgs import zoo
from mesh_msgs.transform import rotation_and_translation

GRID = zoo.grid()  # 10 m x 10 m, at the height 0
FLOOR = MeshGeometry(GRID.vertices, GRID.faces)
COLORS = np.tile(np.uint8([[10, 20, 30]]), (len(GRID.vertices), 1))
HEIGHT = 1.2
MODEL = LidarModel(rings=8, columns=60, noise=0.0, duration=0.1, lowest=-0.9, highest=-0.2)
DRIFT = OdometryDrift(yaw=0.05, slip=0.02)


def truth(begin=1000.0):
    """Two seconds of a bend on the floor, told at 50 Hz."""
    along = np.arange(101) / 50
    angle = 0.8 * along
    zeros = np.zeros(101)
    positions = np.stack([3 + 2 * np.sin(angle), 5 - 2 * np.cos(angle), zeros], axis=1)
    turns = np.stack([zeros, zeros, np.sin(angle / 2), np.cos(angle / 2)], axis=1)
    return Trajectory(begin + along, positions, turns)


def recorded(drift=DRIFT, colors=COLORS, **more):
    path = truth()
    odometry = drift.of(path)
    values = {"lidar": MODEL, "rate": 10.0, "seed": 3, "colors": colors, **more}
    scans = record_scans(FLOOR, path.above(HEIGHT), odometry=odometry.above(HEIGHT), **values)
    return Recording(path, odometry, HEIGHT, scans, 20)


def test_scans_of_a_drive_have_the_true_and_the_believed_pose():
    scans = list(recorded().scans)
    assert len(scans) == 20
    path, odometry = truth().above(HEIGHT), DRIFT.of(truth()).above(HEIGHT)
    for number, (scan, true, measured) in enumerate(scans):
        time = 1000 + number / 10
        assert scan.time == measured.time == pytest.approx(time) and scan.name == f"scan {number}"
        assert true == pytest.approx(path.poses([time])[0], abs=1e-9)
        assert scan.pose == pytest.approx(odometry.poses([time])[0], abs=1e-9)
        expected = Lidar(FLOOR, MODEL).measure(path, scan.time)
        assert measured.points.tolist() == expected.points.tolist()
        assert scan.points.tolist() == measured.undistorted(odometry).points.tolist()
        assert (scan.colors == [10, 20, 30]).all() and len(scan.intensities) == len(scan.points)
    assert np.linalg.norm(scans[-1].scan.pose[:3, 3] - scans[-1].truth[:3, 3]) > 0.02
    exact = list(recorded(OdometryDrift()).scans)
    for scan, true, _ in exact:
        assert (scan.pose == true).all() and abs(scan.in_map()[:, 2]).max() < 1e-5


def test_scans_at_given_poses_have_no_motion():
    poses = truth().above(HEIGHT).poses([1000.0, 1001.0, 1001.5])
    scans = list(record_scans(FLOOR, poses, lidar=MODEL, rate=2.0))
    assert [each.scan.time for each in scans] == [0.0, 0.5, 1.0]
    for pose, (scan, true, measured) in zip(poses, scans):
        assert true == pytest.approx(pose, abs=1e-9) and scan.pose == pytest.approx(pose, abs=1e-9)
        assert scan.origins is None and scan.points is measured.points
        assert abs(scan.in_map()[:, 2]).max() < 1e-5


def test_the_same_seed_records_the_same():
    def content(seed):
        noisy = LidarModel(rings=4, columns=30, noise=0.02, dropout=0.2, duration=0.1)
        digest = hashlib.sha1()
        for scan, _, _ in recorded(lidar=noisy, seed=seed).scans:
            digest.update(scan.points.tobytes() + scan.origins.tobytes() + scan.pose.tobytes())
        return digest.digest()

    assert content(1) == content(1) != content(2)


def test_what_makes_no_scans_is_told_at_once():
    with pytest.raises(MeshMapError, match="scans at 0 Hz"):
        record_scans(FLOOR, truth(), rate=0)
    with pytest.raises(MeshMapError, match="the trajectory takes 2 s, a revolution .* 3 s"):
        record_scans(FLOOR, truth(), lidar=LidarModel(duration=3.0))


@pytest.mark.parametrize("form, read", [("ply", read_ply_cloud), ("pcd", read_pcd_cloud)])
def test_a_folder_has_clouds_and_poses(tmp_path, form, read):
    folder, told = str(tmp_path / "drive"), []
    count = write_scan_folder(folder, recorded(), form, tell=told.append)
    scans = list(recorded().scans)
    assert told == list(range(1, 21)) and count == sum(len(each.scan.points) for each in scans)
    names = [f"{number:06d}.{form}" for number in range(20)] + ["poses.txt", "truth.txt"]
    assert sorted(os.listdir(folder)) == names and os.listdir(tmp_path) == ["drive"]
    for name, (scan, _, measured) in zip(names, scans):
        rows = np.concatenate(list(read(os.path.join(folder, name)).blocks()))
        assert np.stack([rows[axis] for axis in "xyz"], axis=1).tolist() == scan.points.tolist()
        assert rows["intensity"].tolist() == measured.intensities.tolist()
        assert rows["ring"].tolist() == measured.rings.tolist()
        assert rows["time"].tolist() == measured.times.tolist()
        assert (rows["red"] == 10).all() and (rows["blue"] == 30).all()
    for name, poses in (
        ("poses.txt", [each.scan.pose for each in scans]),
        ("truth.txt", [each.truth for each in scans]),
    ):
        lines = read_poses(os.path.join(folder, name))
        assert [line.time for line in lines] == [each.scan.time for each in scans]
        assert np.array([line.matrix for line in lines]) == pytest.approx(np.array(poses), abs=1e-9)


def test_folders_of_others_and_recordings_are_left_alone(tmp_path):
    folder = tmp_path / "drive"
    write_scan_folder(str(folder), recorded())
    before = sorted(os.listdir(folder))
    with pytest.raises(MapFileError, match="has a recording of 22 files already"):
        write_scan_folder(str(folder), recorded())
    write_scan_folder(str(folder), recorded(rate=1.0), "pcd", overwrite=True)
    assert sorted(os.listdir(folder)) == ["000000.pcd", "000001.pcd", "poses.txt", "truth.txt"]
    (folder / "notes.txt").write_text("mine")
    with pytest.raises(MapFileError, match="has 1 other files than .* notes.txt"):
        write_scan_folder(str(folder), recorded(), overwrite=True)
    (tmp_path / "file").write_text("mine")
    with pytest.raises(MapFileError, match="is no folder"):
        write_scan_folder(str(tmp_path / "file"), recorded(), overwrite=True)
    with pytest.raises(MapFileError, match="does not exist"):
        write_scan_folder(str(tmp_path / "no" / "drive"), recorded())
    assert sorted(os.listdir(tmp_path)) == ["drive", "file"] and len(before) == 22


def test_a_full_disk_leaves_what_was_there(tmp_path, monkeypatch):
    folder = str(tmp_path / "drive")
    write_scan_folder(folder, recorded())
    before = sorted(os.listdir(folder))

    def full(*_arguments):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setitem(scan_folder.FORMS, "ply", full)
    with pytest.raises(MapFileError, match="drive: .* No space left .*make room on the disk"):
        write_scan_folder(folder, recorded(), overwrite=True)
    assert sorted(os.listdir(folder)) == before and os.listdir(tmp_path) == ["drive"]


def test_what_ends_in_the_middle_leaves_nothing(tmp_path):
    def stop(count):
        if count == 3:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        write_scan_folder(str(tmp_path / "drive"), recorded(), tell=stop)
    (tmp_path / "old.bag").write_text("old")
    with pytest.raises(KeyboardInterrupt):
        write_bag(str(tmp_path / "old.bag"), recorded(), overwrite=True, tell=stop)
    with pytest.raises(MapFileError, match="the file exists already"):
        write_bag(str(tmp_path / "old.bag"), recorded())
    assert os.listdir(tmp_path) == ["old.bag"] and (tmp_path / "old.bag").read_text() == "old"


def transforms_of(message):
    """Those of a message of a bag, in the class that tf2 wants."""
    data = io.BytesIO()
    message.serialize(data)
    return TFMessage().deserialize(data.getvalue()).transforms


def test_a_bag_tells_what_a_robot_tells(tmp_path):
    path = str(tmp_path / "drive.bag")
    count = write_bag(path, recorded())
    scans = list(recorded().scans)
    buffer = tf2_ros.BufferCore(rospy.Duration(1000.0))
    heard, arrivals = {}, []
    with rosbag.Bag(path) as bag:
        for topic, message, time in bag.read_messages():
            heard.setdefault(topic, []).append(message)
            arrivals.append(time.to_sec())
            if topic.startswith("/tf"):
                for transform in transforms_of(message):
                    fixed = topic == "/tf_static"
                    set_one = buffer.set_transform_static if fixed else buffer.set_transform
                    set_one(transform, "bag")
    assert {topic: len(messages) for topic, messages in heard.items()} == {
        "/tf_static": 1,
        "/tf": 101,
        "/odom": 101,
        "/truth": 101,
        "/cloud": 20,
    }
    assert arrivals == sorted(arrivals)

    def matrix(frame, child, stamp):
        pose = np.eye(4)
        found = buffer.lookup_transform_core(frame, child, stamp)
        pose[:3, :3], pose[:3, 3] = rotation_and_translation(found)
        return pose

    odometry, points = DRIFT.of(truth()), 0
    for cloud, (scan, true, measured) in zip(heard["/cloud"], scans):
        assert cloud.header.frame_id == "laser"
        stamp = cloud.header.stamp
        assert stamp.to_sec() == pytest.approx(measured.time, abs=1e-6)
        kinds = [("xyz", "<f4", 3), ("intensity", "<f4"), ("ring", "<u2"), ("time", "<f4")]
        rows = np.frombuffer(cloud.data, kinds + [("rgb", "<u4")])
        points += len(rows)
        assert rows["xyz"].tolist() == measured.points.tolist()
        assert matrix("map", "laser", stamp) == pytest.approx(scan.pose, abs=2e-5)
        # With the motion undone by tf, it is the scan that a mapper gets.
        for number in range(0, len(rows), 37):
            later = stamp + rospy.Duration.from_sec(float(rows["time"][number]))
            undone = np.linalg.inv(scan.pose) @ matrix("map", "laser", later)
            place = undone[:3, :3] @ rows["xyz"][number] + undone[:3, 3]
            assert place == pytest.approx(scan.points[number], abs=1e-4)
    assert points == count
    start = truth().poses([1000.0])[0]
    for number, (pose, odom) in enumerate(zip(heard["/truth"], heard["/odom"])):
        assert (pose.header.frame_id, odom.header.frame_id) == ("map", "odom")
        assert odom.child_frame_id == "base_link"
        there = pose.pose.position
        assert [there.x, there.y, there.z] == truth().positions[number].tolist()
        counted = np.linalg.inv(start) @ [*odometry.positions[number], 1.0]
        place = odom.pose.pose.position
        assert [place.x, place.y, place.z] == pytest.approx(counted[:3], abs=1e-9)
    twists = [message.twist.twist for message in heard["/odom"][1:]]
    turning = 0.8 + DRIFT.yaw * 1.6  # rad/s, of the bend and of its drift
    assert [twist.angular.z for twist in twists] == pytest.approx([turning] * 100, rel=1e-3)
    assert [twist.linear.x for twist in twists] == pytest.approx([1.6 * 1.02] * 100, rel=1e-3)
    again = str(tmp_path / "again.bag")
    write_bag(again, recorded())
    with open(path, "rb") as one, open(again, "rb") as two:
        assert one.read() == two.read()


def test_only_bags_need_ros():
    modules = ["scans." + name for name in ("recording", "scan_folder", "tour", "cloud_message")]
    names = ", ".join("mesh_map." + name for name in [*modules, "commands.record_scans"])
    code = "import sys, %s; sys.exit('rospy' in sys.modules)" % names
    subprocess.run([sys.executable, "-c", code], check=True)
