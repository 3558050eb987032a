"""The command mesh_tool: import and info."""
import json
import os

import h5py
import numpy as np
import pytest
from mesh_writers import SQUARE, TWO_FACES, ply, xyz

from mesh_msgs_hdf5.commands.mesh_tool import main
from mesh_msgs_hdf5.formats.importer import read_mesh
from mesh_msgs_hdf5.map_file import MapFile
from mesh_msgs_hdf5.model.mesh import Mesh


@pytest.fixture
def square(tmp_path):
    path = tmp_path / "square.ply"
    cost = [0.5, np.inf, np.nan, 2.0]
    path.write_bytes(ply(xyz(SQUARE) + [("cost", "f", cost)], [[0, 1, 2, 3]]))
    return path


def test_import_then_info(square, tmp_path, capsys):
    out = tmp_path / "square.h5"
    assert main(["import", str(square), str(out), "--frame", "odom"]) == 0
    uuid = MapFile(out).uuid
    assert capsys.readouterr().out.splitlines() == [
        "%s: PLY, 4 vertices, 2 faces, 1 layer" % square,
        "  note: 1 faces of more than three corners were cut into triangles (fans)",
        "  note: 1 faces of more than three corners are not planar, and were cut as seen along "
        "their normal, first face 0",
        "  note: layer cost has 1 unknown (NaN), 1 lethal (inf) values",
        "%s: saved, %d bytes, frame odom, uuid %s" % (out, out.stat().st_size, uuid),
    ]
    mesh = MapFile(out).read()
    assert np.array_equal(mesh.vertices, SQUARE) and np.array_equal(mesh.faces, TWO_FACES)
    assert mesh.frame_id == "odom" and mesh.source["file"] == "square.ply"
    assert main(["info", str(out)]) == 0
    text = capsys.readouterr().out
    assert '"file": "square.ply"' in text and '"format": "PLY"' in text
    for line in (
        "%s: HDF5 map, schema S1 version 1, %d bytes" % (out, out.stat().st_size),
        "  vertices   4",
        "  faces      2",
        "  z          0 .. 3 m",
        "  frame      odom",
        "  uuid       " + uuid,
        "  parts      mesh (this is mesh)",
        "  layer      cost: 0.5 .. 2, 1 lethal, 1 unknown, parameters unknown (carried by import)",
        "  note       1 faces of more than three corners were cut into triangles (fans)",
    ):
        assert line in text.splitlines(), line


def test_info_for_programs(square, tmp_path, capsys):
    out = tmp_path / "square.h5"
    main(["import", str(square), str(out)])
    file = MapFile(out)
    file.write_layers({"none": (np.full(4, np.nan, "f4"), {"radius": 0.3})})
    capsys.readouterr()
    assert main(["info", "--json", str(out)]) == 0
    found = json.loads(capsys.readouterr().out)
    layer = {"lethal": 0, "unknown": 0, "negative": 0}
    carried = {"carried_by": "import"}
    assert found == {
        "path": str(out),
        "format": "HDF5",
        "file_bytes": out.stat().st_size,
        "schema": "S1",
        "schema_version": 1,
        "part": "mesh",
        "parts": ["mesh"],
        "uuid": file.uuid,
        "other_contents": [],
        "frame_id": "map",
        "origin": [0, 0, 0],
        "crs": "",
        "vertices": 4,
        "faces": 2,
        "bounds": {"min": [0, 0, 0], "max": [1, 2, 3]},
        "georeferenced": None,
        "normals": False,
        "colors": False,
        "layers": [
            dict(layer, name="cost", min=0.5, max=2, lethal=1, unknown=1, parameters=carried),
            dict(layer, name="none", min=None, max=None, unknown=4, parameters={"radius": 0.3}),
        ],
        "vertex_attributes": [],
        "face_attributes": [],
        "texture_coordinates": False,
        "textures": [],
        "materials": None,
        "labels": {"count": 0, "classes": {}},
        "unsaved_labels": 0,
        "features": None,
        "seams": None,
        "scans": {"count": 0, "points": 0, "images": 0},
        "source": file.source,
        "notes": [],
        "arrays_read": ["vertices", "layer cost", "layer none"],
    }
    assert main(["info", "--json", str(square)]) == 0
    other = json.loads(capsys.readouterr().out)
    same = ("uuid", "vertices", "faces", "bounds", "frame_id")
    assert [other[key] for key in same] == [found[key] for key in same] and other["notes"]


def test_info_about_everything(rich_mesh, tmp_path, capsys):
    path = tmp_path / "rich.h5"
    MapFile.write(path, rich_mesh)
    assert main(["info", "--json", str(path)]) == 0
    found = json.loads(capsys.readouterr().out)
    low, high = (np.array(found["bounds"][key]) for key in ("min", "max"))
    assert np.array_equal(low, rich_mesh.vertices.min(axis=0).astype(float))
    placed = {"min": (low + rich_mesh.origin).tolist(), "max": (high + rich_mesh.origin).tolist()}
    assert found["georeferenced"] == placed and found["crs"] == "EPSG:25832"
    assert [t["index"] for t in found["textures"]] == [0, 2, 10]
    assert found["textures"][0] == {"index": 0, "width": 7, "height": 5, "channels": 3}
    assert found["materials"] == {"count": 4, "textured": 3}
    assert found["labels"]["count"] == len(rich_mesh.labels)
    assert found["labels"]["classes"]["tree"] == {"labels": 2, "faces": 63}
    assert found["features"] == {"count": 12, "dimensions": 64}
    types = {entry["name"]: entry["type"] for entry in found["face_attributes"]}
    assert types["face_normals"] == "float64 x 3" and types["segment"] == "int64"
    assert main(["info", str(path)]) == 0
    text = capsys.readouterr().out
    for words in ("430000 5790000 -0.1 m (EPSG:25832)", "tree (2 labels, 63 faces)", "12 with 64"):
        assert words in text
    assert main(["info", "--fast", "--json", str(path)]) == 0
    fast = json.loads(capsys.readouterr().out)
    assert fast["arrays_read"] == [] and fast["bounds"] is None and fast["uuid"] == found["uuid"]
    for key in ("vertices", "faces", "origin", "frame_id", "source", "parts"):
        assert fast[key] == found[key]
    assert fast["labels"]["classes"]["tree"] == {"labels": 2, "faces": None}
    names = [entry["name"] for entry in fast["layers"]]
    assert names == [entry["name"] for entry in found["layers"]]
    assert main(["info", "--fast", str(path)]) == 0
    assert "no arrays" in capsys.readouterr().out


def test_info_about_what_costs_mean(tmp_path, capsys):
    path = tmp_path / "map.h5"
    costs = np.float32([0.1, 0.4, np.inf, np.nan])
    meaning = {"unit": "rad", "comparison": "above", "threshold": 0.3, "lethal": 7, "unknown": 7}
    parameters = {"type": "mesh_layers/SteepnessLayer", "layer_info": meaning}
    mesh = Mesh(SQUARE, TWO_FACES, vertex_costs={"slope": costs, "plain": costs})
    mesh.layer_parameters = {"slope": parameters}
    MapFile.write(path, mesh)
    assert main(["info", "--json", str(path)]) == 0
    plain, slope = json.loads(capsys.readouterr().out)["layers"]
    expected = {"unit": "rad", "comparison": "above", "threshold": 0.3, "rule": "above 0.3 rad"}
    assert {key: slope[key] for key in expected} == expected
    assert (slope["lethal"], slope["unknown"]) == (2, 1), "of the values, not what the file says"
    assert slope["parameters"] == {"type": "mesh_layers/SteepnessLayer"}
    assert plain["lethal"] == 1 and "unit" not in plain
    assert main(["info", str(path)]) == 0
    text = capsys.readouterr().out
    assert "slope: 0.1 .. 0.4 rad, 2 lethal (above 0.3 rad), 1 unknown, computed" in text
    assert "plain: 0.1 .. 0.4, 1 lethal, 1 unknown" in text
    assert main(["info", "--fast", str(path)]) == 0
    assert "slope, lethal above 0.3 rad, computed" in capsys.readouterr().out


def test_fast_info_reads_no_array(rich_mesh, tmp_path, monkeypatch, capsys):
    path = tmp_path / "rich.h5"
    MapFile.write(path, rich_mesh)
    monkeypatch.setattr("mesh_msgs_hdf5.formats.any_mesh.IsolatedMapFile", MapFile)

    def refuse(dataset):
        raise AssertionError(dataset.name)

    monkeypatch.setattr("mesh_msgs_hdf5.map_file.hdf5.chunks.load", refuse)
    assert main(["info", "--fast", str(path)]) == 0
    with pytest.raises(AssertionError, match="vertices"):
        main(["info", str(path)])


def test_the_options_of_import(tmp_path, capsys):
    vertices = np.concatenate([SQUARE, SQUARE[:1] + np.float32(0.001)]) + np.float32(
        [1000, 2000, 0]
    )
    path = tmp_path / "a.ply"
    path.write_bytes(ply(xyz(vertices), [[0, 1, 2], [4, 2, 3], [0, 0, 1]]))
    out = tmp_path / "a.h5"
    options = ["--origin", "1000,2000,-3", "--crs", "EPSG:25832", "--merge-vertices", "0.01"]
    options += ["--repair", "--compression", "none", "--force", "--json"]
    for _ in range(2):
        assert main(["import", str(path), str(out)] + options) == 0
    said = capsys.readouterr().out
    mesh = MapFile(out).read()
    assert mesh.origin == (1000, 2000, -3) and mesh.crs == "EPSG:25832"
    assert len(mesh.vertices) == 4 and len(mesh.faces) == 2
    found = json.loads(said[: said.index("\n}") + 2])
    assert (
        found["vertices"] == 4 and found["origin"] == [1000, 2000, -3] and len(found["notes"]) >= 2
    )
    assert main(["import", str(path), str(out), "--force", "--origin", "-1,-2,-3", "--quiet"]) == 0
    assert MapFile(out).origin == (-1, -2, -3) and capsys.readouterr() == ("", "")
    assert main(["import", str(path), str(out), "--force", "--merge-vertices", "-q"]) == 0
    assert MapFile(out).vertex_count == 5


def test_the_output_for_programs_is_strict_json(square, tmp_path, capsys):
    out = tmp_path / "square.h5"
    main(["import", str(square), str(out)])
    parameters = {"max": np.inf, "deep": [np.nan]}
    MapFile(out).write_layers({"new": (np.ones(4, "f4"), parameters)})
    capsys.readouterr()
    assert main(["info", "--json", str(out)]) == 0

    def refuse(name):
        raise AssertionError(name)

    found = json.loads(capsys.readouterr().out, parse_constant=refuse)
    assert found["layers"][1]["parameters"] == {"max": "Infinity", "deep": ["NaN"]}


def test_an_existing_map_is_not_replaced_unless_forced(square, tmp_path, capsys):
    out = tmp_path / "out.h5"
    out.write_bytes(b"precious")
    assert main(["import", str(square), str(out)]) == 1
    assert capsys.readouterr().err == (
        "mesh_tool: error: %s: the file exists already (use --force to replace it)\n" % out
    )
    assert out.read_bytes() == b"precious"
    assert main(["import", str(square), str(out), "--force"]) == 0
    assert MapFile(out).vertex_count == 4
    assert main(["import", str(out), str(out), "--force"]) == 1
    assert "the same file" in capsys.readouterr().err
    copy = tmp_path / "copy.h5"
    assert main(["import", str(out), str(copy)]) == 0
    assert copy.read_bytes() == out.read_bytes()


def test_a_map_that_appears_meanwhile_is_not_replaced(square, tmp_path, capsys, monkeypatch):
    out = tmp_path / "out.h5"

    def slow(path, part, **options):
        out.write_bytes(b"precious")
        return read_mesh(path, part, **options)

    monkeypatch.setattr("mesh_msgs_hdf5.commands.import_mesh.read_map", slow)
    assert main(["import", str(square), str(out)]) == 1
    assert "exists already" in capsys.readouterr().err and out.read_bytes() == b"precious"


def test_another_part(tmp_path, capsys):
    path = tmp_path / "a.h5"
    MapFile.write(path, Mesh(SQUARE, TWO_FACES, frame_id="floor"), part="upper")
    assert main(["info", str(path)]) == 0  # the only one
    assert "parts      upper" in capsys.readouterr().out
    with h5py.File(path, "r+") as file:
        file.copy("upper", "lower")
        file["lower"].attrs["frame_id"] = "cellar"
    assert main(["info", str(path)]) == 1
    error = capsys.readouterr().err
    assert "lower" in error and "upper" in error and error.count("\n") == 1
    assert main(["info", str(path), "--part", "upper"]) == 0
    assert main(["import", str(path), str(tmp_path / "b.h5"), "--part", "upper"]) == 0
    assert MapFile(tmp_path / "b.h5").frame_id == "floor"
    assert main(["diff", str(path), str(path), "--part", "upper", "--other-part", "lower"]) == 1
    assert "frame_id" in capsys.readouterr().out
    assert main(["validate", str(path)]) == 0
    out = capsys.readouterr().out
    assert "upper: faces [boundary]" in out and "lower: faces [boundary]" in out


@pytest.mark.parametrize(
    "arguments,words",
    [
        (["--frame", "/map", "out.h5"], "frame '/map'"),
        (["--frame", "", "out.h5"], "frame ''"),
        (["out.ply"], "ends with .h5"),
        (["nowhere/out.h5"], "nowhere does not exist"),
    ],
)
def test_a_wrong_target_is_refused_before_the_work(square, tmp_path, capsys, arguments, words):
    arguments[-1] = str(tmp_path / arguments[-1])
    assert main(["import", "missing.ply"] + arguments) == 1
    assert words in capsys.readouterr().err
    assert os.listdir(tmp_path) == ["square.ply"]


@pytest.mark.parametrize(
    "words",
    [["--transform", "-1,0,0,0,0,-1,0,0,0,0,1,0,0,0,0,1"], ["--origin", "-.5,-2,-3"]],
)
def test_what_looks_like_negative_coordinates_is_a_value(square, tmp_path, words):
    out = tmp_path / "square.h5"
    assert main(["import", *words, str(square), str(out)]) == 0
    expected = SQUARE * [-1, -1, 1] if "--transform" in words else SQUARE + [0.5, 2, 3]
    assert np.allclose(MapFile(out).read().vertices, expected)
    assert main(["render", str(out), str(tmp_path / "a.png"), "--view", "-120,50"]) == 0
