"""mesh_tool reconstruct: the same map of the same scans, whatever they come in; stopped and gone
on; and what is refused."""

import json
import os
import signal
import subprocess
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from mesh_msgs.identity import geometry_uuid
from mesh_msgs_hdf5.formats.clouds.poses import ScanPose, pose_lines
from mesh_msgs_hdf5.map_file import MapFile
from mesh_msgs_hdf5.map_file.scans import scan_summaries
from mesh_msgs_hdf5.model.edit import Edit
from mesh_msgs_hdf5.model.errors import MapFileError
from mesh_msgs_hdf5.model.mesh import Label
from scan_bags import ODOM, drive, message_of, write_bag, write_clouds
from verb_calls import call, said

from mesh_map.commands import reconstruct
from mesh_map.reconstruction import pose_refinement
from mesh_map.reconstruction.options import FieldOptions
from mesh_map.reconstruction.pipeline import Reconstruction
from mesh_map.reconstruction.pose_refinement import refine_poses
from mesh_map.reconstruction.state_file import state_path

COARSE = ("--voxel_size", "0.3", "--min_component", "20")
ARRAYS = ("vertices", "faces", "vertex_normals", "vertex_colors")


def assert_same_map(path, other):
    one, two = MapFile(path).read(), MapFile(other).read()
    for name in ARRAYS:
        assert np.array_equal(getattr(one, name), getattr(two, name)), name
    for name in ("observations", "intensity"):
        assert np.array_equal(one.vertex_attributes[name], two.vertex_attributes[name]), name


@pytest.fixture(scope="module")
def world(tmp_path_factory):
    """A bag of the drive, the same in a folder of clouds, and a map of the bag with its scans."""
    folder = tmp_path_factory.mktemp("world")
    bag = write_bag(folder / "a.bag", drive())
    clouds = write_clouds(folder / "clouds", drive())
    path = str(folder / "map.h5")
    assert call("reconstruct", bag, path, *COARSE, "--with-scans", "--layers", "height_diff") == 0
    return {"bag": bag, "clouds": clouds, "map": path, "folder": folder}


@pytest.fixture
def halves(world, tmp_path):
    return [
        write_bag(tmp_path / "first.bag", drive()[:4]),
        write_bag(tmp_path / "second.bag", drive()[4:]),
    ]


def test_a_map_with_all_that_is_known(world):
    file = MapFile(world["map"])
    mesh = file.read()
    assert mesh.frame_id == ODOM and mesh.origin == (0.0, 0.0, 0.0)
    assert file.stored_uuid == geometry_uuid(mesh.vertices, mesh.faces)
    assert set(mesh.vertex_attributes) == {"observations", "intensity"}
    assert mesh.vertex_attributes["observations"].min() >= 0
    assert len(np.unique(mesh.vertex_colors, axis=0)) > 10
    assert list(mesh.vertex_costs) == ["height_diff"]
    source = mesh.source
    size = os.stat(world["bag"]).st_size
    assert source["made"] == "reconstruction" and source["complete"]
    assert source["parameters"]["voxel_size"] == 0.3 and source["left_out"] == {}
    (entry,) = source["inputs"]
    assert entry["path"] == world["bag"] and entry["bytes"] == size and entry["scans"] == 8
    assert len(entry["blake2b"]) == 32 and entry["points"] == source["points"] > 16_000
    # faces show their front to the sensors: the ground is seen from above
    a, b, c = mesh.vertices[mesh.faces].transpose(1, 0, 2)
    normals = np.cross(b - a, c - a)
    sensors = np.mean([scan.pose[:3, 3] for scan in drive()], axis=0)
    shown = np.einsum("ij,ij->i", normals, sensors - (a + b + c) / 3)
    assert shown[shown > 0].sum() > 50 * -shown[shown < 0].sum()


@pytest.mark.parametrize("what", ["clouds", "map"])
def test_the_same_scans_make_the_same_map(world, tmp_path, capsys, what):
    value = said(capsys, "reconstruct", world[what], tmp_path / "b.h5", *COARSE)
    assert value["scans"] == 8 and value["left_out"] == {}
    assert_same_map(world["map"], tmp_path / "b.h5")


def test_more_inputs_later_make_the_map_of_all_at_once(world, halves, tmp_path, capsys):
    path = str(tmp_path / "map.h5")
    value = said(capsys, "reconstruct", halves[0], path, *COARSE, "--with-scans")
    assert value["scans"] == 4
    value = said(capsys, "reconstruct", *halves, path, "--continue", "--with-scans")
    assert value["scans"] == 8 and "all of its scans are in the map" in " ".join(value["notes"])
    assert [entry["scans"] for entry in value["inputs"]] == [4, 4]
    assert_same_map(world["map"], path)
    said(capsys, "reconstruct", path, tmp_path / "of_scans.h5", *COARSE)
    assert_same_map(path, tmp_path / "of_scans.h5")
    # and once more, with nothing new: another surface of the same field
    said(capsys, "reconstruct", path, "--continue", "--fill_holes", "0")
    assert len(MapFile(path).read().faces) < len(MapFile(world["map"]).read().faces)


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_stopped_it_keeps_what_it_has_and_goes_on(world, tmp_path, capsys, monkeypatch, number):
    path, add = str(tmp_path / "map.h5"), Reconstruction.add

    def interrupted(self, scan):
        used = add(self, scan)
        if self.scans == 3:
            os.kill(os.getpid(), number)
            os.kill(os.getpid(), number)  # as mesh_tool passes Ctrl+C on: it counts once
        return used

    monkeypatch.setattr(Reconstruction, "add", interrupted)
    words = (world["bag"], path, *COARSE, "--layers", "height_diff")
    assert call("reconstruct", *words) == 128 + number
    found = capsys.readouterr()
    value = json.loads(found.out)
    assert value["scans"] == 3 and "stopped after 3 scans; --continue goes on" in found.err
    mesh = MapFile(path).read()
    assert len(mesh.faces) == value["faces"] > 0 and not mesh.source["complete"]
    assert not mesh.vertex_costs and any("no layers were computed" in n for n in value["notes"])
    monkeypatch.setattr(Reconstruction, "add", add)
    value = said(capsys, "reconstruct", path, "--continue")
    assert value["scans"] == 8
    assert_same_map(world["map"], path)


def test_going_on_needs_no_option_again(world, tmp_path, capsys, monkeypatch):
    """Poses, topics and so on of inputs are kept with them."""
    clouds = write_clouds(tmp_path / "clouds", drive(), poses=False)
    (tmp_path / "clouds" / "scan0.pcd").rename(tmp_path / "alone.pcd")
    lines = pose_lines([ScanPose(scan.pose) for scan in drive()], "kitti")
    (tmp_path / "p.txt").write_text(lines)
    path, add = str(tmp_path / "map.h5"), Reconstruction.add

    def interrupted(self, scan):
        os.kill(os.getpid(), signal.SIGINT)
        return add(self, scan)

    monkeypatch.setattr(Reconstruction, "add", interrupted)
    words = (tmp_path / "alone.pcd", clouds, path, *COARSE, "--poses", tmp_path / "p.txt")
    assert call("reconstruct", *words, "--frame", ODOM) == 130
    assert json.loads(capsys.readouterr().out)["scans"] == 1
    monkeypatch.setattr(Reconstruction, "add", add)
    bag = write_bag(tmp_path / "more.bag", drive()[:1])
    value = said(capsys, "reconstruct", bag, path, "--continue")
    assert [entry["scans"] for entry in value["inputs"]] == [1, 7, 1]
    assert value["frame_id"] == ODOM and value["inputs"][1]["options"]["poses"].endswith("p.txt")


def test_as_a_program(world, tmp_path):
    program = Path(__file__).resolve().parents[2] / "nodes" / "reconstruct"
    words = [str(program), world["bag"], *COARSE, str(tmp_path / "map.h5"), "--no-state", "--json"]
    done = subprocess.run(words, capture_output=True, text=True, timeout=120)
    assert done.returncode == 0 and done.stderr == ""
    assert json.loads(done.stdout)["output"] == str(tmp_path / "map.h5")
    assert_same_map(world["map"], tmp_path / "map.h5")
    assert [each.name for each in tmp_path.iterdir()] == ["map.h5"]


def test_parts_of_a_map_have_states_of_their_own(world, halves, tmp_path, capsys):
    path = str(tmp_path / "site.h5")
    for name, bag in zip(("floor1", "floor2"), halves):
        said(capsys, "reconstruct", bag, path, *COARSE, "--to-part", name)
    with pytest.raises(MapFileError, match="it has a part floor1 already"):
        call("reconstruct", halves[0], path, *COARSE, "--to-part", "floor1")
    second = MapFile(path, "floor2").read()
    value = said(capsys, "reconstruct", halves[1], path, "--continue", "--to-part", "floor1")
    assert value["scans"] == 8
    whole, mesh = MapFile(world["map"]).read(), MapFile(path, "floor1").read()
    assert np.array_equal(mesh.vertices, whole.vertices)
    assert np.array_equal(MapFile(path, "floor2").read().vertices, second.vertices)


def test_a_second_signal_ends_it(world, tmp_path, monkeypatch):
    def twice(self, scan):
        os.kill(os.getpid(), signal.SIGINT)
        monkeypatch.setattr("mesh_map.base.stop_signals._SAME", -1.0)
        os.kill(os.getpid(), signal.SIGINT)

    monkeypatch.setattr(Reconstruction, "add", twice)
    with pytest.raises(KeyboardInterrupt):
        call("reconstruct", world["bag"], tmp_path / "map.h5", *COARSE)
    assert list(tmp_path.iterdir()) == []


def test_the_memory_budget_stops_it_with_what_it_has(world, tmp_path, capsys):
    made = Reconstruction(FieldOptions(voxel_size=0.3))
    for scan in drive()[:5]:
        made.add(scan)
    path, words = str(tmp_path / "map.h5"), (*COARSE, "--memory", made.memory)
    assert call("reconstruct", world["bag"], path, *words) == reconstruct.LESS
    value = json.loads(capsys.readouterr().out)
    assert 0 < value["scans"] < 8 and len(MapFile(path).read().faces) == value["faces"]
    assert "more than its limit of" in value["notes"][-1]
    value = said(capsys, "reconstruct", path, "--continue")
    assert value["scans"] == 8 and value["points"] == MapFile(world["map"]).source["points"]


def test_a_range_that_is_wrong_does_not_take_all_memory(tmp_path, capsys):
    """A point 100 km away whose ray carves 10^9 voxels."""
    scans = [replace(scan, points=scan.points.copy()) for scan in drive()[:2]]
    scans[1].points[:50] = np.linspace(2e4, 1e5, 150).reshape(-1, 3)
    bag = write_bag(tmp_path / "far.bag", scans)
    path = tmp_path / "map.h5"
    code = call("reconstruct", bag, path, *COARSE, "--carve", "--memory", "64M")
    value = json.loads(capsys.readouterr().out)
    assert code in (0, reconstruct.LESS) and value["scans"] >= 1 and path.exists()
    value = said(capsys, "reconstruct", bag, tmp_path / "b.h5", *COARSE, "--max_range", "100")
    assert value["left_out"]["too_far"]["count"] == 50


def test_what_cannot_be_saved_is_refused_before_the_work(world, tmp_path, monkeypatch):
    def refused(text, *words):
        with pytest.raises(MapFileError, match=text):
            call("reconstruct", world["bag"], *words)

    monkeypatch.setattr(Reconstruction, "add", None)  # nothing is begun
    refused("the folder .* does not exist", tmp_path / "missing" / "map.h5")
    refused("the name of the output ends with", tmp_path / "map.ply")
    (tmp_path / "map.h5").write_bytes(Path(world["map"]).read_bytes())
    refused("the file exists already", tmp_path / "map.h5")
    refused("which would be lost", tmp_path / "map.h5", "--force")  # it has scans
    refused("there is no .*map.h5.reconstruction", tmp_path / "map.h5", "--continue")
    refused("there is no type of layers called heigt", tmp_path / "n.h5", "--layers", "heigt")
    with pytest.raises(MapFileError, match="it is an input and the output"):
        call("reconstruct", world["map"], world["map"], "--force")
    with pytest.raises(MapFileError, match="there is no input"):
        call("reconstruct", tmp_path / "n.h5")
    room = os.statvfs(tmp_path)
    full = os.statvfs_result((room[0], room[1], room[2], 10, 10, *room[5:]))
    monkeypatch.setattr(reconstruct.os, "statvfs", lambda _: full)
    refused("the disk has only", tmp_path / "n.h5")
    assert sorted(each.name for each in tmp_path.iterdir()) == ["map.h5"]


def test_a_disk_that_is_full_at_the_end_loses_nothing(world, tmp_path, capsys, monkeypatch):
    save, output = reconstruct.save_map, str(tmp_path / "map.h5")

    def full(arguments, mesh):
        if arguments.output == output:
            text = "cannot be saved, nothing was changed: No space left on device"
            raise MapFileError("save", output, text, "make room on the disk")
        return save(arguments, mesh)

    def no_state(path, *_):
        raise MapFileError("save", path, "cannot be saved, nothing was changed: No space left")

    monkeypatch.setattr(reconstruct, "save_map", full)
    monkeypatch.setattr(reconstruct, "save_state", no_state)
    monkeypatch.setattr(reconstruct.tempfile, "gettempdir", lambda: str(tmp_path))
    assert call("reconstruct", world["bag"], output, *COARSE) == reconstruct.LESS
    value = json.loads(capsys.readouterr().out)
    assert_same_map(value["output"], world["map"])
    assert "is saved as %s instead" % value["output"] in " ".join(value["notes"])
    assert "--continue cannot go on" in " ".join(value["notes"])


def test_going_on_refuses_what_does_not_fit(world, halves, tmp_path, capsys):
    path = str(tmp_path / "map.h5")
    said(capsys, "reconstruct", halves[0], path, *COARSE)

    def refused(text, *words):
        with pytest.raises(MapFileError, match=text):
            call("reconstruct", *words, path, "--continue")

    refused("--voxel_size is 0.1, but the map was begun with 0.3", "--voxel_size=0.1", halves[0])
    refused("the map is in frame odom, not map", "--frame=map", halves[0])
    write_bag(Path(halves[0]), drive()[:5])
    refused("is not the file of which 4 scans are in the map", halves[0])
    MapFile(path).update(Edit(labels={"tree_1": Label(np.uint32([0]))}))
    refused("it has 1 labels, which would be lost", halves[1])
    mesh = MapFile(path).read()
    mesh.source = {}
    MapFile.write(path, mesh, overwrite=True)
    refused("it was not made by this command", halves[1])
    state = Path(state_path(path))
    data = state.read_bytes()
    for damaged, text in (
        (data[:-1], "its bytes are not those that were written"),
        (data[:2000] + bytes([data[2000] ^ 1]) + data[2001:], "its bytes are not those"),
        (b"something", "it is no state of a reconstruction"),
    ):
        state.write_bytes(damaged)
        refused(text, "--force", halves[1])


def test_coordinates_of_a_national_grid(tmp_path, capsys):
    shift = np.array([690_000.0, 5_330_000.0, 500.0])
    poses = [ScanPose(scan.pose.copy()) for scan in drive()]
    for pose in poses:
        pose.matrix[:3, 3] += shift
    clouds = write_clouds(tmp_path / "clouds", drive(), poses=False)
    (tmp_path / "poses.txt").write_text(pose_lines(poses, "kitti"))
    more = ("--poses", tmp_path / "poses.txt", *COARSE)
    said(capsys, "reconstruct", clouds, tmp_path / "far.h5", *more, "--with-scans")
    far = MapFile(tmp_path / "far.h5").read()
    said(capsys, "reconstruct", tmp_path / "far.h5", tmp_path / "again.h5", *COARSE)
    again = MapFile(tmp_path / "again.h5").read()
    assert again.origin == far.origin and abs(len(again.vertices) - len(far.vertices)) < 10
    assert far.origin == tuple(np.rint(poses[0].matrix[:3, 3]))
    said(capsys, "reconstruct", clouds, tmp_path / "b.h5", *more, "--origin", "690000,5330000,500")
    other = MapFile(tmp_path / "b.h5").read()
    assert other.origin == tuple(shift)
    middles = [mesh.vertices.mean(axis=0, dtype=np.float64) + mesh.origin for mesh in (far, other)]
    np.testing.assert_allclose(*middles, atol=0.05)


def test_poses_that_jump_are_told(tmp_path, capsys):
    scans = list(drive())
    for i in range(4, 8):
        pose = scans[i].pose.copy()
        pose[0, 3] += 10.0
        scans[i] = replace(scans[i], pose=pose)
    bag = write_bag(tmp_path / "a.bag", scans)
    value = said(capsys, "reconstruct", bag, tmp_path / "map.h5", *COARSE)
    assert value["scans"] == 8
    assert any(
        note.startswith("the pose jumps 1 time, first to scan 5 of /points: 9.")
        for note in value["notes"]
    )


def test_points_left_out_are_said_and_the_share_kept(world, tmp_path, capsys):
    value = said(
        capsys,
        *("reconstruct", world["bag"], tmp_path / "map.h5", *COARSE, "--decimate", "4"),
        *("--min_range", "4", "--max_range", "8"),
    )
    total = sum(len(scan.points) for scan in drive())
    left = {kind: entry["count"] for kind, entry in value["left_out"].items()}
    assert value["points"] + sum(left.values()) == total
    assert left["decimated"] == total - sum(-(-len(scan.points) // 4) for scan in drive())
    assert left["too_near"] > 0 and left["too_far"] > 0


def test_nothing_that_can_be_used(tmp_path):
    empty = write_bag(
        tmp_path / "a.bag",
        drive()[:2],
        message=lambda scan: message_of(replace(scan, points=scan.points * np.float32(np.nan))),
    )
    with pytest.raises(MapFileError, match="no scan could be used: left out: .* not finite"):
        call("reconstruct", empty, tmp_path / "map.h5", *COARSE)
    assert [each.name for each in tmp_path.iterdir()] == ["a.bag"]


def test_sizes_of_memory():
    from mesh_map.reconstruction.memory import default_memory_limit, parsed_bytes

    assert parsed_bytes("500M") == 500 << 20 and parsed_bytes("1.5 GB") == 3 << 29
    assert parsed_bytes("1000000") == 1_000_000 and default_memory_limit() >= 256 << 20
    for text in ("", "4X", "0", "-1", "1..2"):
        with pytest.raises(ValueError):
            parsed_bytes(text)


def test_poses_that_drift_are_refined_on_request(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(pose_refinement, "_BETTER", 10.0)  # whether they are better or not
    given = [replace(scan, pose=np.array(scan.pose)) for scan in drive()]
    for scan, shift in zip(given, np.linspace(0, 1, 8)[:, None] * [0.09, -0.06, 0.06]):
        scan.pose[:3, 3] += shift
    clouds = write_clouds(tmp_path / "clouds", given)
    path = str(tmp_path / "map.h5")
    options = *COARSE, "--max_range", "12", "--with-scans", "--json"
    assert call("reconstruct", clouds, path, "--refine", *options) == 0
    value = json.loads(capsys.readouterr().out)
    expected = refine_poses(given, voxel_size=0.3, max_range=12)
    assert value["refined"] == MapFile(path).read().source["refined"] == expected.counts()
    assert value["scans"] == 8 and value["left_out"]["too_far"]["scans"] == 8
    for summary, pose, scan in zip(scan_summaries(path), expected.poses, given):
        np.testing.assert_allclose(summary["final_pose"], pose, atol=1e-6)
    assert np.abs(pose - scan.pose).max() > 0.01
    with pytest.raises(MapFileError, match="--refine needs all scans at once"):
        call("reconstruct", clouds, path, "--continue", "--refine")


def test_other_poses_are_other_scans(tmp_path):
    clouds = Path(write_clouds(tmp_path / "clouds", drive()))
    path = str(tmp_path / "map.h5")
    assert call("reconstruct", str(clouds), path, *COARSE) == 0
    moved = [replace(scan, pose=np.array(scan.pose)) for scan in drive()]
    for scan in moved:
        scan.pose[0, 3] += 1.0
    lines = pose_lines([ScanPose(scan.pose) for scan in moved], "kitti")
    (clouds / "poses.txt").write_text(lines)
    with pytest.raises(MapFileError, match="its bytes, or its poses, differ"):
        call("reconstruct", str(clouds), path, "--continue")


def test_points_next_to_the_sensor_are_no_returns(tmp_path, capsys):
    """As zeros that were moved into another frame and back."""
    scans = []
    for scan in drive():
        points = np.array(scan.points)
        points[::100] = 1e-6 * points[::100]
        scans.append(replace(scan, points=points))
    clouds, path = write_clouds(tmp_path / "clouds", scans), str(tmp_path / "map.h5")
    capsys.readouterr()
    assert call("reconstruct", clouds, path, *COARSE, "--json") == 0
    value = json.loads(capsys.readouterr().out)
    expected = sum(len(scan.points[::100]) for scan in scans)
    assert value["left_out"]["no_return"]["count"] == expected


def test_a_map_of_other_scans_is_not_replaced(halves, tmp_path):
    paths = [str(tmp_path / name) for name in ("one.h5", "two.h5")]
    for bag, path in zip(halves, paths):
        assert call("reconstruct", bag, path, *COARSE) == 0
    before = Path(paths[1]).read_bytes()
    os.replace(state_path(paths[0]), state_path(paths[1]))
    with pytest.raises(MapFileError, match="was not made by this command, or was changed since"):
        call("reconstruct", paths[1], "--continue")
    assert Path(paths[1]).read_bytes() == before


def test_parts_of_alike_names_have_states_of_their_own():
    assert state_path("map.h5", "a/b") != state_path("map.h5", "a_b")
    assert state_path("map.h5", "/mesh/") == "map.h5.mesh.reconstruction"
