"""Meshes in the coordinates of a country: in and out again without losing digits."""
import re

import numpy as np
import pytest
from mesh_msgs import zoo
from mesh_writers import Gltf, dae, obj, ply, stl_text, xyz

from mesh_msgs_hdf5.commands.mesh_tool import main
from mesh_msgs_hdf5.formats.importer import read_mesh
from mesh_msgs_hdf5.formats.ply.ply_file import columns, read_elements
from mesh_msgs_hdf5.map_file import MapFile

UTM = np.array([431234.567, 5791234.321, 87.6])
GROUND = next(mesh for mesh in zoo.all_meshes() if len(mesh.faces) > 200)


@pytest.fixture(name="far")
def fixture_far():
    """(V, 3) float64, edges of some centimeters."""
    vertices = GROUND.vertices.astype(np.float64)
    edge = np.linalg.norm(vertices[GROUND.faces[:, 0]] - vertices[GROUND.faces[:, 1]], axis=1)
    return vertices * (0.05 / np.median(edge)) + UTM


def text_of_vertices(path):
    rows = [line.split()[1:4] for line in path.read_text().splitlines() if line[:2] == "v "]
    return np.array(rows, np.float64)


def ply_vertices(path):
    element = read_elements(path, path.read_bytes()).elements["vertex"]
    assert [p.type for p in element.properties[:3]] == ["f8"] * 3
    return columns(element, "xyz")


@pytest.mark.parametrize("suffix", [".ply", ".obj", ".stl", ".glb"])
def test_import_keeps_the_digits_by_itself(far, tmp_path, capsys, suffix):
    path, out = tmp_path / ("a" + suffix), tmp_path / "a.h5"
    gltf = Gltf()  # its own numbers are float32: a node puts them there
    gltf.mesh((far - UTM)[:, [0, 2, 1]] * [1, 1, -1], GROUND.faces)
    gltf.json["nodes"][0]["translation"] = [UTM[0], UTM[2], -UTM[1]]
    path.write_bytes(
        {
            ".ply": lambda: ply(xyz(far, "d"), GROUND.faces),
            ".obj": lambda: obj(far, GROUND.faces),
            ".stl": lambda: stl_text(far, GROUND.faces),
            ".glb": gltf.data,
        }[suffix]()
    )
    assert main(["import", str(path), str(out)]) == 0
    (line,) = [text for text in capsys.readouterr().out.splitlines() if "origin" in text]
    mesh = MapFile(out).read()
    assert mesh.origin == tuple(np.rint((far.min(axis=0) + far.max(axis=0)) / 2))
    found = mesh.vertices[mesh.faces].astype(np.float64) + mesh.origin
    assert np.abs(found - far[GROUND.faces]).max() < 1e-5
    lost = np.abs(far.astype(np.float32) - far)[np.unique(GROUND.faces)].max()
    told = re.fullmatch(
        r"  note: origin \(.*\) was subtracted from the coordinates: float32 would have rounded "
        r"them by up to (.*) m, more than a tenth of the median edge of (.*) m; --origin 0,0,0 "
        "leaves them as they are",
        line,
    )
    assert float(told[1]) == pytest.approx(lost, rel=0.01)
    assert 0.04 < float(told[2]) < 0.06
    assert "options" not in mesh.source
    # what the line says
    assert main(["import", str(path), str(out), "--origin", "0,0,0", "--force"]) == 0
    mesh = MapFile(out).read()
    assert mesh.origin == (0, 0, 0) and np.abs(mesh.vertices).max() > 5e6


def test_import_leaves_alone_what_rounding_does_not_harm(far, tmp_path, capsys):
    """Rounding by a quarter of a meter, edges of ten."""
    path, out = tmp_path / "a.ply", tmp_path / "a.h5"
    path.write_bytes(ply(xyz((far - UTM) * 200 + UTM, "d"), GROUND.faces))
    assert main(["import", str(path), str(out)]) == 0
    assert MapFile(out).origin == (0, 0, 0)
    assert "--origin auto keeps them" in capsys.readouterr().out
    # near zero, and what is float32 already
    path.write_bytes(ply(xyz(far - UTM, "d"), GROUND.faces))
    main(["import", str(path), str(out), "--force"])
    assert MapFile(out).origin == (0, 0, 0)
    assert main(["import", str(out), str(tmp_path / "b.h5")]) == 0
    assert MapFile(tmp_path / "b.h5").uuid == MapFile(out).uuid
    (tmp_path / "a.dae").write_text(dae(far - UTM, GROUND.faces))
    assert main(["import", str(tmp_path / "a.dae"), str(out), "--force"]) == 0
    assert MapFile(out).origin == (0, 0, 0)


@pytest.mark.parametrize("suffix", [".ply", ".obj"])
def test_out_again_at_the_same_place(far, tmp_path, capsys, suffix):
    path, out = tmp_path / "a.ply", tmp_path / ("b" + suffix)
    path.write_bytes(ply(xyz(far, "d"), GROUND.faces))
    arguments = ["import", str(path), str(tmp_path / "a.h5"), "--crs", "EPSG:25832"]
    assert main(arguments) == 0
    mesh = MapFile(tmp_path / "a.h5").read()
    capsys.readouterr()
    assert main(["export", str(tmp_path / "a.h5"), str(out), "--georeferenced"]) == 0
    note = "coordinates are those of EPSG:25832, with the origin %s, %s, %s" % mesh.origin
    assert note in capsys.readouterr().out
    found = ply_vertices(out) if suffix == ".ply" else text_of_vertices(out)
    assert np.array_equal(found, mesh.vertices.astype(np.float64) + mesh.origin)
    # rounding of float32, of local coordinates, and of float64
    local = np.abs(far - mesh.origin)
    assert (np.abs(found - far) <= 2.0**-24 * local + 2.0**-52 * np.abs(far)).all()
    again, _ = read_mesh(out, origin=mesh.origin)
    assert np.abs(again.vertices - mesh.vertices).max() <= 1e-9
    assert np.array_equal(again.faces, mesh.faces)
    assert (again.origin, again.crs) == (mesh.origin, "EPSG:25832")
    assert read_mesh(out)[0].origin == (0, 0, 0)
    # without the option: near the origin, which the note names with the way
    assert main(["export", str(tmp_path / "a.h5"), str(out), "--force"]) == 0
    assert "without the origin" in (text := capsys.readouterr().out) and "--georeferenced" in text
    back, _ = read_mesh(out)
    assert back.vertices.tobytes() == mesh.vertices.tobytes() and back.origin == mesh.origin


@pytest.mark.parametrize("suffix", [".stl", ".glb"])
def test_formats_of_float32_refuse_and_name_the_way_out(far, tmp_path, capsys, suffix):
    (tmp_path / "a.ply").write_bytes(ply(xyz(far, "d"), GROUND.faces))
    out = tmp_path / ("b" + suffix)
    assert main(["export", str(tmp_path / "a.ply"), str(out), "--georeferenced"]) == 1
    (line,) = capsys.readouterr().err.splitlines()
    assert "float32" in line and "name it .ply or .obj" in line
    assert not out.exists()
