"""One bad value does not make a map useless: what is bad is left out or mended, and said."""
import contextlib
import dataclasses

import h5py
import numpy as np
import pytest
from bad_values import BAD, noted, write_bad
from every_member import reading_members
from map_samples import assert_same

from mesh_msgs_hdf5.commands.mesh_tool import main
from mesh_msgs_hdf5.isolation import IsolatedMapFile
from mesh_msgs_hdf5.map_file import MapFile
from mesh_msgs_hdf5.map_file.convert import convert
from mesh_msgs_hdf5.model.edit import Edit
from mesh_msgs_hdf5.model.errors import MapFileError
from mesh_msgs_hdf5.model.mesh import Label, Mesh
from mesh_msgs_hdf5.validation.validate import validate

FILES = {"here": MapFile, "isolated": IsolatedMapFile}
# kinds of which a member asked for by its name is an error
UNREADABLE = {"texture": ("texture", 10), "label type": ("label", "tree_2")}


@pytest.fixture(params=BAD)
def bad(request, tmp_path, rich_mesh, rich_data):
    """(path of a map in which one thing is bad, the mesh as it was, what is bad)."""
    write_bad(tmp_path / "a.h5", rich_data, request.param)
    return tmp_path / "a.h5", rich_mesh, request.param


def assert_same_but(found, mesh, kind):
    """All members but the one with the bad value, and of a dict all but the bad entry."""
    for field in dataclasses.fields(Mesh):
        name, one, other = field.name, getattr(found, field.name), getattr(mesh, field.name)
        if name == "materials" and kind == "texture":
            continue  # those that had it have none now
        if name != BAD[kind].member:
            assert_same(one, other, name)
        elif isinstance(other, dict) and name not in ("source", "layer_parameters"):
            differ = [key for key in other if key not in one or not same(one[key], other[key])]
            assert len(differ) <= 1, differ
            assert len(set(one) ^ set(other)) <= 1


def same(one, other):
    try:
        assert_same(one, other, "")
    except AssertionError:
        return False
    return True


@pytest.mark.parametrize("kind_of_file", FILES)
def test_all_else_is_read(bad, kind_of_file):
    path, mesh, kind = bad
    file = FILES[kind_of_file](path)
    found = file.read()
    assert_same_but(found, mesh, kind)
    assert noted(file.notes, kind) == 1, file.notes
    file.read()
    assert noted(file.notes, kind) == 1
    strict = FILES[kind_of_file](path, strict=True)
    if BAD[kind].finding:
        with pytest.raises(MapFileError):
            strict.read()
    assert not strict.notes


@pytest.mark.parametrize("kind_of_file", FILES)
def test_each_member_is_read(bad, kind_of_file):
    path, _, kind = bad
    file = FILES[kind_of_file](path)
    with contextlib.nullcontext() if kind_of_file == "here" else file:  # one process for all
        for name, member in reading_members(file):
            member()
        assert noted(file.notes, kind) == 1, file.notes
        if kind in UNREADABLE:
            name, key = UNREADABLE[kind]
            with pytest.raises(MapFileError):
                getattr(file, name)(key)


@pytest.mark.usefixtures("read_here")
def test_validate_says_what_it_said(bad):
    path, _, kind = bad
    errors = [f for f in validate(str(path)) if f.level == "error"]
    where = BAD[kind].finding
    assert [f.where for f in errors if where and f.where.startswith(where)] or not where, errors
    assert bool(errors) == bool(where)


def test_mended_values():
    """What stands in the place of each bad value, for those whose meaning is clear."""
    from mesh_msgs_hdf5.model.mending import mended_coordinates, mended_normals

    vertices = np.float32([[0, 0, 0], [2, 0, 0], [0, 1, 0], [0, 0, 9], [5, 5, 5]])
    faces = np.uint32([[0, 1, 2], [0, 3, 1]])
    bad = np.array([True, False, False, False, True])
    normals = mended_normals(np.full((5, 3), 0.5, "f4"), bad, vertices, faces)
    sums = np.cross([2, 0, 0], [0, 1, 0]) + np.cross([0, 0, 9], [2, 0, 0])
    np.testing.assert_allclose(normals[0], sums / np.linalg.norm(sums), rtol=1e-6)
    assert (normals[4] == 0).all() and (normals[1:4] == 0.5).all()
    uv = np.float32([[np.nan, 1], [1, 0], [0, 1], [1, 1], [np.inf, 0]])
    mended = mended_coordinates(uv, bad, faces)
    # of the corners of each face: vertex 1 is in both
    np.testing.assert_allclose(mended[0], [(1 + 0 + 1 + 1) / 4, (0 + 1 + 1 + 0) / 4])
    assert (mended[4] == 0).all() and (mended[1:4] == uv[1:4]).all()


@pytest.mark.parametrize("layout", ["s1", "lvr2"])
def test_a_face_whose_material_is_not_there_is_white(tmp_path, rich_mesh, layout):
    path = tmp_path / "a.h5"
    MapFile.write(path, rich_mesh)
    if layout == "lvr2":
        convert(path, tmp_path / "b.h5", profile="lvr2")
        path = tmp_path / "b.h5"
    places = {"s1": "textures/mat_face_indices", "lvr2": "channels/face_material_indices"}
    with h5py.File(path, "r+") as file:
        file["mesh"][places[layout]][33] = 77
    found = MapFile(path).materials
    wanted = rich_mesh.materials
    count = len(wanted.colors)
    assert found.colors.tolist() == [*wanted.colors.tolist(), [255, 255, 255]]
    assert found.texture_indices.tolist() == [*wanted.texture_indices.tolist(), -1]
    of_faces = wanted.face_materials.copy()
    of_faces[33] = count
    assert found.face_materials.tolist() == of_faces.tolist()


@pytest.mark.usefixtures("read_here")
def test_one_error_has_no_false_consequences(tmp_path, rich_data):
    """Textures have no material, and no coordinates, only where that is so."""
    (tmp_path / "whole.h5").write_bytes(rich_data)
    before = {(f.rule, f.where) for f in validate(str(tmp_path / "whole.h5"))}
    for kind in ("materials", "texture", "coordinates"):
        write_bad(tmp_path / "a.h5", rich_data, kind)
        found = {(f.rule, f.where) for f in validate(str(tmp_path / "a.h5"))} - before
        assert [where for _, where in found] == [BAD[kind].finding], found


def test_minus_infinity_is_unknown_and_never_free(tmp_path, rich_mesh, rich_data):
    write_bad(tmp_path / "a.h5", rich_data, "layer")
    costs = MapFile(tmp_path / "a.h5").vertex_costs("height_diff")
    assert np.isnan(costs[9])
    others = np.arange(40) != 9
    assert np.array_equal(costs[others], rich_mesh.vertex_costs["height_diff"][others], True)


def test_labels_keep_all_faces_that_there_are(tmp_path, rich_data):
    write_bad(tmp_path / "a.h5", rich_data, "label face")
    kept = [face for face in range(60) if face != 3]
    assert MapFile(tmp_path / "a.h5").label("tree_2").faces.tolist() == kept


def test_an_edit_writes_nothing_bad(bad):
    """Whatever is bad stays as it is stored, but for what is edited."""
    path, mesh, kind = bad
    file = MapFile(path)
    file.update(Edit(vertex_costs={"new": np.zeros(40, np.float32)}))
    assert_same(MapFile(path).vertex_costs("new"), np.zeros(40, np.float32), "new")
    texts = file.label_names()
    if BAD[kind].member == "labels":
        file.update(Edit(labels=dict.fromkeys(texts)))  # bad ones, too
        assert MapFile(path).label_names() == []
        file.update(Edit(labels={"tree_2": Label(np.uint32([4]))}))
        assert list(MapFile(path, strict=kind != "label of no text").labels()) == ["tree_2"]
    elif BAD[kind].member == "vertex_costs":
        names = [name for name in file.layer_names() if name != "new"]
        values = {name: np.ones(40, np.float32) for name in names}
        file.update(Edit(vertex_costs=values))
        strict = MapFile(path, strict=True)
        assert strict.layer_names() == sorted(names + ["new"])
        assert all((strict.vertex_costs(name) == 1).all() for name in names)
    else:
        texts = [text for text in texts if text != "tree_1"]
        file.update(Edit(labels={"tree_1": None}))
        assert MapFile(path).label_names() == texts


def test_a_deletion_leaves_the_names_of_others(tmp_path, rich_data):
    """A label under a name that was taken keeps the one that it is read by."""
    path = tmp_path / "a.h5"
    write_bad(path, rich_data, "label twice")
    MapFile(path).update(Edit(labels={"tree_1": None}))
    file = MapFile(path)
    assert file.label("tree_1_2").faces.tolist() == [1, 2] and not file.notes
    assert "tree_1" not in file.label_names()


def test_what_is_bad_is_not_saved_by_a_mesh(tmp_path, rich_mesh):
    for name, value in (
        ("vertex_normals", np.full((40, 3), np.nan, "f4")),
        ("vertex_costs", {"x": np.full(40, -np.inf, "f4")}),
        ("labels", {"x_1": Label(np.uint32([60]))}),
    ):
        with pytest.raises(MapFileError):
            MapFile.write(tmp_path / "b.h5", dataclasses.replace(rich_mesh, **{name: value}))
    assert not (tmp_path / "b.h5").exists()


def test_much_that_is_bad_is_said_in_few_words(tmp_path, rich_mesh):
    import h5py

    from mesh_msgs_hdf5.map_file.reading.part_reader import MAX_NOTES

    path = tmp_path / "a.h5"
    MapFile.write(path, rich_mesh)
    with h5py.File(path, "r+") as file:
        for i in range(2 * MAX_NOTES):
            file["mesh/labels/wrong/%d" % i] = np.zeros(3, "f4")
    file = MapFile(path)
    assert sorted(file.read().labels) == sorted(rich_mesh.labels)
    assert len(file.notes) == MAX_NOTES + 1 and "mesh_tool validate" in file.notes[-1]


@pytest.mark.parametrize("value", [np.nan, 1e60])
def test_geometry_that_cannot_be_read_refuses_a_map(tmp_path, rich_mesh, value):
    import h5py

    path = tmp_path / "a.h5"
    MapFile.write(path, rich_mesh)
    with h5py.File(path, "r+") as file:
        del file["mesh/channels/vertices"]
        vertices = rich_mesh.vertices.astype("f8")
        vertices[7] = value
        file["mesh/channels/vertices"] = vertices
    with pytest.raises(MapFileError, match="row 7"):
        MapFile(path).read()


ROWS = {
    "layer short": np.zeros((39, 1), "f4"),
    "layer across": np.zeros((1, 40), "f4")[:, :1],
    "vertex attribute wide": np.zeros((1, 40), "f4"),
    "vertex attribute kinds": np.zeros((41, 2), "u2"),
    "face attribute flat": np.zeros(59, "f4"),
}


@pytest.mark.usefixtures("read_here")
@pytest.mark.parametrize("what", ROWS)
def test_what_has_the_rows_of_another_mesh(tmp_path, rich_mesh, what, capsys):
    """It is named by all who look at it, and left out of what is written anew."""
    path, name = MapFile.write(tmp_path / "a.h5", rich_mesh).path, what.split()[-1]
    group = "face_attributes" if "face" in what else "channels"
    with h5py.File(path, "r+") as raw:
        found = raw["mesh/" + group].create_dataset(name, data=ROWS[what])
        place = found.name
        if name == "kinds":
            found.attrs["parameters"] = "{}"  # so it is ours
    text = "%s has the shape %s, not [%d]" % (
        place,
        list(ROWS[what].shape),
        40 + 20 * ("face" in what),
    )
    (finding,) = [f for f in validate(path) if f.level == "error"]
    assert (finding.where, finding.rule) == (what, "shape") and text in finding.message
    kind = [] if "layer" in what else ["--face" if "face" in what else "--vertex"]
    for words in (["info", path], ["layers", "list", path, *kind]):
        assert main(words) == 0 and text in capsys.readouterr().out
    new = str(tmp_path / "new.h5")
    assert main(["repair", path, new]) == 0 and text in capsys.readouterr().out
    with h5py.File(new, "r") as raw:
        assert name not in raw["mesh/" + group]
    assert not [f for f in validate(new) if f.level == "error"]
    assert main(["repair", path, "-q"]) == 0 and main(["diff", path, new]) == 0
    assert_same(MapFile(path).read(), rich_mesh, "mesh")


def test_unknown_numbers_of_other_programs_are_no_layers(tmp_path, rich_mesh):
    path = MapFile.write(tmp_path / "a.h5", rich_mesh).path
    with h5py.File(path, "r+") as raw:
        for name in ("uuid", "schema_version"):
            del raw["mesh"].attrs[name]
        raw["mesh/channels/theirs"] = np.zeros(5, "f4")
    file = MapFile(path)
    assert "theirs" not in file.layer_names()
    assert file.other_contents() == ["/mesh/channels/theirs"] and file.notes == []
    assert main(["convert", path, path + "_new.h5", "-q"]) == 0
    with h5py.File(path + "_new.h5", "r") as raw:
        assert raw["mesh/channels/theirs"].shape == (5,)  # it is carried along
