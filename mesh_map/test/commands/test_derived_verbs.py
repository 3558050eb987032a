"""mesh_tool refine and crop: all that belongs to the mesh goes along."""

import numpy as np
import pytest
from full_map import full_map, seamed_map
from mesh_map.geometry.crop import Region, crop
from mesh_map.geometry.refinement import refine
from mesh_map.io.map_source import MapSource
from mesh_msgs_hdf5.commands.mesh_tool import main
from mesh_msgs_hdf5.labels.label_store import LabelStore
from mesh_msgs_hdf5.map_file import MapFile
from mesh_msgs_hdf5.model.carried_mesh import carried_mesh
from mesh_msgs_hdf5.model.errors import MapFileError
from mesh_msgs_hdf5.model.mesh import Label, Mesh
from mesh_msgs_hdf5.model.seams import without_copies
from verb_calls import call, said


@pytest.fixture
def path(tmp_path):
    """A map with a label that stands in the journal alone."""
    file = MapFile.write(tmp_path / "map.h5", full_map())
    with LabelStore(file.path, "mesh") as labels:
        labels.set("gate_1", np.uint32([7]), override=True)
    return file.path


def journalled(path):
    mesh = MapFile(path).read()
    mesh.labels["gate_1"] = Label(np.uint32([7]))
    return mesh


def test_refine_carries_all(path, tmp_path, capsys):
    out = tmp_path / "fine.h5"
    value = said(capsys, "refine", path, out, "--max-edge-length", "0.06")
    parent, mesh = journalled(path), MapFile(out).read()
    derived = refine(parent.vertices, parent.faces, 0.06, parent_uuid=parent.uuid)
    expected = carried_mesh(parent, derived)
    assert value["faces"] == len(mesh.faces) == len(derived.faces) > 2 * len(parent.faces)
    for name in ("vertices", "faces", "vertex_normals", "vertex_colors", "texture_coordinates"):
        assert np.array_equal(getattr(mesh, name), getattr(expected, name)), name
    assert np.array_equal(mesh.vertex_costs["x"], expected.vertex_costs["x"], equal_nan=True)
    for name in ("number", "middle"):
        assert np.array_equal(mesh.face_attributes[name], expected.face_attributes[name])
    for text in ("tree_1", "floor", "gate_1"):
        faces = mesh.labels[text].faces
        assert set(derived.face_parents[faces]) == set(parent.labels[text].faces.tolist())
    assert mesh.labels["tree_1"].color == (1, 2, 3) and set(mesh.textures) == {4, 9}
    assert np.array_equal(
        mesh.materials.face_materials, parent.materials.face_materials[derived.face_parents]
    )
    assert (mesh.frame_id, mesh.crs, mesh.origin) == (parent.frame_id, parent.crs, parent.origin)
    # other values would be computed here
    assert mesh.layer_parameters == {"x": {"carried_by": "refinement"}}
    assert mesh.source["derived"] == "refinement" and mesh.source["parent_uuid"] == parent.uuid
    MapSource(str(out)).make_map()  # as a node loads it


def test_refine_says_where_nothing_was_to_do(path, tmp_path, capsys):
    value = said(capsys, "refine", path, tmp_path / "same.h5", "--max-edge-length", "9")
    assert any("no edge is longer than 9 m" in note for note in value["notes"])
    assert MapFile(tmp_path / "same.h5").uuid == MapFile(path).uuid


@pytest.mark.parametrize(
    "words,inside",
    [
        (
            ["--box", "0.25,0.1,-9,0.75,0.6,9"],
            lambda p: _between(p, 0, 0.25, 0.75) & _between(p, 1, 0.1, 0.6),
        ),
        (
            ["--box=0.75,0.6,9,0.25,0.1,-9", "--outside"],
            lambda p: ~(_between(p, 0, 0.25, 0.75) & _between(p, 1, 0.1, 0.6)),
        ),
        (["--z=0.02,0.4"], lambda p: _between(p, 2, 0.02, 0.4)),
        (
            ["--polygon", "0,0", "1,0", "0,1"],
            lambda p: (p[:, 0] + p[:, 1] < 1) & (p[:, :2] > 0).all(1),
        ),
        (
            ["--polygon", "0,0", "1,0", "0,1", "--z=-9,0.1"],
            lambda p: (p[:, 0] + p[:, 1] < 1) & (p[:, :2] > 0).all(1) & (p[:, 2] <= 0.1),
        ),
    ],
)
def test_crop_keeps_the_faces_with_all_they_have(path, tmp_path, capsys, words, inside):
    out = tmp_path / "part.h5"
    said(capsys, "crop", path, out, *words)
    parent, mesh = journalled(path), MapFile(out).read()
    middles = parent.face_attributes["middle"]
    kept = np.flatnonzero(inside(middles))
    assert 0 < len(kept) < len(parent.faces)
    assert np.array_equal(mesh.face_attributes["number"], kept)
    corners, before = mesh.faces.ravel(), parent.faces[kept].ravel()
    assert np.array_equal(mesh.vertices[corners], parent.vertices[before])
    assert len(mesh.vertices) == len(np.unique(before))
    for name in ("vertex_normals", "vertex_colors", "texture_coordinates"):
        assert np.array_equal(getattr(mesh, name)[corners], getattr(parent, name)[before]), name
    costs = mesh.vertex_costs["x"][corners]
    assert np.array_equal(costs, parent.vertex_costs["x"][before], equal_nan=True)
    for text, label in parent.labels.items():
        left = np.intersect1d(kept, label.faces)
        found = mesh.labels.get(text)
        assert (found is None) == (not len(left))
        assert not len(left) or np.array_equal(np.sort(kept[found.faces]), left)
    materials = mesh.materials
    used = parent.materials.face_materials[kept]
    assert np.array_equal(materials.face_materials, used)
    assert set(mesh.textures) == {[4, 9][index] for index in used}
    assert mesh.origin == parent.origin and mesh.source["derived"] == "crop"
    MapSource(str(out)).make_map()


def _between(points, axis, low, high):
    return (points[:, axis] >= low) & (points[:, axis] <= high)


def test_a_crop_of_a_crop_has_another_uuid():
    mesh = full_map()
    box = Region(np.zeros(3) - 9, np.float64([0.5, 9, 9]))
    one = crop(mesh.vertices, mesh.faces, box, parent_uuid="a")
    assert one.uuid == crop(mesh.vertices, mesh.faces, box, parent_uuid="a").uuid
    other = Region(box.low, box.high, outside=True)
    assert one.uuid != crop(mesh.vertices, mesh.faces, other, parent_uuid="a").uuid
    assert one.uuid != crop(mesh.vertices, mesh.faces, box, parent_uuid="b").uuid


@pytest.mark.parametrize(
    "words",
    [
        ["--z", "-.5,0"],
        ["--box", "-9,-9,-9,9,9,0"],
        ["--polygon", "-9,-9", "9,-9", "9,9", "-9,9", "--z", "-1,0"],
    ],
)
def test_coordinates_may_be_negative(path, tmp_path, capsys, words):
    """Option and value are two words, as a user writes them."""
    assert main(["crop", path, str(tmp_path / "part.h5"), *words]) == 0
    parent, out = MapFile(path).read(), MapFile(tmp_path / "part.h5")
    middles = parent.vertices[parent.faces].mean(1)
    assert out.face_count == np.count_nonzero(middles[:, 2] <= 0) < len(middles)


@pytest.mark.parametrize(
    "words,text",
    [
        ([], "there is no region to crop to"),
        (["--polygon", "0,0", "1,1"], "three corners"),
        (["--box", "50,50,50,51,51,51"], "no face of 242 has its middle in the region (the mesh"),
    ],
)
def test_a_wrong_region_makes_no_file(path, tmp_path, words, text):
    with pytest.raises(MapFileError) as refused:
        call("crop", path, tmp_path / "none.h5", *words)
    assert text in str(refused.value) and not (tmp_path / "none.h5").exists()


def test_in_the_same_file_as_another_part(path, tmp_path, capsys):
    said(capsys, "crop", path, path, "--box", "0,0,-9,0.5,0.5,9", "--to-part", "corner")
    assert MapFile(path, "mesh").face_count == 242 > MapFile(path, "corner").face_count > 0
    with pytest.raises(MapFileError, match="same file"):
        call("crop", path, path, "--z=0,1", "--force")
    with pytest.raises(MapFileError, match="there is .corner in it"):
        call("crop", path, path, "--z=0,1", "--to-part", "corner")


@pytest.mark.parametrize(
    "line",
    [
        ["refine", "--max-edge-length", "0.06"],
        ["crop", "--box", "0.3,0.2,-9,0.8,0.9,9"],
        ["crop", "--box", "0.7,0,-9,9,9,9"],  # no seam is in it
    ],
)
def test_seams_of_textures_do_not_cut_what_is_made(tmp_path, capsys, line):
    """It is what is made of the mesh without copies, and its corners have their coordinates."""
    parent = seamed_map()
    MapFile.write(tmp_path / "split.h5", parent)
    MapFile.write(tmp_path / "whole.h5", without_copies(parent))
    found = {}
    for name in ("split", "whole"):
        said(capsys, line[0], tmp_path / (name + ".h5"), tmp_path / (name + "_new.h5"), *line[1:])
        found[name] = MapFile(tmp_path / (name + "_new.h5")).read()
    split, whole = found["split"], found["whole"]
    assert np.array_equal(split.parent_vertices, whole.vertices)
    assert np.array_equal(split.parent_faces, whole.faces)
    has_seam = "0.7,0,-9,9,9,9" not in line
    assert (split.seam_originals is not None) == has_seam
    count = len(whole.vertices)
    for name, values in whole.vertex_attributes.items():
        assert np.array_equal(split.vertex_attributes[name][:count], values), name
    of_parent = parent.faces[split.face_attributes["number"]]
    corners = parent.vertices[of_parent][..., :2].astype(np.float64)  # (F, 3, 2), seen from above
    ones = np.ones((len(corners), 3, 1))
    here = np.concatenate([split.vertices[split.faces][..., :2], ones], axis=2)
    weights = here @ np.linalg.inv(np.concatenate([corners, ones], axis=2))
    expected = weights @ parent.texture_coordinates[of_parent]
    assert np.abs(split.texture_coordinates[split.faces] - expected).max() < 1e-5


def test_faces_that_touch_the_border_do_not_lie_across_it(tmp_path, capsys):
    """Corners at the heights of the border, as float32 has them."""
    x, z = (values.ravel() for values in np.meshgrid(np.arange(5.0), np.arange(11) / 10))
    vertices = np.stack([x, 0 * x, z], 1).astype(np.float32)
    corner = (np.arange(10)[:, None] * 5 + np.arange(4)).ravel()
    faces = np.stack([corner, corner + 1, corner + 5], 1)
    MapFile.write(tmp_path / "wall.h5", Mesh(vertices, faces.astype(np.uint32)))
    for border, is_across in (("0.2,0.7", False), ("0.25,0.7", True), ("0.2,9", False)):
        out = tmp_path / (border + ".h5")
        value = said(capsys, "crop", tmp_path / "wall.h5", out, "--z", border)
        assert any("lie across the border" in note for note in value["notes"]) == is_across, border


DERIVING = (
    ["refine", "{f}", "{o}", "--max-edge-length", "0.06"],
    ["crop", "{f}", "{o}", "--box", "0.3,0.2,-9,0.8,0.9,9"],
    ["merge", "{f}", "{f}", "{o}"],
    ["import", "{f}", "{o}", "--scale", "0.1"],
)


@pytest.mark.parametrize("line", DERIVING)
def test_layers_of_another_geometry_are_not_taken_on_trust(tmp_path, capsys, line):
    """Also where the file that they come from did not say how they were computed."""
    mesh = full_map()
    mesh.vertex_costs = {"height_diff": np.full(len(mesh.vertices), 0.0123, np.float32)}
    mesh.layer_parameters = {}
    MapFile.write(tmp_path / "a.h5", mesh)
    names = {"f": tmp_path / "a.h5", "o": tmp_path / "b.h5"}
    words = [word.format(**names) for word in line]
    if line[0] == "import":
        assert main(words) == 0
    else:
        said(capsys, *words)
    source = MapSource(str(names["o"]))
    mesh_map = source.make_map()
    layer = {"name": "height_diff", "type": "mesh_layers/HeightDiffLayer"}
    mesh_map.compute_layers([layer], stored=source.stored_costs, on_trust=source.costs_on_trust)
    costs = mesh_map.layers["height_diff"].result.costs
    assert not (costs == np.float32(0.0123)).any()


@pytest.mark.parametrize("line", DERIVING)
def test_what_values_mean_stays_with_them(tmp_path, capsys, line):
    """Unit and rule of layers, with the numbers of what is there now; parameters of attributes."""
    mesh = full_map()
    costs = np.linspace(0, 1, len(mesh.vertices)).astype(np.float32)
    costs[:3] = np.nan
    rule = {"unit": "m", "comparison": "above", "threshold": 0.25, "lethal": 5, "unknown": 5}
    mesh.vertex_costs, mesh.layer_parameters = {"mine": costs}, {
        "mine": {"radius": 0.3, "type": "my/Layer", "geometry": "x", "layer_info": rule}
    }
    mesh.vertex_attributes["kind"] = np.arange(len(costs))
    mesh.vertex_parameters = {"kind": {"net": "a"}}
    mesh.face_parameters = {"number": {"net": "b"}}
    MapFile.write(tmp_path / "a.h5", mesh)
    names = {"f": tmp_path / "a.h5", "o": tmp_path / "b.h5"}
    assert main([word.format(**names) for word in line]) == 0
    found = MapFile(names["o"])
    parameters, values = found.layer_parameters("mine"), found.vertex_costs("mine")
    info = parameters.pop("layer_info")
    assert set(parameters) == {"carried_by", "type"} and parameters["type"] == "my/Layer"
    assert info == dict(
        rule, lethal=int((values > 0.25).sum()), unknown=int(np.isnan(values).sum())
    )
    assert info["lethal"] not in (0, 5)
    assert found.vertex_parameters("kind") == {"net": "a"}
    assert found.face_parameters("number") == {"net": "b"}
    assert "left out: unit" not in capsys.readouterr().out
