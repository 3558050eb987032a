"""mesh_tool record-scans: of a map file or any mesh, as a bag or a folder."""

import numpy as np
import pytest
import rosbag
from mesh_msgs_hdf5.formats.clouds.ply_cloud import read_ply_cloud
from mesh_msgs_hdf5.formats.clouds.poses import read_poses
from mesh_msgs_hdf5.map_file import MapFile
from mesh_msgs_hdf5.model.errors import MapFileError
from mesh_msgs_hdf5.model.mesh import Mesh
from verb_calls import call, said

from mesh_msgs import zoo

GRID = zoo.grid(cells=40)  # 10 m x 10 m, at the height 0
FEW = ("--rings", 4, "--columns", 90, "--count", 3)


@pytest.fixture
def floor(tmp_path):
    path = str(tmp_path / "floor.h5")
    colors = np.tile(np.uint8([[1, 2, 3]]), (len(GRID.vertices), 1))
    faces = GRID.faces[:, ::-1].copy()  # looking down; the command turns them
    MapFile.write(path, Mesh(GRID.vertices, faces, vertex_colors=colors, frame_id="hall"))
    return path


def test_a_folder_of_a_tour(floor, tmp_path, capsys):
    folder = str(tmp_path / "drive")
    value = said(capsys, "record_scans", floor, folder, *FEW, "--scans", 12, "--noise", 0)
    assert value["scans"] == 12 and value["drift"] == 0 and value["points"] > 1000
    poses = read_poses(folder + "/poses.txt")
    assert len(poses) == 12
    assert all(pose.matrix[2, 3] == pytest.approx(1.0, abs=1e-3) for pose in poses)
    for number, pose in enumerate(poses):
        rows = np.concatenate(list(read_ply_cloud(f"{folder}/{number:06d}.ply").blocks()))
        points = np.stack([rows[axis] for axis in "xyz"], axis=1).astype(np.float64)
        heights = points @ pose.matrix[2, :3] + pose.matrix[2, 3]
        assert abs(heights).max() < 1e-5 and (rows["green"] == 2).all()
    with pytest.raises(MapFileError, match="has a recording of 14 files already"):
        call("record_scans", floor, folder, *FEW)
    more = ("--scans", 1, "--force", "--format", "pcd", "--still")
    assert said(capsys, "record_scans", floor, folder, *FEW, *more)["scans"] == 1


def test_a_bag_through_waypoints_with_drift(floor, tmp_path, capsys):
    path = str(tmp_path / "drive.bag")
    drift = ("--yaw-drift", 0.05, "--slip", 0.1, "--height-drift", 0.01, "--rate", 5)
    words = (*FEW, "--waypoints", "2,2,0", "8,3,0", *drift)
    value = said(capsys, "record_scans", floor, path, *words)
    assert value["drift"] > 0.3 and value["length"] == pytest.approx(np.hypot(6, 1), abs=0.1)
    with rosbag.Bag(path) as bag:
        topics = bag.get_type_and_topic_info().topics
        assert topics["/cloud"].message_count == value["scans"] > 20
        first = next(iter(bag.read_messages("/truth"))).message
    assert first.header.frame_id == "hall"
    assert (first.pose.position.x, first.pose.position.y) == pytest.approx((2, 2), abs=0.1)
    with pytest.raises(MapFileError, match="the file exists already"):
        call("record_scans", floor, path, *words)


def test_what_cannot_be_recorded_is_told(floor, tmp_path):
    folder = str(tmp_path / "drive")
    with pytest.raises(MapFileError, match="floor.h5: the waypoint .* m from where a robot can be"):
        call("record_scans", floor, folder, "--waypoints", "2,2,0", "80,3,0")
    with pytest.raises(MapFileError, match="a lidar of 0 rings"):
        call("record_scans", floor, folder, "--rings", 0)
    with pytest.raises(MapFileError, match="0 scans are to be recorded"):
        call("record_scans", floor, folder, "--scans", 0)
    with pytest.raises(MapFileError, match="scans at -1"):
        call("record_scans", floor, folder, "--rate", -1)
    assert not (tmp_path / "drive").exists()
