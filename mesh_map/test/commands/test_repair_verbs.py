"""mesh_tool fill-holes, simplify and compare: all that belongs to the mesh goes along."""

import numpy as np
import pytest
from full_map import full_map, seamed_map
from mesh_map.geometry.hole_filling import fill_holes
from mesh_map.geometry.mesh_comparison import compare_meshes
from mesh_map.geometry.topology import Topology
from mesh_map.io.map_source import MapSource
from mesh_msgs_hdf5.commands.mesh_tool import main
from mesh_msgs_hdf5.labels.label_store import LabelStore
from mesh_msgs_hdf5.map_file import MapFile
from mesh_msgs_hdf5.model.errors import MapFileError
from mesh_msgs_hdf5.model.mesh import Label, Mesh
from mesh_msgs_hdf5.model.seams import without_copies
from mesh_msgs_hdf5.validation.validate import validate
from verb_calls import call, said

HOLE = [50, 51, 52, 53, 72, 73, 74, 75]  # of the 22 faces in a row of full_map()


def half_labelled(make):
    """A map whose labels leave room to simplify."""
    mesh = make(30)
    middles = mesh.face_attributes["middle"]
    left = np.flatnonzero(middles[:, 1] < 1.0).astype(np.uint32)
    mesh.labels = {"floor": Label(left, (1, 2, 3)), "tree_1": Label(np.uint32([900, 901]))}
    return mesh


def holed(make):
    mesh = make(12)
    kept = np.setdiff1d(np.arange(len(mesh.faces)), HOLE)
    number = np.full(len(mesh.faces), -1)
    number[kept] = np.arange(len(kept))
    mesh.faces = mesh.faces[kept]
    mesh.face_attributes = {name: v[kept] for name, v in mesh.face_attributes.items()}
    mesh.materials.face_materials = mesh.materials.face_materials[kept]
    for text, label in mesh.labels.items():
        faces = number[label.faces]
        mesh.labels[text] = Label(faces[faces >= 0].astype(np.uint32), label.color)
    return mesh


@pytest.mark.parametrize("make", [full_map, seamed_map])
def test_fill_holes_carries_all(make, tmp_path, capsys):
    path, out = tmp_path / "holed.h5", tmp_path / "closed.h5"
    parent = MapFile.write(path, holed(make)).read()
    with LabelStore(str(path), "mesh") as labels:
        labels.set("gate_1", np.uint32([7]), override=True)
    value = said(capsys, "fill_holes", path, out, "--max-perimeter", "2")
    mesh, whole = MapFile(out).read(), without_copies(parent)
    done = fill_holes(whole.vertices, whole.faces, max_perimeter=2.0)
    assert value["loops"]["filled"] == done.counts()["filled"] == 1
    count, new = len(parent.faces), done.new_faces
    assert value["new_faces"] == np.count_nonzero(new) == len(mesh.faces) - count > 0
    result = without_copies(mesh)
    assert np.array_equal(result.vertices, done.derived.vertices)
    assert np.array_equal(result.faces, done.derived.faces)
    # what was there is as it was
    corners, before = mesh.faces[:count].ravel(), parent.faces.ravel()
    for name in ("vertices", "vertex_normals", "vertex_colors", "texture_coordinates"):
        assert np.array_equal(getattr(mesh, name)[corners], getattr(parent, name)[before]), name
    costs = mesh.vertex_costs["x"][corners]
    assert np.array_equal(costs, parent.vertex_costs["x"][before], equal_nan=True)
    assert mesh.layer_parameters == {"x": {"carried_by": "holes filled"}}
    for name, values in parent.face_attributes.items():
        assert np.array_equal(mesh.face_attributes[name], values[done.derived.face_parents])
    assert set(mesh.labels) == {"tree_1", "floor", "gate_1"} and mesh.labels["gate_1"].faces[0] == 7
    # textures show nothing of what was not there
    materials = mesh.materials
    assert np.array_equal(materials.face_materials[:count], parent.materials.face_materials)
    assert (materials.face_materials[count:] == 2).all() and materials.texture_indices[2] == -1
    assert any("without texture, in gray" in note for note in value["notes"])
    assert any("layers x" in note for note in value["notes"])
    assert (mesh.frame_id, mesh.crs, mesh.origin) == (parent.frame_id, parent.crs, parent.origin)
    assert not [f for f in validate(str(out)) if f.level == "error"]
    MapSource(str(out)).make_map()


@pytest.mark.parametrize("make", [full_map, seamed_map])
def test_simplify_carries_all(make, tmp_path, capsys):
    path, out = tmp_path / "map.h5", tmp_path / "light.h5"
    parent = MapFile.write(path, half_labelled(make)).read()
    value = said(capsys, "simplify", path, out, "--ratio", "0.3")
    mesh, whole = MapFile(out).read(), without_copies(parent)
    result = without_copies(mesh)
    assert value["faces"] == len(mesh.faces) < 0.6 * len(parent.faces)
    # each vertex is one that was there, with what it had
    rows = mesh.vertex_attributes["id"]
    assert np.array_equal(mesh.vertices, whole.vertices[rows])
    for name in ("vertex_normals", "vertex_colors"):
        assert np.array_equal(getattr(mesh, name), getattr(whole, name)[rows]), name
    expected = whole.vertex_costs["x"][rows]
    assert np.array_equal(mesh.vertex_costs["x"], expected, equal_nan=True)
    shift = np.zeros(len(rows))
    if mesh.seam_originals is not None:
        shift[-len(mesh.seam_originals) :] = 0.5
        assert np.array_equal(rows[-len(mesh.seam_originals) :], rows[mesh.seam_originals])
    assert np.allclose(mesh.texture_coordinates, mesh.vertices[:, :2] + shift[:, None])
    assert (mesh.seam_originals is None) == (parent.seam_originals is None)
    # borders of the mesh, its labels and its materials are as they were
    before = Topology(faces=whole.faces, vertex_count=len(whole.vertices))
    after = Topology(faces=result.faces, vertex_count=len(result.vertices))
    assert after.border_edges.sum() == before.border_edges.sum()
    assert not after.non_manifold_edges.any() and not after.inconsistent_edges.any()
    for one, other in (
        (parent.labels["floor"].faces, mesh.labels["floor"].faces),
        (parent.labels["tree_1"].faces, mesh.labels["tree_1"].faces),
        (parent.materials.face_materials == 1, mesh.materials.face_materials == 1),
    ):
        found = Topology(faces=result.faces[other], vertex_count=len(result.vertices))
        ends = rows[found.edges[found.border_edges]]
        own = Topology(faces=whole.faces[one], vertex_count=len(whole.vertices))
        wanted = own.edges[own.border_edges]
        assert np.array_equal(np.unique(np.sort(ends, 1), axis=0), np.unique(wanted, axis=0))
    assert mesh.labels["floor"].color == (1, 2, 3) and set(mesh.textures) == {4, 9}
    assert mesh.source["derived"] == "simplification"
    assert mesh.source["parameters"] == {"ratio": 0.3}
    assert not [f for f in validate(str(out)) if f.level == "error"]
    MapSource(str(out)).make_map()


def test_simplify_says_where_nothing_was_to_do(tmp_path, capsys):
    MapFile.write(tmp_path / "map.h5", full_map())
    value = said(capsys, "simplify", tmp_path / "map.h5", tmp_path / "b.h5", "--max-error", "0")
    assert any("no face could be spared" in note for note in value["notes"])
    with pytest.raises(MapFileError, match="nothing to simplify to"):
        call("simplify", tmp_path / "map.h5", tmp_path / "c.h5")


def test_a_soup_is_repaired_first(tmp_path, capsys):
    path, out = tmp_path / "map.h5", tmp_path / "b.h5"
    mesh = full_map()
    apart = mesh.vertices[mesh.faces[0]] + np.float32([0, 0, 9])
    faces = np.concatenate([mesh.faces, mesh.faces[:1], [[144, 145, 146]]]).astype(np.uint32)
    MapFile.write(path, Mesh(np.concatenate([mesh.vertices, apart]), faces))
    value = said(capsys, "fill_holes", path, out, "--repair", "--min-faces", "2")
    assert np.array_equal(MapFile(out).read().faces, mesh.faces)
    assert value["notes"] == [
        "repaired: 1 duplicate face left out",
        "dropped: 1 face of small components",
    ]


def test_compare(tmp_path, capsys):
    truth, path, picture = (tmp_path / name for name in ("truth.h5", "map.h5", "error.png"))
    mesh = full_map(30)
    mesh.face_attributes["seen"] = (mesh.face_attributes["middle"][:, 0] < 1.5).astype(np.uint8)
    MapFile.write(truth, mesh)
    # as far away as its origin says that it is not
    moved = Mesh(mesh.vertices + np.float32([1, 1, 0.02]), mesh.faces[::-1], frame_id="hall")
    moved.origin = tuple(np.subtract(mesh.origin, (1, 1, 0)))
    MapFile.write(path, moved)
    value = said(capsys, "compare", truth, path, "--picture", picture, "--samples", "5000")
    expected = compare_meshes(
        mesh.vertices,
        mesh.faces,
        mesh.vertices + np.float32([0, 0, 0.02]),
        mesh.faces,
        samples=5000,
    )
    assert 0.01 < value["accuracy"]["mean"] <= 0.02 and value["accuracy"]["share_within"] == 1.0
    assert np.isclose(value["accuracy"]["mean"], expected.accuracy.mean, rtol=0.05)
    assert value["soundness"]["map"] == expected.mesh._asdict()
    assert picture.read_bytes()[:8] == b"\x89PNG\r\n\x1a\n"
    words = ["--reached", "seen", "--within=0,0,-9,1,1,9", "--samples", "5000"]
    part = said(capsys, "compare", truth, path, *words)
    assert 500 < part["completeness"]["count"] < part["accuracy"]["count"] * 2.5
    with pytest.raises(MapFileError, match="no attribute 'unseen'"):
        call("compare", truth, path, "--reached", "unseen")
    with pytest.raises(MapFileError, match="exists"):
        call("compare", truth, path, "--picture", picture)
    MapFile.write(tmp_path / "other.h5", Mesh(mesh.vertices, mesh.faces, crs="EPSG:25833"))
    with pytest.raises(MapFileError, match="the truth is in EPSG:25832"):
        call("compare", truth, tmp_path / "other.h5")


def test_lines_for_people(tmp_path, capfd):
    MapFile.write(tmp_path / "map.h5", full_map())
    path = str(tmp_path / "map.h5")
    assert main(["compare", path, path, "--samples", "100"]) == 0
    out = capfd.readouterr().out
    assert "100.00 % within 50 mm" in out and "1 border loop, 0 border edges in none" in out
    assert main(["simplify", path, str(tmp_path / "b.h5"), "--ratio", "2"]) == 1
    assert "ratio is 2" in capfd.readouterr().err
