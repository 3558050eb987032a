"""The command mesh_tool: export, convert, repack, diff, validate and render."""
import json
import os

import h5py
import matplotlib.image
import numpy as np
import pytest
from released_readers import map3d_of_ros2
from map_samples import assert_same_mesh, write_s0, write_s2
from mesh_msgs import zoo

from mesh_msgs_hdf5.commands.mesh_tool import main
from mesh_msgs_hdf5.map_file import MapFile
from mesh_msgs_hdf5.model.mesh import Label, Materials, Mesh
from mesh_msgs_hdf5.processes.zygote import ZYGOTE
from mesh_msgs_hdf5.validation.findings import RULES

REAL = ["botanical_garden_gazebo.ply", "tray.ply"]


@pytest.fixture
def grid(tmp_path):
    mesh = zoo.grid(4)
    mesh = Mesh(mesh.vertices, mesh.faces, vertex_costs={"x": mesh.vertices[:, 0].copy()})
    mesh.labels = {"a_1": Label(np.uint32([1, 2]))}
    MapFile.write(tmp_path / "grid.h5", mesh)
    return tmp_path / "grid.h5"


def run(capsys, *arguments):
    """(exit code, output, errors)"""
    code = main([str(argument) for argument in arguments])
    return (code, *capsys.readouterr())


@pytest.mark.parametrize("suffix", ["ply", "obj", "stl", "glb"])
@pytest.mark.parametrize("name", REAL)
def test_real_meshes_there_and_back(real_mesh, tmp_path, capsys, name, suffix):
    source, first, second = real_mesh(name), tmp_path / "a.h5", tmp_path / "b.h5"
    out = tmp_path / ("a." + suffix)
    assert run(capsys, "import", source, first, "--frame", "odom")[0] == 0
    assert run(capsys, "diff", source, first, "--ignore", "frame")[:2] == (0, "")
    code, said, _ = run(capsys, "export", first, out, "--json")
    assert code == 0 and json.loads(said)["file_bytes"] == out.stat().st_size
    assert run(capsys, "import", out, second)[0] == 0
    code, said, _ = run(capsys, "diff", first, second, "--json", "--ignore", "source")
    differences = {d["member"]: d for d in json.loads(said)["differences"]}
    if suffix == "stl":  # places only
        assert differences["triangles"]["kind"] == "same"
        return
    assert not {"vertices", "faces", "triangles"} & set(differences)
    if suffix in ("ply", "glb"):
        assert (code, differences) in ((0, {}), (1, {"frame_id": differences.get("frame_id")}))


@pytest.mark.parametrize("name", REAL)
def test_every_other_verb_on_real_meshes(real_mesh, tmp_path, capsys, name):
    source, path = real_mesh(name), tmp_path / "a.h5"
    assert run(capsys, "import", source, path, "--origin", "auto", "--crs", "EPSG:25832")[0] == 0
    code, said, _ = run(capsys, "validate", path, source, "--json")
    assert code == 0 and json.loads(said)["valid"]
    rules = [{f["rule"] for f in file["findings"]} for file in json.loads(said)["files"]]
    assert ("components" in rules[0]) == name.startswith("botanical") and "boundary" in rules[1]
    assert run(capsys, "validate", path, "--strict", "-q") == (
        int("components" in rules[0]),
        "",
        "",
    )
    for arguments in (["convert", path, tmp_path / "l.h5", "--for", "lvr2"], ["repack", path]):
        assert run(capsys, *arguments)[0] == 0
    assert run(capsys, "repack", path, tmp_path / "raw.h5", "--compression", "none")[0] == 0
    for other in ("l.h5", "raw.h5"):
        assert run(capsys, "diff", path, tmp_path / other)[:2] == (0, "")
    assert run(capsys, "render", path, tmp_path / "a.png", "--view", "iso")[0] == 0
    assert run(capsys, "info", path)[0] == 0
    assert run(capsys, "layers", path)[0] == 0 and run(capsys, "labels", path)[0] == 0


def test_export_and_convert_keep_everything(rich_mesh, tmp_path, capsys):
    path = tmp_path / "a.h5"
    MapFile.write(path, rich_mesh)
    code, said, _ = run(capsys, "export", path, tmp_path / "a.stl")
    assert code == 0 and said.count("note: ") > 3 and "layers" in said
    assert run(capsys, "export", path, tmp_path / "a.ply", "--layer", "height_diff", "-q")[1] == ""
    code, _, err = run(capsys, "export", path, tmp_path / "b.ply", "--layer", "slope")
    assert code == 1 and "slope" in err and not (tmp_path / "b.ply").exists()
    for name, write in (("s0", write_s0), ("s2", write_s2)):
        old, new = tmp_path / (name + ".h5"), tmp_path / (name + "_new.h5")
        mesh = write(old, rich_mesh)
        with h5py.File(old, "r+") as file:
            file["raw/scans"] = np.arange(9)
        assert run(capsys, "convert", old, new)[0] == 0
        found = MapFile(new).read()
        assert np.array_equal(found.vertices, mesh.vertices) and set(found.labels) == set(
            mesh.labels
        )
        assert run(capsys, "diff", old, new, "--ignore", "other")[:2] == (0, "")
        with h5py.File(new, "r") as file:
            assert file["raw/scans"][()].tolist() == list(range(9))


def test_to_ros2_and_back_by_convert_and_by_import(rich_mesh, tmp_path, capsys):
    path, ros2 = tmp_path / "a.h5", tmp_path / "ros2.h5"
    MapFile.write(path, rich_mesh)
    code, said, _ = run(capsys, "convert", path, ros2, "--for", "ros2", "--json")
    assert code == 0 and json.loads(said)["notes"] == []
    assert np.array_equal(map3d_of_ros2(ros2)[0], rich_mesh.vertices)
    for verb in ("convert", "import"):
        back = tmp_path / (verb + ".h5")
        assert run(capsys, verb, ros2, back)[0] == 0
        assert run(capsys, "diff", path, back, "--ignore", "source")[:2] == (0, "")
    assert run(capsys, "diff", path, ros2)[:2] == (0, "")


def test_repack_in_place_and_elsewhere(rich_mesh, tmp_path, capsys):
    path = tmp_path / "a.h5"
    MapFile.write(path, rich_mesh)
    for name in ("junk", "behind"):
        with h5py.File(path, "r+") as file:
            file[name] = np.random.default_rng(0).random(10000)
    with h5py.File(path, "r+") as file:  # leaves a gap
        del file["junk"]
    before = path.stat().st_size
    code, said, _ = run(capsys, "repack", path, "--json")
    found = json.loads(said)
    assert code == 0 and found["bytes_before"] == before
    assert found["file_bytes"] == path.stat().st_size < before - 50000
    assert_same_mesh(MapFile(path).read(), rich_mesh)
    world = zoo.outdoor_world(5000)
    mesh = Mesh(world.vertices, world.faces, vertex_colors=world.colors)
    MapFile.write(path, mesh)
    for word in ("none", "gzip"):
        other = tmp_path / (word + ".h5")
        assert run(capsys, "repack", path, other, "--compression", word)[0] == 0
        assert_same_mesh(MapFile(other).read(), mesh)
        with h5py.File(other, "r") as file:
            assert (file["mesh/channels/vertices"].chunks is None) == (word == "none")
        assert run(capsys, "repack", path, other)[0] == 1


def test_diff_has_the_exit_codes_of_diff(grid, tmp_path, capsys):
    other = tmp_path / "other.h5"
    mesh = MapFile(grid).read()
    mesh.vertices[3, 2] += np.float32(0.5)
    MapFile.write(other, mesh)
    assert run(capsys, "diff", grid, grid) == (0, "", "")
    code, out, _ = run(capsys, "diff", grid, other)
    assert code == 1 and out.startswith("vertices: 1 of 25 vertices differ by up to 0.5")
    assert run(capsys, "diff", grid, other, "-q") == (1, "", "")
    assert run(capsys, "diff", grid, other, "--tolerance", "0.5") == (0, "", "")
    assert run(capsys, "diff", grid, other, "--ignore", "geometry") == (0, "", "")
    found = json.loads(run(capsys, "diff", grid, other, "--json")[1])
    assert not found["same"] and found["differences"][0]["details"]["max"] == 0.5
    assert json.loads(run(capsys, "diff", grid, grid, "--json")[1])["differences"] == []
    code, out, err = run(capsys, "diff", grid, tmp_path / "none.h5")
    assert code == 2 and out == "" and err.count("\n") == 1
    (tmp_path / "bad.h5").write_bytes(b"bad")
    assert run(capsys, "diff", tmp_path / "bad.h5", grid)[0] == 2
    ply = tmp_path / "grid.ply"
    assert run(capsys, "export", grid, ply)[0] == 0
    assert run(capsys, "diff", ply, grid, "--ignore", "source")[:2] == (0, "")


@pytest.mark.parametrize("verb", ["diff", "layers", "info"])
def test_a_file_is_read_in_one_process_however_much_is_read(rich_mesh, tmp_path, monkeypatch, verb):
    path = str(tmp_path / "a.h5")
    MapFile.write(path, rich_mesh)
    started, child = [], ZYGOTE.child
    monkeypatch.setattr(ZYGOTE, "child", lambda limit: started.append(limit) or child(limit))
    assert main([verb, path, path] if verb == "diff" else [verb, path]) == 0
    assert len(started) == 1 + (verb != "layers")  # of the other file; of the scans


def test_validate_has_findings_and_exit_codes(grid, tmp_path, capsys):
    assert run(capsys, "validate", grid)[0] == 0
    code, out, _ = run(capsys, "validate", grid, "--strict")
    assert code == 0 and "valid, 1 note" in out
    odd, bad = tmp_path / "odd.h5", tmp_path / "bad.h5"
    mesh = zoo.two_components()
    MapFile.write(odd, Mesh(mesh.vertices, mesh.faces))
    bad.write_bytes(b"bad")
    assert run(capsys, "validate", odd)[0] == 0
    code, out, _ = run(capsys, "validate", odd, "--strict")
    assert code == 1 and "%s: error: faces [components]" % odd in out and "not valid" in out
    assert run(capsys, "validate", odd, "--strict", "--ignore", "components")[0] == 0
    code, out, err = run(capsys, "validate", bad, odd, tmp_path / "none.h5")
    assert (code, err) == (1, "") and out.count("not valid") == 2 and "[missing]" in out
    code, out, _ = run(capsys, "validate", bad, odd, "--json")
    report = json.loads(out)
    assert code == 1 and not report["valid"] and len(report["files"]) == 2
    finding = [f for f in report["files"][1]["findings"] if f["rule"] == "components"][0]
    assert finding["level"] == "warning" and finding["count"] == 2 and finding["where"] == "faces"
    assert report["files"][0]["counts"] == {"error": 1, "warning": 0, "note": 0}
    with pytest.raises(SystemExit) as ended:
        main(["validate", "--rules"])
    assert ended.value.code == 0 and capsys.readouterr().out.count("\n") == len(RULES)


def test_a_map_with_textures_but_no_materials_is_drawn_without(rich_mesh, tmp_path, capsys):
    path, out = tmp_path / "a.h5", tmp_path / "a.png"
    for name in ("materials", "vertex_colors"):
        MapFile.write(path, rich_mesh)
        assert run(capsys, "render", path, out, "--size", "300x300", "--force")[0] == 0
        setattr(rich_mesh, name, None)
    MapFile.write(path, rich_mesh)
    assert run(capsys, "render", path, out, "--force")[0] == 0


def test_materials_without_images_show_their_colors(tmp_path, capsys):
    mesh = Mesh(np.float32([[0, 0, 0], [9, 0, 0], [9, 9, 0]]), np.uint32([[0, 1, 2]]))
    colors = np.uint8([[250, 10, 10]])
    mesh.materials = Materials(colors, np.int32([-1]), np.zeros(1, np.uint32))
    path, out = tmp_path / "a.h5", tmp_path / "a.png"

    def reddish():
        assert run(capsys, "render", path, out, "--force", "--size", "300x300")[0] == 0
        picture = matplotlib.image.imread(out, "png")
        return int((picture[..., 0] - picture[..., 1:3].max(axis=2) > 0.5).sum())

    MapFile.write(path, mesh)
    assert reddish() > 1000
    mesh.vertex_colors = np.uint8([[9, 9, 250]] * 3)
    MapFile.write(path, mesh)
    assert reddish() < 1000


@pytest.mark.parametrize(
    "options",
    [
        [],
        ["--layer", "x", "--limits", "-1,3", "--view", "-30,20"],
        ["--labels", "--size", "300x200"],
        ["--height", "--view", "side", "--scale", "redgreen", "--title", "a $ b"],
    ],
)
def test_render_writes_a_png(grid, tmp_path, capsys, options):
    out = tmp_path / "a.png"
    code, said, err = run(capsys, "render", grid, out, *options)
    assert (code, err) == (0, "") and said.startswith("%s: written" % out)
    width, height = (300, 200) if "--size" in options else (1200, 900)
    picture = matplotlib.image.imread(out, "png")
    assert picture.shape[:2] == (height, width) and picture[..., :3].std() > 0.05
    before = out.read_bytes()
    assert run(capsys, "render", grid, out, *options)[0] == 1
    code, said, _ = run(capsys, "render", grid, out, *options, "--force", "--json")
    assert json.loads(said)["width"] == width and out.read_bytes() == before  # the same bytes


@pytest.mark.parametrize(
    "arguments,words",
    [
        (["render", "MAP", "a.jpg"], "ends with .png"),
        (["render", "MAP", "a.png", "--layer", "slope"], "slope"),
        (["render", "MAP", "a.png", "--face", "x"], "x"),
        (["render", "MAP", "a.png", "--colors"], "no colors"),
        (["render", "MAP", "a.png", "--textures"], "no textures"),
        (["render", "none.h5", "a.png"], "no such file"),
        (["render", "MAP", "nowhere/a.png"], "does not exist"),
        (["export", "MAP", "a.fbx"], "ends with .ply or .obj or .stl or .dae or .glb or .gltf"),
        (["export", "MAP", "MAP"], "ends with"),
        (["export", "none.h5", "a.ply"], "no such file"),
        (["convert", "MAP", "a.ply"], "ends with .h5"),
        (["convert", "MAP", "MAP"], "exists already"),
        (["convert", "MAP", "MAP", "--force"], "the same file"),
        (["convert", "none.h5", "a.h5"], "no such file"),
        (["convert", "MAP", "a.h5", "--part", "upper"], "upper"),
        (["repack", "none.h5"], "no such file"),
        (["repack", "MAP", "MAP"], "exists already"),
        (["repack", "bad.h5"], "not an HDF5 file"),
        (["info", "bad.h5"], "not an HDF5 file"),
        (["import", "MAP", "a.h5", "--frame", "/x"], "frame"),
    ],
)
def test_what_cannot_be_done_is_one_line_and_writes_nothing(
    grid, tmp_path, capsys, monkeypatch, arguments, words
):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "bad.h5").write_bytes(b"bad")
    before = grid.read_bytes()
    code, out, err = run(capsys, *["grid.h5" if word == "MAP" else word for word in arguments])
    assert (code, out) == (1, "") and words in err, err
    assert err.startswith("mesh_tool: error: ") and err.count("\n") == 1
    assert sorted(os.listdir(tmp_path)) == ["bad.h5", "grid.h5"] and grid.read_bytes() == before
