"""Clouds in files, folders and maps as scans; poses; what is refused, and how."""

import numpy as np
import pytest
from mesh_msgs_hdf5.formats.clouds.poses import ScanPose, pose_lines
from mesh_msgs_hdf5.map_file import MapFile
from mesh_msgs_hdf5.model.errors import MapFileError
from mesh_msgs_hdf5.model.mesh import Mesh
from scan_bags import drive, write_bag, write_clouds

from mesh_map.scans import cloud_files
from mesh_map.scans.kept_scans import KeptScans
from mesh_map.scans.left_out import LeftOutCounts
from mesh_map.scans.scan import Scan
from mesh_map.scans.scan_inputs import InputOptions, open_inputs


def opened(*paths, left_out=None, **options):
    """(scans, what was opened) of inputs."""
    left_out = LeftOutCounts() if left_out is None else left_out
    inputs = open_inputs([str(path) for path in paths], InputOptions(**options), left_out)
    steps = [step for source in inputs.sources for step in source.steps()]
    return [step.scan for step in steps if step.scan is not None], inputs


def assert_same(found, expected):
    assert len(found) == len(expected)
    for one, other in zip(found, expected):
        for name in ("points", "pose", "colors", "intensities", "origins"):
            value = getattr(other, name)
            assert (getattr(one, name) is None) == (value is None), name
            assert value is None or np.array_equal(getattr(one, name), value), name


@pytest.fixture
def scans():
    """The second one with origins of points, as scans have whose motion was undone."""
    found = [Scan(*(getattr(s, n) for n in vars(s))) for s in drive()[:3]]
    origins = np.linspace(0, 1, 3 * len(found[1].points), dtype=np.float32).reshape(-1, 3)
    found[1] = Scan(found[1].points, found[1].pose, origins, found[1].colors, found[1].intensities)
    return found


def test_a_folder_in_the_order_of_its_numbers(tmp_path, scans):
    folder = write_clouds(tmp_path / "clouds", scans)
    (tmp_path / "clouds" / "scan1.pcd").rename(tmp_path / "clouds" / "scan10.pcd")
    found, inputs = opened(folder)
    assert np.array_equal(found[1].points, scans[2].points)  # scan2 before scan10
    assert np.array_equal(found[2].points, scans[1].points)
    assert np.array_equal(found[2].pose, scans[2].pose)
    assert inputs.notes == ["%s: poses are those of %s/poses.txt" % (folder, folder)]


def test_scans_in_a_map_are_those_that_were_kept(tmp_path, scans):
    path = str(tmp_path / "map.h5")
    MapFile.write(path, Mesh(np.float32([[0, 0, 0], [1, 0, 0], [0, 1, 0]]), np.uint32([[0, 1, 2]])))
    with KeptScans(path) as kept:
        for scan in scans:
            kept.keep(scan)
        assert kept.put(path) == ["position_0000%d" % i for i in range(3)]
    assert [each.name for each in tmp_path.iterdir()] == ["map.h5"]
    found, _ = opened(path)
    assert_same(found, scans)
    assert [scan.time for scan in found] == [scans[0].time, None, scans[2].time]


def test_large_clouds_are_read_in_pieces(tmp_path, scans, monkeypatch):
    folder = write_clouds(tmp_path / "clouds", scans)
    monkeypatch.setattr(cloud_files, "SCAN_POINTS", 700)
    found, inputs = opened(folder)
    whole = np.concatenate([scan.points for scan in scans])
    assert np.array_equal(np.concatenate([scan.points for scan in found]), whole)
    assert max(len(scan.points) for scan in found) == 700
    after = list(inputs.sources[0].steps(start=4))
    assert [step.position for step in after] == list(range(5, len(found) + 1))
    assert_same([step.scan for step in after], found[4:])


@pytest.mark.parametrize("form", ["kitti", "tum"])
def test_poses_of_a_file(tmp_path, scans, form):
    folder = write_clouds(tmp_path / "clouds", scans, poses=False)
    poses = [ScanPose(scan.pose, 100.0 + i) for i, scan in enumerate(scans)]
    file = tmp_path / "poses.txt"
    file.write_text(pose_lines(poses, form))
    found, _ = opened(folder, poses=str(file))
    for one, other in zip(found, scans):
        np.testing.assert_allclose(one.pose, other.pose, atol=1e-12)
    file.write_text(pose_lines(poses[:2], form))
    with pytest.raises(MapFileError, match="2 poses for 3 clouds"):
        opened(folder, poses=str(file))
    file.write_text("")
    with pytest.raises(MapFileError, match="empty"):
        opened(folder, poses=str(file))


def test_clouds_named_by_their_time_are_between_poses(tmp_path, scans):
    folder = write_clouds(tmp_path / "clouds", scans, poses=False)
    for i, name in enumerate(("10.5", "11.25", "12.0")):
        (tmp_path / "clouds" / ("scan%d.pcd" % i)).rename(tmp_path / "clouds" / (name + ".pcd"))
    poses = []
    for time in range(10, 14):
        pose = np.eye(4)
        pose[0, 3] = 2.0 * time
        poses.append(ScanPose(pose, float(time)))
    file = tmp_path / "poses.txt"
    file.write_text(pose_lines(poses, "tum"))
    found, _ = opened(folder, poses=str(file))
    np.testing.assert_allclose([scan.pose[0, 3] for scan in found], [21.0, 22.5, 24.0])
    file.write_text(pose_lines(poses[:1] + poses[:1], "tum"))
    with pytest.raises(MapFileError, match="3 of 3 clouds by their names are not"):
        opened(folder, poses=str(file))


def test_clouds_without_poses_are_refused_or_seen_from_one_place(tmp_path, scans):
    folder = write_clouds(tmp_path / "clouds", scans, poses=False)
    with pytest.raises(MapFileError, match="nor have 2 others, so nobody says where the sensor"):
        opened(folder)
    found, _ = opened(folder, sensor=(1.0, 2.0, 3.0))
    np.testing.assert_allclose(found[0].in_map(), scans[0].points, atol=1e-6)
    assert found[0].origins_in_map().tolist() == [1.0, 2.0, 3.0]
    one, inputs = opened(tmp_path / "clouds" / "scan0.pcd")
    assert np.array_equal(one[0].pose, np.eye(4))
    assert "its sensor is taken to be at its 0, 0, 0" in inputs.notes[0]


def test_a_cloud_in_a_national_grid_needs_its_sensor(tmp_path):
    place = np.array([690_000.0, 5_330_000.0, 510.0])
    points = place + np.random.default_rng(0).uniform(-5, 5, (50, 3))
    lines = ["ply", "format ascii 1.0", "element vertex 50"]
    lines += ["property double %s" % name for name in "xyz"] + ["end_header"]
    lines += [" ".join(map(repr, row)) for row in points.tolist()]
    path = tmp_path / "cloud.ply"
    path.write_text("\n".join(lines) + "\n")
    with pytest.raises(MapFileError, match="where its sensor was not"):
        opened(path)
    found, _ = opened(path, sensor=place.tolist())
    placed = found[0].points.astype(np.float64) + found[0].pose[:3, 3]
    assert np.abs(placed - points).max() < 1e-6


def test_what_is_no_scan_is_refused_in_a_sentence(tmp_path, scans):
    for name, data, text in (
        ("a.txt", b"1 2 3\n", "it is no bag, no cloud"),
        ("a.bag", b"nothing", "it is no bag of ROS 1"),
        ("b.bag", b"#ROSBAG V2.0\n\x01", "rosbag cannot read it"),
        ("a.pcd", b"# .PCD v0.7\nVERSION 0.7\nFIELDS x y\n", "DATA"),
    ):
        (tmp_path / name).write_bytes(data)
        with pytest.raises(MapFileError, match=text):
            opened(tmp_path / name)
    with pytest.raises(MapFileError, match="there is no such file"):
        opened(tmp_path / "missing.ply")
    (tmp_path / "folder").mkdir()
    with pytest.raises(MapFileError, match="no file in this folder ends with"):
        opened(tmp_path / "folder")
    MapFile.write(tmp_path / "m.h5", Mesh(np.float32(np.eye(3)), np.uint32([[0, 1, 2]])))
    with pytest.raises(MapFileError, match="this map file has no scans"):
        opened(tmp_path / "m.h5")


def test_a_bad_file_among_many_costs_only_itself(tmp_path, scans):
    folder = write_clouds(tmp_path / "clouds", scans)
    (tmp_path / "clouds" / "scan1.pcd").write_bytes(b"# .PCD v0.7\nVERSION 0.7\n")
    left_out = LeftOutCounts()
    found, _ = opened(folder, left_out=left_out)
    assert_same(found, [scans[0], scans[2]])
    assert left_out.lines()[0].startswith("left out: 1 scan (%s/scan1.pcd) that cannot" % folder)


def test_clouds_that_end_in_the_middle(tmp_path, scans):
    text = "ply\nformat ascii 1.0\nelement vertex 9\nproperty float x\nproperty float y\n"
    (tmp_path / "a.ply").write_text(text + "property float z\nend_header\n1 2 3\n4 5 6\n7 8")
    with pytest.raises(MapFileError, match="point 2 has 2 numbers"):
        opened(tmp_path / "a.ply")
    folder = write_clouds(tmp_path / "clouds", scans)
    for name in ("scan0.pcd", "scan2.pcd"):
        data = (tmp_path / "clouds" / name).read_bytes()
        (tmp_path / "clouds" / name).write_bytes(data[: len(data) // 2])
    left_out = LeftOutCounts()
    found, _ = opened(folder, left_out=left_out)
    assert_same(found, scans[1:2])
    assert "2 scans (first: %s/scan0.pcd) that cannot be read" % folder in left_out.lines()[0]


def test_las_is_read_or_says_what_it_needs(tmp_path):
    path = str(tmp_path / "a.las")
    try:
        import laspy
    except ImportError:
        (tmp_path / "a.las").write_bytes(b"LASF")
        with pytest.raises(MapFileError, match="pip install 'laspy"):
            opened(path)
        return
    header = laspy.LasHeader(point_format=3, version="1.2")
    header.offsets, header.scales = [690_000, 5_330_000, 500], [0.001] * 3
    cloud = laspy.LasData(header)
    cloud.x = np.array([690_001.5, 690_002.0])
    cloud.y, cloud.z = np.full(2, 5_330_000.25), np.array([501.0, 502.0])
    cloud.red = np.uint16([65535, 0])
    cloud.intensity = np.uint16([7, 9])
    cloud.write(path)
    found, _ = opened(path, sensor=(690_000.0, 5_330_000.0, 500.0))
    assert found[0].points.tolist() == [[1.5, 0.25, 1.0], [2.0, 0.25, 2.0]]
    assert found[0].colors.tolist() == [[255, 0, 0], [0, 0, 0]]
    assert found[0].intensities.tolist() == [7.0, 9.0]


def test_bags_and_clouds_together(tmp_path, scans):
    folder = write_clouds(tmp_path / "clouds", scans)
    bag = write_bag(tmp_path / "a.bag", drive()[3:5])
    found, inputs = opened(folder, bag)
    assert len(found) == 5 and inputs.frame == "odom"
