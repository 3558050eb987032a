"""The command, as a user runs it."""
import json
import os
import subprocess
from pathlib import Path

import numpy as np
import pytest
from mesh_writers import SQUARE, TWO_FACES, ply, xyz

from mesh_msgs_hdf5.importer import read_mesh
from mesh_msgs_hdf5.map_file import MapFile
from mesh_msgs_hdf5.mesh import Mesh
from mesh_msgs_hdf5.mesh_tool import COMMANDS, main

PROGRAM = Path(__file__).resolve().parents[1] / "nodes" / "mesh_tool"


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
        "%s: PLY, 4 vertices, 2 faces" % square,
        "  note: 1 faces of more than three corners were cut into triangles (fans)",
        "  note: layer cost has 1 unknown (NaN), 1 lethal (inf) values",
        "%s: saved, %d bytes, frame odom, uuid %s" % (out, out.stat().st_size, uuid),
    ]
    mesh = MapFile(out).read()
    assert np.array_equal(mesh.vertices, SQUARE) and np.array_equal(mesh.faces, TWO_FACES)
    assert mesh.frame_id == "odom" and mesh.source["file"] == "square.ply"
    assert main(["info", str(out)]) == 0
    text = capsys.readouterr().out
    for line in (
        "%s: HDF5 map, schema S1 version 1, %d bytes" % (out, out.stat().st_size),
        "  vertices   4",
        "  faces      2",
        "  z          0 .. 3 m",
        "  frame      odom",
        "  uuid       " + uuid,
        "  parts      mesh",
        "  layer      cost: 0.5 .. 2, 1 lethal, 1 unknown",
        '  source     {"file": "square.ply", "format": "PLY"}',
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
    layer = {"lethal": 0, "unknown": 0, "negative": 0, "parameters": {}}
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
        "vertices": 4,
        "faces": 2,
        "bounds": {"min": [0, 0, 0], "max": [1, 2, 3]},
        "normals": False,
        "colors": False,
        "layers": [
            dict(layer, name="cost", min=0.5, max=2, lethal=1, unknown=1),
            dict(layer, name="none", min=None, max=None, unknown=4, parameters={"radius": 0.3}),
        ],
        "source": file.source,
    }
    assert main(["info", "--json", str(square)]) == 0
    other = json.loads(capsys.readouterr().out)
    same = ("uuid", "vertices", "faces", "bounds", "frame_id")
    assert [other[key] for key in same] == [found[key] for key in same] and other["notes"]


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

    def slow(path, part):
        out.write_bytes(b"precious")
        return read_mesh(path, part)

    monkeypatch.setattr("mesh_msgs_hdf5.commands.import_mesh.read_mesh", slow)
    assert main(["import", str(square), str(out)]) == 1
    assert "exists already" in capsys.readouterr().err and out.read_bytes() == b"precious"


def test_another_part(tmp_path, capsys):
    MapFile.write(tmp_path / "a.h5", Mesh(SQUARE, TWO_FACES, frame_id="floor"), part="upper")
    assert main(["info", str(tmp_path / "a.h5")]) == 1
    assert "parts of this file: upper" in capsys.readouterr().err
    assert main(["info", str(tmp_path / "a.h5"), "--part", "upper"]) == 0
    assert main(["import", str(tmp_path / "a.h5"), str(tmp_path / "b.h5"), "--part", "upper"]) == 0
    assert MapFile(tmp_path / "b.h5").frame_id == "floor"


@pytest.mark.parametrize(
    "arguments",
    [[], ["wash"], ["import"], ["import", "a"], ["info"], ["info", "a", "b"], ["info", "--x"]],
)
def test_wrong_usage_is_one_line_and_code_2(capsys, arguments):
    with pytest.raises(SystemExit) as ended:
        main(arguments)
    output = capsys.readouterr()
    assert ended.value.code == 2 and output.out == ""
    assert output.err.startswith("mesh_tool: error: ") and output.err.count("\n") == 1
    assert "--help" in output.err


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


def test_help_names_every_verb_and_an_example(capsys):
    for arguments in (["--help"], *([command.NAME, "--help"] for command in COMMANDS)):
        with pytest.raises(SystemExit) as ended:
            main(arguments)
        assert ended.value.code == 0
    text = capsys.readouterr().out
    for command in COMMANDS:
        assert command.NAME in text and command.HELP.split()[0] in text
        assert command.EXAMPLE.split()[1] in text


def test_the_executable_needs_no_roscore(square):
    environment = dict(os.environ, ROS_MASTER_URI="http://localhost:1")
    result = subprocess.run(
        [PROGRAM, "info", square], env=environment, stdout=subprocess.PIPE, check=True, timeout=60
    )
    assert b"4" in result.stdout
    missing = subprocess.run(
        [PROGRAM, "info", "none"], stderr=subprocess.PIPE, timeout=60, check=False
    )
    assert missing.returncode == 1
    assert missing.stderr == b"mesh_tool: error: none: there is no such file (check the path)\n"


def test_a_reader_that_goes_away_is_no_crash(square):
    read, write = os.pipe()
    os.close(read)
    result = subprocess.run(
        [PROGRAM, "info", square], stdout=write, stderr=subprocess.PIPE, timeout=60, check=False
    )
    os.close(write)
    assert result.stderr == b"" and result.returncode == 1


def test_a_full_disk_behind_the_output_is_one_line(square):
    with open("/dev/full", "wb") as full:
        result = subprocess.run(
            [PROGRAM, "info", square], stdout=full, stderr=subprocess.PIPE, timeout=60, check=False
        )
    expected = b"mesh_tool: error: cannot write the output: No space left on device\n"
    assert (result.stderr, result.returncode) == (expected, 1)
