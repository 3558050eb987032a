"""Scans with poses and images in a map file: in and out to the bit, and carried along."""
import hashlib
import json

import h5py
import numpy as np
import pytest
from peak_memory import peak_memory

from mesh_msgs_hdf5.commands.mesh_tool import main
from mesh_msgs_hdf5.formats.base.images import png
from mesh_msgs_hdf5.formats.clouds import cloud as cloud_module
from mesh_msgs_hdf5.map_file import MapFile, scan_extraction, scans
from mesh_msgs_hdf5.map_file.convert import convert, repack
from mesh_msgs_hdf5.map_file.part_changes import copy_part, put_part
from mesh_msgs_hdf5.map_file.scans import ScanFile
from mesh_msgs_hdf5.model.edit import Edit
from mesh_msgs_hdf5.model.errors import MapFileError
from mesh_msgs_hdf5.model.mesh import Label
from mesh_msgs_hdf5.validation.validate import validate

FIELDS = [("x", "<f4"), ("y", "<f4"), ("z", "<f4"), ("intensity", "<f4"), ("ring", "<u2")]
FIELDS += [("t", "<f8"), ("nx", "<f4"), ("ny", "<f4"), ("nz", "<f4"), ("id", "<u8")]
FIELDS += [("fpfh", "<f4", (5,)), ("red", "u1"), ("green", "u1"), ("blue", "u1")]
MATRIX = np.array([[0, -1, 0, 5], [1, 0, 0, 6], [0, 0, 1, 7], [0, 0, 0, 1.0]])
PICTURE = png(np.random.default_rng(1).integers(0, 256, (4, 5, 3)).astype(np.uint8))
PHOTO = b"\xff\xd8\xff" + bytes(range(256)) * 3


def table(count=1000, fields=tuple(FIELDS)):
    points = np.zeros(count, list(fields))
    rng = np.random.default_rng(count)
    for name in points.dtype.names:
        raw = rng.integers(0, 256, points[name].nbytes).astype(np.uint8)
        points[name] = raw.view(points.dtype[name].base).reshape(points[name].shape)
    for axis in "xyz":
        points[axis] = rng.normal(size=count)
    return points


def write_pcd(path, points):
    with open(path, "wb") as stream:
        scan_extraction.write_pcd_cloud(path, stream, len(points), points.dtype, iter([points]))
    return str(path)


@pytest.fixture(autouse=True)
def small_blocks(monkeypatch):
    for module in (cloud_module, scans, scan_extraction):
        monkeypatch.setattr(module, "BLOCK_ROWS", 300)


@pytest.fixture
def file(tmp_path, rich_data):
    """Two scans, the first with two images."""
    path = tmp_path / "m.h5"
    path.write_bytes(rich_data)
    (tmp_path / "poses.txt").write_text("12.5 5 6 7 0 0 %r %r\n" % ((np.sqrt(0.5),) * 2))
    images = [tmp_path / "a.png", tmp_path / "b.jpg"]
    for image, data in zip(images, (PICTURE, PHOTO)):
        image.write_bytes(data)
    found = ScanFile(path)
    cloud = write_pcd(tmp_path / "a.pcd", table())
    more = dict(images=[str(image) for image in images], intrinsics=[500, 501, 4, 5])
    assert found.add([cloud], poses=str(tmp_path / "poses.txt"), **more) == ["position_00000"]
    assert found.add([write_pcd(tmp_path / "b.pcd", table(7))]) == ["position_00001"]
    return found


def content(path, group):
    """Every array and attribute in a group, to the bit."""
    found = {}
    with h5py.File(path, "r") as raw:

        def visit(name, item):
            what = [(key, np.asarray(value).tobytes()) for key, value in item.attrs.items()]
            if isinstance(item, h5py.Dataset):
                what += [str(item.dtype), item.shape, hashlib.md5(item[()].tobytes()).hexdigest()]
            found[name] = what

        raw[group].visititems(visit)
    return found


def test_what_goes_in_is_there_in_lvr2s_groups(file, rich_mesh):
    points = table()
    assert file.names() == ["position_00000", "position_00001"]
    summary = file.summary("position_00000")
    assert summary["points"] == 1000 and summary["time"] == 12.5 and summary["problem"] == ""
    assert summary["channels"] == {
        "points": "float32 x 3",
        "colors": "uint8 x 3",
        "fpfh": "float32 x 5",
        "id": "uint64",
        "intensity": "float32",
        "normals": "float32 x 3",
        "ring": "uint16",
        "t": "float64",
    }
    assert np.allclose(summary["final_pose"], MATRIX, atol=1e-12)
    for channel, fields in (("points", "xyz"), ("normals", ("nx", "ny", "nz")), ("t", "t")):
        wanted = np.stack([points[field] for field in fields], axis=1)
        assert file.channel("position_00000", channel).tobytes() == wanted.tobytes()
    assert (
        file.channel("position_00000", "id", 10, 12)[:, 0].tolist() == points["id"][10:12].tolist()
    )
    images = summary["images"]
    assert [image["name"] for image in images] == ["photo_00000", "photo_00001"]
    assert images[0]["intrinsics"].tolist() == [[500, 0, 4], [0, 501, 5], [0, 0, 1]]
    assert [file.image("position_00000", i["name"]) for i in images] == [PICTURE, PHOTO]
    with h5py.File(file.path, "r") as raw:
        group = raw["raw/scans/position_00000"]
        assert (group.attrs["IO"], group.attrs["CLASS"]) == ("ScanIO", "Scan")
        assert np.allclose(group["finalPose"][()], MATRIX.T)  # column after column
        box = np.stack([[f(points[a]) for a in "xyz"] for f in (np.min, np.max)])
        assert np.array_equal(group["boundingBox"][()], box)
    mesh = MapFile(file.path).read()
    assert np.array_equal(mesh.vertices, rich_mesh.vertices) and len(mesh.labels) == 9


@pytest.mark.parametrize("form", ["pcd", "ply"])
def test_what_comes_out_goes_in_again_to_the_bit(file, tmp_path, form):
    if form == "ply":
        with pytest.raises(MapFileError, match="uint64") as refused:
            scan_extraction.extract_scans(file.path, str(tmp_path / "no"), form=form)
        assert refused.value.hint == "--format pcd"
        with h5py.File(file.path, "r+") as raw:
            for name in file.names():
                del raw["raw/scans/%s/id" % name]
                del raw["raw/scans/%s/fpfh" % name]
    folder = tmp_path / "out"
    written = scan_extraction.extract_scans(file.path, str(folder), (), form)["files"]
    names = ["position_0000%d.%s" % (i, form) for i in (0, 1)] + ["poses.txt"]
    images = ["position_00000_photo_00000.png", "position_00000_photo_00001.jpg"]
    assert sorted(p.name for p in folder.iterdir()) == sorted(names + images)
    assert sorted(written) == sorted(str(p) for p in folder.iterdir())
    assert [(folder / image).read_bytes() for image in images] == [PICTURE, PHOTO]
    with pytest.raises(MapFileError) as refused:
        scan_extraction.extract_scans(file.path, str(folder), (), form)
    assert refused.value.code == "exists"
    clouds = [str(folder / name) for name in names[:2]]
    assert file.add(clouds, poses=str(folder / "poses.txt")) == ["position_00002", "position_00003"]
    for one, other in ((0, 2), (1, 3)):
        before, after = (content(file.path, "raw/scans/position_0000%d" % i) for i in (one, other))
        after = {k: v for k, v in after.items() if k not in ("initialPose", "finalPose")}
        for name in set(after) - {"timestamps"}:
            assert after[name] == before[name], name
        poses = [file.summary("position_0000%d" % i)["final_pose"] for i in (one, other)]
        assert np.allclose(*poses, atol=1e-12)


def label_edit(path, target):
    MapFile(path).update(Edit(labels={"tree_9": Label(np.uint32([1]))}))
    return path


def layer_edit(path, target):
    MapFile(path).update(Edit(vertex_costs={"new": np.ones(40, np.float32)}))
    return path


def other_part(path, target):
    put_part(path, MapFile(path).read(), "floor2")
    return path


def copied_part(path, target):
    copy_part(path, "mesh", path, "floor3")
    return path


def converted(path, target):
    convert(path, target, profile="lvr2")
    return target


def repacked(path, target):
    repack(path, target, "none")
    return target


CHANGES = [label_edit, layer_edit, other_part, copied_part, converted, repacked]


@pytest.mark.parametrize("change", CHANGES, ids=lambda change: change.__name__)
def test_all_else_carries_them_along_as_they_are_stored(file, tmp_path, change):
    before = content(file.path, "raw")
    assert len(before) > 20
    assert content(change(file.path, str(tmp_path / "new.h5")), "raw") == before


def test_deleted_scans_are_gone_and_nothing_else(file):
    mesh, second = content(file.path, "mesh"), content(file.path, "raw/scans/position_00001")
    file.delete(["position_00000"])
    assert file.names() == ["position_00001"] and content(file.path, "mesh") == mesh
    assert content(file.path, "raw/scans/position_00001") == second
    assert content(file.path, "raw/photos") == {}
    with pytest.raises(MapFileError, match="no scan 'position_00000'") as refused:
        file.delete(["position_00000"])
    assert refused.value.code == "scan" and "position_00001" in refused.value.hint


def test_no_points_are_read_that_nobody_asked_for(file, monkeypatch):
    read = []
    original = h5py.Dataset.__getitem__

    def noted(self, key):
        read.append(self.name)
        return original(self, key)

    monkeypatch.setattr(h5py.Dataset, "__getitem__", noted)
    scans.scan_summaries(file.path)
    MapFile(file.path).read()
    assert not [
        name for name in read if "/raw/scans" in name and "Pose" not in name and "time" not in name
    ]


def test_scans_of_lvr2(tmp_path, full_data):
    """As its tools of 2018 to 2020 wrote them; a matrix by rows, as others write it, too."""
    (tmp_path / "m.h5").write_bytes(full_data)
    with h5py.File(tmp_path / "m.h5", "r+") as raw:
        for name, pose, keys in (
            ("position_00001", MATRIX.T, ("initialPose", "finalPose")),
            ("position_00002", MATRIX, ("poseEstimation", "registration")),
        ):
            group = raw.create_group("raw/scans/" + name)
            group["points"] = np.zeros((4, 3), np.float32)
            group["fov"], group["resolution"] = np.float32([1, 2]), np.float32([3, 4])
            for key in keys:
                group[key] = pose.astype(np.float32)
        raw["raw/photos/position_00001/photo_00000/image"] = np.zeros((2, 3, 3), np.uint8)
        raw["raw/scans/preview"] = 1
    found = scans.scan_summaries(tmp_path / "m.h5")
    assert [entry["name"] for entry in found] == ["position_00001", "position_00002"]
    assert all(np.array_equal(entry["final_pose"], MATRIX) for entry in found)
    assert found[0]["channels"] == {"points": "float32 x 3"}
    pixels = ScanFile(tmp_path / "m.h5").image("position_00001", "photo_00000")
    assert pixels == png(np.zeros((2, 3, 3), np.uint8))
    assert scans.check_scans(tmp_path / "m.h5") == []


def spoil(place, values):
    def change(raw):
        if place in raw:
            del raw[place]
        if values is not None:
            raw[place] = values

    return change


FIRST = "raw/scans/position_00000/"
NAN = np.zeros((1000, 3), np.float32)
NAN[[5, 9], 1] = np.nan


@pytest.mark.parametrize(
    "change,level,code",
    [
        (spoil(FIRST + "points", None), "error", "scan"),
        (spoil(FIRST + "points", np.zeros((9, 2), np.float32)), "error", "shape"),
        (spoil(FIRST + "points", NAN), "note", "not_finite"),
        (spoil(FIRST + "finalPose", np.zeros((4, 4))), "error", "value"),
        (spoil(FIRST + "finalPose", np.zeros((3, 4))), "error", "shape"),
        (spoil(FIRST + "points", h5py.SoftLink("/mesh/channels/vertices")), "error", "link"),
        (spoil("raw/photos/position_00000/photo_00000/image", np.uint8([1, 2])), "error", "format"),
        (spoil("raw/photos/position_00000/photo_00000/intrinsics", np.eye(2)), "error", "shape"),
    ],
)
def test_bad_scans_are_findings_and_the_map_is_read(file, change, level, code):
    with h5py.File(file.path, "r+") as raw:
        change(raw)
    (finding,) = [f for f in validate(file.path) if f.where.startswith("scan ")]
    assert (finding.level, finding.rule, finding.where) == (level, code, "scan position_00000")
    assert len(MapFile(file.path).read().labels) == 9
    entries = scans.scan_summaries(file.path)
    assert len(entries) == 2 and entries[1]["problem"] == ""


@pytest.mark.parametrize(
    "more,words",
    [
        (dict(clouds=["a.pcd", "b.pcd"], poses="poses.txt"), "1 poses for 2 clouds"),
        (dict(clouds=["a.png"]), "neither a PLY nor a PCD"),
        (dict(clouds=["a.pcd"], images=["a.pcd"]), "neither a PNG nor a JPEG"),
        (dict(clouds=["a.pcd", "b.pcd"], images=["a.png"]), "1 images for 2 scans"),
        (dict(clouds=[]), "0 images for 0 scans"),
        (dict(clouds=[], images=["a.png"], scan="position_9"), "there is no scan 'position_9'"),
        (dict(clouds=["a.pcd"], intrinsics=[1, 2, 3]), "fx, fy, cx and cy"),
        (dict(clouds=["cut.pcd"]), "fewer bytes"),
        (dict(clouds=["gone.pcd"]), "no such file"),
    ],
)
def test_what_cannot_be_added_changes_nothing(file, tmp_path, monkeypatch, more, words):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "cut.pcd").write_bytes((tmp_path / "a.pcd").read_bytes()[:-1])
    before = (tmp_path / "m.h5").read_bytes()
    with pytest.raises(MapFileError, match=words) as refused:
        file.add(more.pop("clouds"), **more)
    assert "\n" not in str(refused.value)
    assert (tmp_path / "m.h5").read_bytes() == before
    assert not [p for p in tmp_path.iterdir() if p.name.startswith(".")]


def test_images_of_a_scan_that_is_there(file, tmp_path):
    file.add([], images=[str(tmp_path / "b.jpg")], scan="position_00000")
    file.add([], images=[str(tmp_path / "a.png")], scan="position_00001")
    assert [len(file.summary(name)["images"]) for name in file.names()] == [3, 1]
    assert file.image("position_00000", "photo_00002") == PHOTO


def test_a_large_cloud_takes_little_memory(tmp_path, full_data, monkeypatch):
    for module in (cloud_module, scans, scan_extraction):
        monkeypatch.setattr(module, "BLOCK_ROWS", 1 << 15)
    monkeypatch.setattr("mesh_msgs_hdf5.map_file.writing.map_saving.MEMORY_BUDGET", 0)
    (tmp_path / "m.h5").write_bytes(full_data)
    points = np.zeros(3_000_000, FIELDS[:5])  # 54 MB
    points["x"] = np.arange(len(points))
    cloud = write_pcd(tmp_path / "a.pcd", points)
    del points
    file = ScanFile(tmp_path / "m.h5")
    with peak_memory() as growth:
        file.add([cloud])
        scan_extraction.extract_scans(file.path, str(tmp_path / "out"))
        assert growth() < 25_000
    assert file.channel("position_00000", "points", 2_999_999)[0].tolist() == [2_999_999, 0, 0]


def test_the_verb(file, tmp_path, capsys):
    def run(*words):
        code = main([str(word) for word in words])
        return (code, *capsys.readouterr())

    path = file.path
    code, out, err = run("scans", path)
    assert (code, err) == (0, "") and out.splitlines() == [
        "position_00000: 1000 points with colors, fpfh, id, intensity, normals, ring, t, "
        "at 5 6 7 m, time 12.5 s, 2 images",
        "position_00001: 7 points with colors, fpfh, id, intensity, normals, ring, t, at 0 0 0 m",
    ]
    assert len(json.loads(run("scans", "list", path, "--json")[1])["scans"]) == 2
    assert "  scans      2 with 1007 points and 2 images\n" in run("info", path)[1]
    summary = json.loads(run("info", path, "--json")[1])["scans"]
    assert summary == {"count": 2, "points": 1007, "images": 2}
    words = ("scans", "add", path, tmp_path / "a.pcd", "--image", tmp_path / "a.png")
    assert (
        run(*words, "--intrinsics", "1,2,3,4")[1] == path + ": added scan position_00002: 1 image\n"
    )
    folder = tmp_path / "x/y"
    assert run("scans", "extract", path, folder, "position_00002")[0] == 0
    assert len(list(folder.iterdir())) == 3
    assert run("scans", "delete", path, "position_00002", "position_00000")[0] == 0
    assert file.names() == ["position_00001"]
    code, out, err = run("scans", "delete", path, "position_7")
    assert code == 1 and err.count("\n") == 1 and "there is no scan 'position_7'" in err


@pytest.mark.parametrize("numbers", ["1,2,x,4", "1,2,3", ""])
def test_numbers_of_a_camera_that_are_none(file, capsys, numbers):
    with pytest.raises(SystemExit) as ended:
        main(["scans", "add", file.path, "a.pcd", "--intrinsics", numbers])
    assert ended.value.code == 2
    assert "invalid four numbers fx,fy,cx,cy value" in capsys.readouterr().err


def lacking(file, *names):
    """Without these arrays of the scans."""
    with h5py.File(file.path, "r+") as raw:
        for name in names:
            del raw["raw/scans/" + name]


def test_no_time_and_no_pose_is_invented(file, tmp_path, capsys):
    folder = tmp_path / "out"
    words = ["scans", "extract", file.path, str(folder)]
    assert main([*words, "--poses", "tum"]) == 1
    text = "1 of 2 scans have no time, which TUM's format wants: position_00001"
    assert text in capsys.readouterr().err and not folder.exists()
    assert main([*words, "position_00000", "--poses", "tum"]) == 0
    assert (folder / "poses.txt").read_text().startswith("12.5 5.0 6.0 7.0 ")
    lacking(file, "position_00000/finalPose", "position_00000/initialPose")
    assert main([*words, "--force"]) == 1
    err = capsys.readouterr().err
    assert "1 of 2 scans have no pose: position_00000" in err and "--poses none" in err
    assert main([*words[:3], str(tmp_path / "clouds"), "--poses", "none", "-q"]) == 0
    names = {p.name for p in (tmp_path / "clouds").iterdir()}
    assert {"position_00000.pcd", "position_00001.pcd"} < names and "poses.txt" not in names
    lacking(file, "position_00001/finalPose", "position_00001/initialPose")
    assert main([*words[:3], str(tmp_path / "none")]) == 0
    out = capsys.readouterr().out
    assert "note: no scan has a pose: there is no poses.txt (position_00000, position_00001)" in out
    assert not (tmp_path / "none" / "poses.txt").exists()


def test_scans_that_cannot_be_read_are_named_and_the_others_written(file, tmp_path, capsys):
    file.add([str(tmp_path / "b.pcd")])
    with h5py.File(file.path, "r+") as raw:
        raw["raw/scans/position_00000/finalPose"][0, 0] = np.nan
        points = raw["raw/scans/position_00002/points"]
        place = points.id.get_chunk_info(0)
    with open(file.path, "r+b") as raw:  # bytes that are no deflate
        raw.seek(place.byte_offset)
        raw.write(b"\xff" * place.size)
    folder = tmp_path / "out"
    assert main(["scans", "extract", file.path, str(folder)]) == 1
    out, err = capsys.readouterr()
    assert out == "%s: wrote 2 files into %s\n" % (file.path, folder)
    lines = err.splitlines()
    assert len(lines) == 2 and all(line.startswith("mesh_tool: error: ") for line in lines)
    assert "left out: position_00000: the pose of" in lines[0]
    assert "left out: position_00002: " in lines[1]
    assert sorted(p.name for p in folder.iterdir()) == ["poses.txt", "position_00001.pcd"]
    assert len((folder / "poses.txt").read_text().splitlines()) == 1


def test_one_named_twice_is_one(file, tmp_path, capsys):
    twice = ["position_00001"] * 2
    assert main(["scans", "extract", file.path, str(tmp_path / "out"), *twice]) == 0
    assert len((tmp_path / "out" / "poses.txt").read_text().splitlines()) == 1
    capsys.readouterr()
    assert main(["scans", "delete", file.path, *twice]) == 0
    assert capsys.readouterr().out.endswith(": deleted scan position_00001\n")
    assert file.names() == ["position_00000"]


def test_groups_beside_scans_are_named(file, capsys):
    with h5py.File(file.path, "r+") as raw:
        raw["raw/scans/scan_1/points"] = np.ones((3, 3), np.float32)
        raw["raw/scans/preview"] = 1
    assert main(["scans", file.path]) == 0
    (note,) = [line for line in capsys.readouterr().out.splitlines() if "note" in line]
    assert "1 groups below /raw/scans are no scans" in note and note.endswith(": scan_1")
    (finding,) = [f for f in validate(file.path) if f.where.startswith("scan")]
    assert (finding.rule, finding.level, finding.count) == ("scan_name", "note", 1)


def as_pcd(points, says, form="ascii", viewpoint="0 0 0 1 0 0 0"):
    head = "VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH %d\nHEIGHT 1\n"
    head = (head + "VIEWPOINT %s\nPOINTS %d\nDATA %s\n") % (says, viewpoint, says, form)
    rows = np.arange(3.0 * points, dtype=np.float32).reshape(-1, 3)
    text = "".join("%g %g %g\n" % tuple(row) for row in rows).encode()
    return head.encode() + (rows.tobytes() if form == "binary" else text)


@pytest.mark.parametrize("form", ["ascii", "binary"])
def test_more_points_than_the_file_says_are_told(file, tmp_path, form, capsys):
    (tmp_path / "long.pcd").write_bytes(as_pcd(2000, 1000, form))
    assert main(["scans", "add", file.path, str(tmp_path / "long.pcd")]) == 1
    text = "long.pcd: it has 2000 points, but its line POINTS says 1000 (correct that line)"
    assert text in capsys.readouterr().err and len(file.names()) == 2
    (tmp_path / "right.pcd").write_bytes(as_pcd(1000, 1000, form) + b"\n")
    assert main(["scans", "add", file.path, str(tmp_path / "right.pcd")]) == 0


def test_a_viewpoint_is_the_pose_where_no_other_is_given(file, tmp_path, capsys):
    (tmp_path / "v.pcd").write_bytes(as_pcd(3, 3, viewpoint="5 6 7 0.70710678 0 0 0.70710678"))
    (tmp_path / "odd.pcd").write_bytes(as_pcd(3, 3, viewpoint="0 0 0 0 0 0 0"))
    (tmp_path / "one.txt").write_text("1 0 0 9 0 1 0 8 0 0 1 7\n")
    words = ["scans", "add", file.path]
    assert main([*words, str(tmp_path / "v.pcd")]) == 0
    assert "v.pcd is at its VIEWPOINT, 5 6 7 m" in capsys.readouterr().out
    assert np.allclose(file.summary("position_00002")["final_pose"], MATRIX, atol=1e-7)
    assert main([*words, str(tmp_path / "odd.pcd")]) == 0
    assert "is no place and rotation" in capsys.readouterr().out
    assert np.array_equal(file.summary("position_00003")["final_pose"], np.eye(4))
    poses = ["--poses", str(tmp_path / "one.txt")]
    assert main([*words, str(tmp_path / "v.pcd"), *poses]) == 0
    assert "not the VIEWPOINT of 1 PCD files" in capsys.readouterr().out
    assert file.summary("position_00004")["final_pose"][:3, 3].tolist() == [9, 8, 7]


def test_scans_and_a_mesh_of_their_name(file, tmp_path, capsys):
    """Neither takes the other's place, whichever was there first."""
    path, other = file.path, str(tmp_path / "other.h5")
    MapFile.write(other, MapFile(path).read())
    with h5py.File(other, "r+") as raw:  # as programs before allowed it
        raw.move("mesh", "raw")
    capsys.readouterr()
    assert main(["scans", "add", other, str(tmp_path / "b.pcd")]) == 1
    err = capsys.readouterr().err
    assert "part raw of it, a mesh" in err and "parts rename FILE raw NEW" in err
    assert main(["parts", "rename", other, "raw", "hall"]) == 0
    for words in (
        ["parts", "add", other, "raw", path],
        ["parts", "rename", other, "hall", "raw"],
        ["parts", "copy", other, "hall", "raw/scans"],
        ["parts", "copy", other, "hall", "x/channels"],
        ["import", path, str(tmp_path / "new.h5"), "--to-part", "raw"],
    ):
        assert main(words) == 1, words
        assert "the file keeps this name for" in capsys.readouterr().err
    assert main(["scans", "add", other, str(tmp_path / "b.pcd"), "-q"]) == 0
    assert MapFile(other).parts == ["hall"] and not (tmp_path / "new.h5").exists()
