"""mesh_tool merge: what each mesh has is found where it was."""

import numpy as np
import pytest
from full_map import full_map, seamed_map
from mesh_map.io.map_source import MapSource
from mesh_map.io.merged_mesh import NamedMesh, merged
from mesh_msgs_hdf5.checks.check import checked_mesh
from mesh_msgs_hdf5.map_file import MapFile
from mesh_msgs_hdf5.model.errors import MapFileError
from mesh_msgs_hdf5.model.mesh import Features, Label, Materials, Mesh
from verb_calls import call, said

ORIGIN = np.array([1000.0, 2000.0, 3.0])


@pytest.fixture
def maps(tmp_path):
    """Two full maps, the second 50 m east of the first by its origin, and one with little."""
    one, two = full_map(8), full_map(6)
    two.origin = (1050.0, 2000.0, 3.0)
    two.labels["gate_1"] = Label(np.uint32([4]))
    two.face_attributes["number"] = two.face_attributes["number"].astype(np.uint16)
    bare = Mesh(full_map(5).vertices, full_map(5).faces, frame_id="hall", crs="EPSG:25832")
    bare.origin = (1000.0, 1990.0, 3.0)
    paths = [str(tmp_path / name) for name in ("one.h5", "two.h5", "bare.h5")]
    for path, mesh in zip(paths, (one, two, bare)):
        MapFile.write(path, mesh)
    return paths, [one, two, bare]


def test_all_of_each_is_there(maps, tmp_path, capsys):
    paths, (one, two, bare) = maps
    value = said(capsys, "merge", *paths, tmp_path / "all.h5")
    mesh = MapFile(tmp_path / "all.h5").read()
    v, f = len(one.vertices), len(one.faces)
    w, g = v + len(two.vertices), f + len(two.faces)
    assert mesh.origin == one.origin and mesh.frame_id == "hall" and mesh.crs == one.crs
    absolute = [each.vertices.astype(float) + each.origin for each in (one, two, bare)]
    assert np.allclose(mesh.vertices + ORIGIN, np.concatenate(absolute), atol=1e-5, rtol=0)
    assert np.array_equal(mesh.vertices[:v], one.vertices)
    assert np.array_equal(mesh.faces, np.concatenate([one.faces, two.faces + v, bare.faces + w]))
    for name in ("vertex_normals", "vertex_colors", "texture_coordinates"):
        found = getattr(mesh, name)
        assert np.array_equal(found[:v], getattr(one, name)), name
        assert np.array_equal(found[v:w], getattr(two, name)), name
    assert (mesh.vertex_colors[w:] == 255).all()
    assert np.allclose(np.linalg.norm(mesh.vertex_normals[w:], axis=1), 1, atol=1e-4)
    costs = mesh.vertex_costs["x"]
    assert np.array_equal(costs[v:w], two.vertex_costs["x"], equal_nan=True)
    assert np.isnan(costs[w:]).all() and mesh.layer_parameters == {"x": {"carried_by": "merge"}}
    attributes = mesh.face_attributes
    assert np.array_equal(attributes["number"][:f], one.face_attributes["number"])
    assert np.array_equal(attributes["number_2"][f:g], two.face_attributes["number"])
    assert attributes["number_2"].dtype == np.uint16 and attributes["middle"].shape[1] == 3
    labels = {text: label.faces.tolist() for text, label in mesh.labels.items()}
    assert labels["tree_1"] == [0, 1, 2] and labels["tree_2"] == [f, f + 1, f + 2]
    assert labels["gate_1"] == [f + 4]
    both = [*one.labels["floor"].faces, *(two.labels["floor"].faces + f)]
    assert sorted(labels["floor"]) == sorted(both)
    texture = mesh.materials.texture_indices[mesh.materials.face_materials]
    for start, each in ((0, one), (f, two)):
        before = each.materials.texture_indices[each.materials.face_materials]
        for face in (0, len(each.faces) - 1):
            image = mesh.textures[int(texture[start + face])]
            assert np.array_equal(image, each.textures[int(before[face])])
    assert (texture[g:] == -1).all()
    assert np.allclose(mesh.features.locations[2:] - two.features.locations, [50, 0, 0], atol=1e-5)
    text = " ".join(value["notes"])
    for words in (
        "tree_1 of two.h5 is tree_2",
        "number of two.h5 is number_2: there is another one",
        "no materials in bare.h5",
        "no layer x in bare.h5: unknown",
    ):
        assert words in text, text
    MapSource(str(tmp_path / "all.h5")).make_map()


def test_parts_of_one_file_become_one_of_them(maps, tmp_path, capsys):
    paths, (one, two, _) = maps
    both = tmp_path / "house.h5"
    MapFile.write(both, one, "floor1")
    MapFile.write_part(both, two, "floor2")
    MapFile.write_part(both, one, "roof")
    value = said(capsys, "merge", both, both, "--parts", "floor2,floor1", "--to-part", "house")
    assert value["merged"] == ["house.h5:floor2", "house.h5:floor1"]
    house = MapFile(both, "house")
    assert house.face_count == len(one.faces) + len(two.faces) and house.origin == two.origin
    assert sorted(house.parts) == ["floor1", "floor2", "house", "roof"]
    value = said(capsys, "merge", both, tmp_path / "all.h5")  # of a file all its meshes
    assert len(value["merged"]) == 4


def test_vertices_at_one_place_become_one(tmp_path, capsys):
    corners = np.float32([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    for name, shift in (("a", 0), ("b", 1)):
        mesh = Mesh(corners, np.uint32([[0, 1, 2], [0, 2, 3]]), origin=(shift, 0.0, 0.0))
        MapFile.write(tmp_path / (name + ".h5"), mesh)
    words = [tmp_path / "a.h5", tmp_path / "b.h5", tmp_path / "c.h5"]
    assert said(capsys, "merge", *words)["vertices"] == 8
    assert said(capsys, "merge", *words, "--merge-vertices", "--force")["vertices"] == 6


def test_what_does_not_fit_is_refused(maps, tmp_path):
    paths, (one, _, bare) = maps
    out = tmp_path / "out.h5"
    far = Mesh(
        bare.vertices, bare.faces, frame_id="hall", crs=bare.crs, origin=(4e7 + 0.3, 0.0, 0.0)
    )
    other = Mesh(bare.vertices, bare.faces, frame_id="yard", crs=bare.crs)
    MapFile.write(tmp_path / "far.h5", far)
    MapFile.write(tmp_path / "other.h5", other)
    for words, text in (
        ([paths[0], tmp_path / "far.h5", out], "float32 would change"),
        ([paths[0], tmp_path / "other.h5", out], "frame_id of other.h5 is 'yard'"),
        ([paths[0], out], "one mesh alone"),
        ([paths[0], paths[1], out, "--parts", "cellar"], "there is no part cellar"),
        ([paths[0], paths[1], paths[1]], "replaced by what is made of it"),
    ):
        with pytest.raises(MapFileError) as refused:
            call("merge", *words)
        assert text in str(refused.value)
    assert not out.exists()


def test_features_of_another_kind_are_left_out_by_the_name_of_their_mesh():
    meshes = [NamedMesh(name, full_map(5)) for name in ("first", "second", "third")]
    features = meshes[1].mesh.features
    wide = np.repeat(features.descriptors, 2, axis=1)
    meshes[1].mesh.features = Features(features.locations, wide)
    mesh, notes = merged(meshes)
    assert len(mesh.features.locations) == 2 * len(features.locations)
    (note,) = [note for note in notes if "another kind" in note]
    assert "second" in note


def test_copies_along_seams_stay_copies():
    meshes = [
        NamedMesh(str(i), mesh)
        for i, mesh in enumerate((seamed_map(8), full_map(5), seamed_map(6)))
    ]
    mesh, _ = merged(meshes)
    parts = [each.mesh for each in meshes]
    own = [len(part.parent_vertices) for part in parts]
    assert len(mesh.parent_vertices) == sum(own)
    starts = np.cumsum([0, *own])
    for number, part in enumerate(parts):
        begin = sum(len(each.faces) for each in parts[:number])
        faces = mesh.faces[begin : begin + len(part.faces)]
        assert np.array_equal(
            mesh.parent_faces[begin : begin + len(part.faces)], part.parent_faces + starts[number]
        )
        for name in ("texture_coordinates", "vertex_colors"):
            assert np.array_equal(getattr(mesh, name)[faces], getattr(part, name)[part.faces]), name
        values = mesh.vertex_attributes["id"][faces]
        assert np.array_equal(values, part.vertex_attributes["id"][part.faces])


def test_an_attribute_of_vertices_does_not_take_the_name_of_a_layer():
    meshes = [NamedMesh(name, full_map(5)) for name in ("first", "second")]
    second = meshes[1].mesh
    second.vertex_attributes["x"] = np.arange(len(second.vertices))
    del second.vertex_costs["x"]
    mesh, notes = merged(meshes)
    count = len(meshes[0].mesh.vertices)
    assert np.array_equal(mesh.vertex_attributes["x_2"][count:], second.vertex_attributes["x"])
    assert "x" in mesh.vertex_costs and any("x_2" in note for note in notes)
    checked_mesh("m.h5", mesh)


def test_what_two_say_of_one_layer_is_kept_where_it_is_the_same(tmp_path, capsys):
    for name, limit, net in (("a", 0.25, "x"), ("b", 0.5, "x"), ("c", 0.25, "y")):
        mesh = full_map(4)
        mesh.vertex_costs = {"mine": np.ones(len(mesh.vertices), np.float32)}
        rule = {"unit": "m", "comparison": "above", "threshold": limit}
        mesh.layer_parameters = {"mine": {"layer_info": rule}}
        mesh.face_parameters = {"number": {"net": net}}
        MapFile.write(tmp_path / (name + ".h5"), mesh)
    paths = {name: tmp_path / (name + ".h5") for name in "abc"}
    notes = said(capsys, "merge", paths["a"], paths["b"], tmp_path / "ab.h5")["notes"]
    (note,) = [note for note in notes if note.startswith("left out: unit and rule of layer mine")]
    assert "a.h5" in note and "b.h5" in note
    found = MapFile(tmp_path / "ab.h5")
    assert found.layer_parameters("mine") == {"carried_by": "merge"}
    assert found.face_parameters("number") == {"net": "x"}
    notes = said(capsys, "merge", paths["a"], paths["c"], tmp_path / "ac.h5")["notes"]
    assert any(note.startswith("left out: parameters of face attribute number") for note in notes)
    found = MapFile(tmp_path / "ac.h5")
    assert found.layer_parameters("mine")["layer_info"]["threshold"] == 0.25
    assert found.face_parameters("number") == {}


def test_equal_images_and_materials_are_there_once():
    """Those of one mesh stay as they are, also if they are equal."""
    one, two, three = full_map(6), full_map(6), full_map(6)
    image = next(iter(one.textures.values()))
    other = 255 - image
    one.textures = {2: image, 5: image.copy()}
    two.textures = {0: other, 1: image.copy()}
    three.textures = {0: other.copy(), 3: image[:1].copy()}
    faces = np.arange(len(one.faces), dtype=np.uint32)
    for mesh, indices in ((one, [2, 5, -1]), (two, [1, 0, -1]), (three, [0, 3, -1])):
        colors = np.uint8([[9, 9, 9], [9, 9, 9], [1, 2, 3]])
        mesh.materials = Materials(colors, np.int32(indices), faces % 3)
    mesh, _ = merged([NamedMesh(name, m) for name, m in zip("abc", (one, two, three))])
    assert sorted(mesh.textures) == [2, 5, 6, 7]
    assert mesh.materials.texture_indices.tolist() == [2, 5, -1, 6, 7]
    assert mesh.materials.colors.tolist() == [[9, 9, 9]] * 2 + [[1, 2, 3]] + [[9, 9, 9]] * 2
    for start, each in zip((0, len(faces), 2 * len(faces)), (one, two, three)):
        of_faces = mesh.materials.face_materials[start : start + len(faces)]
        for face, number in enumerate(of_faces.tolist()):
            own = each.materials.face_materials[face]
            assert (mesh.materials.colors[number] == each.materials.colors[own]).all()
            index, before = mesh.materials.texture_indices[number], each.materials.texture_indices
            assert (index < 0) == (before[own] < 0)
            if index >= 0:
                assert np.array_equal(mesh.textures[int(index)], each.textures[int(before[own])])
    checked_mesh("", mesh)
