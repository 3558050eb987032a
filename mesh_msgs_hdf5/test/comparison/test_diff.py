"""What differs between two meshes: each change of one member is found, and only that one."""
import copy

import h5py
import numpy as np
import pytest
from map_samples import write_s2
from mesh_msgs import zoo

from mesh_msgs_hdf5.comparison.diff import MEMBERS, compare, numbers
from mesh_msgs_hdf5.formats.any_mesh import MeshMembers
from mesh_msgs_hdf5.map_file import MapFile
from mesh_msgs_hdf5.map_file.convert import convert
from mesh_msgs_hdf5.model.mesh import Features, Label, Materials, Mesh


def one_of_everything():
    grid = zoo.grid(4)
    v, f = len(grid.vertices), len(grid.faces)
    rng = np.random.default_rng(1)
    mesh = Mesh(grid.vertices.copy(), grid.faces.copy())
    mesh.vertex_normals = np.tile(np.float32([0, 0, 1]), (v, 1))
    mesh.vertex_colors = rng.integers(0, 256, (v, 3)).astype(np.uint8)
    costs = rng.random(v).astype(np.float32)
    costs[:2] = np.nan, np.inf
    mesh.vertex_costs = {"slope": costs, "rough": costs[::-1].copy()}
    mesh.layer_parameters = {"slope": {"radius": 0.3}}
    mesh.vertex_attributes = {"class": rng.integers(0, 9, (v, 2)).astype(np.uint8)}
    mesh.face_attributes = {"area": rng.random(f), "id": np.arange(f, dtype=np.int64)}
    mesh.face_parameters = {"area": {"unit": "m2"}}
    mesh.texture_coordinates = rng.random((v, 2)).astype(np.float32)
    mesh.textures = {0: rng.integers(0, 256, (4, 5, 3)).astype(np.uint8)}
    mesh.materials = Materials(
        np.zeros((2, 3), np.uint8), np.int32([0, -1]), (np.arange(f) % 2).astype(np.uint32)
    )
    mesh.labels = {"tree_1": Label(np.uint32([3, 1]), (1, 2, 3)), "wall": Label(np.uint32([2]))}
    mesh.features = Features(rng.random((2, 3)).astype("f4"), rng.random((2, 8)).astype("f4"))
    mesh.source = {"file": "a.ply"}
    return mesh


def found(one, other, *arguments, **keywords):
    pair = MeshMembers("one.ply", one), MeshMembers("other.ply", other)
    return compare(*pair, *arguments, **keywords)


def test_a_mesh_is_the_same_as_itself():
    assert found(one_of_everything(), one_of_everything()) == []


def change_label_order(mesh):
    mesh.labels["tree_1"].faces = np.uint32([1, 3])


def set_to(name, value):
    return lambda mesh: setattr(mesh, name, value)


def put(name, index, value):
    def change(mesh):
        target = mesh
        for step in name.split("."):
            target = target[step] if isinstance(target, dict) else getattr(target, step)
        target[index] = value

    return change


# change -> (the members that differ, the member to ignore, its count and maximum)
CHANGES = [
    (put("vertices", (3, 2), 0.5), ["vertices"], "geometry", {"count": 1, "first": 3, "max": 0.5}),
    (put("faces", (2, 0), 9), ["triangles", "faces"], "geometry", {"only_in_one": 1}),
    (put("vertex_normals", (4, 0), 1), ["normals"], "normals", {"count": 1, "max": 1.0}),
    (set_to("vertex_normals", None), ["normals"], "normals", {}),
    (put("vertex_colors", 0, (9, 9, 9)), ["colors"], "colors", {"count": 1, "not_finite": 0}),
    (set_to("vertex_colors", None), ["colors"], "colors", {}),
    (put("vertex_costs.slope", 1, 2), ["layers/slope"], "layers", {"count": 1, "not_finite": 1}),
    (put("vertex_costs.slope", 0, np.inf), ["layers/slope"], "layers", {"not_finite": 1, "max": 0}),
    (
        put("vertex_attributes.class", (3, 1), 99),
        ["attributes/class"],
        "attributes",
        {"count": 1, "first": 3},
    ),
    (put("vertex_costs", "new", np.zeros(25, "f4")), ["layers/new"], "layers", {}),
    (
        put("layer_parameters", "slope", {"radius": 0.4}),
        ["layers/slope/parameters"],
        "layers",
        {"one": {"radius": 0.3}},
    ),
    (put("face_attributes.id", 7, 2**62), ["faces/id"], "faces", {"count": 1, "max": 2.0**62}),
    (put("face_attributes", "id", np.arange(32, dtype="u1")), ["faces/id"], "faces", {}),
    (put("face_parameters", "area", {}), ["faces/area/parameters"], "faces", {}),
    (put("texture_coordinates", 3, 0), ["texture_coordinates"], "textures", {"count": 1}),
    (put("textures", 0, np.zeros((5, 4, 3), "u1")), ["textures/0"], "textures", {"one": (4, 5, 3)}),
    (put("textures", 3, np.zeros((5, 4, 3), "u1")), ["textures/3"], "textures", {}),
    (put("materials.face_materials", 5, 0), ["materials/faces"], "textures", {"count": 1}),
    (set_to("materials", None), ["materials"], "textures", {}),
    (
        put("labels", "wall", Label(np.uint32([2, 3, 4]))),
        ["labels/wall"],
        "labels",
        {"added": 2, "removed": 0},
    ),
    (put("labels", "wall", Label(np.uint32([2]), (0, 0, 0))), ["labels/wall"], "labels", {}),
    (lambda mesh: mesh.labels.pop("wall"), ["labels/wall"], "labels", {}),
    (change_label_order, [], "labels", {}),
    (put("features.locations", 1, 9), ["features/locations"], "features", {"count": 1}),
    (set_to("frame_id", "odom"), ["frame_id"], "frame", {"one": "map", "other": "odom"}),
    (set_to("crs", "EPSG:25832"), ["crs"], "frame", {}),
    (set_to("origin", (1.0, 2.0, 3.0)), ["origin"], "origin", {"one": [0, 0, 0]}),
    (put("source", "file", "b.ply"), ["source"], "source", {}),
]


@pytest.mark.parametrize("number", range(len(CHANGES)))
def test_each_change_is_found_and_can_be_ignored(number):
    change, members, ignored, details = CHANGES[number]
    one, other = one_of_everything(), one_of_everything()
    change(other)
    differences = found(one, other)
    assert [difference.member for difference in differences] == members
    if members:
        assert {key: differences[0].details[key] for key in details} == details
        assert all(difference.line().startswith(difference.member) for difference in differences)
    assert found(one, other, ignore=(ignored,)) == []
    backwards = [difference.member for difference in found(other, one)]
    assert sorted(backwards) == sorted(members)


def test_the_tolerance_is_that_of_numbers():
    one, other = one_of_everything(), one_of_everything()
    other.vertices = other.vertices + np.float32([0.001, 0, 0])
    other.vertex_costs["slope"] = other.vertex_costs["slope"] + np.float32(0.001)
    other.face_attributes["area"] = other.face_attributes["area"] + 0.001
    assert {d.member for d in found(one, other)} == {"vertices", "layers/slope", "faces/area"}
    assert found(one, other, 0.0011) == []
    assert len(found(one, other, 0.0009)) == 3


def test_the_same_surface_in_another_order_and_split_at_seams():
    mesh = zoo.sphere(2)
    order = np.random.default_rng(2).permutation(len(mesh.vertices))
    place = np.argsort(order)
    faces = np.roll(place[mesh.faces], 1, axis=1)[::-1].astype(np.uint32)
    one, shuffled = Mesh(mesh.vertices, mesh.faces), Mesh(mesh.vertices[order], faces)
    same = {d.member: d for d in found(one, shuffled)}
    assert same["triangles"].kind == "same" and set(same) == {"vertices", "faces", "triangles"}
    soup = mesh.vertices[mesh.faces.ravel()]
    soup = Mesh(soup, np.arange(len(soup), dtype=np.uint32).reshape(-1, 3))
    soup.vertex_costs["x"], one.vertex_costs["x"] = (
        np.zeros(len(soup.vertices), "f4"),
        one.vertices[:, 0],
    )
    split = {d.member: d for d in found(one, soup)}
    assert split["triangles"].kind == "same" and split["vertices"].kind == "count"
    assert split["layers/x"].kind == "count"
    flipped = copy.deepcopy(soup)
    flipped.faces[3] = flipped.faces[3, ::-1]
    details = {d.member: d for d in found(one, flipped)}["triangles"].details
    assert details == {"only_in_one": 1, "only_in_other": 1}
    fewer = Mesh(mesh.vertices, mesh.faces[5:])
    details = {d.member: d for d in found(one, fewer)}["triangles"].details
    assert details == {"only_in_one": 5, "only_in_other": 0}


@pytest.mark.parametrize("dtype", ["f4", "f8", "u1", "i4", "u8", "i8"])
def test_numbers_against_a_loop(dtype):
    rng = np.random.default_rng(5)
    one = rng.integers(0, 100, (50, 2)).astype(dtype)
    other = one + (rng.random((50, 2)) < 0.1).astype(dtype) * np.array(3, dtype)
    if dtype[0] == "f":
        one[3, 0] = other[3, 0] = np.nan
        one[4, 1], other[4, 1] = np.nan, np.inf
    rows = [i for i in range(50) if repr(one[i].tolist()) != repr(other[i].tolist())]
    (difference,) = numbers("x", one, other, 0.0)
    assert difference.details["count"] == len(rows) and difference.details["first"] == rows[0]
    assert difference.details["max"] == 3 and difference.details["not_finite"] == (dtype[0] == "f")
    only_special = list(numbers("x", one, other, 3.0))
    assert len(only_special) == (dtype[0] == "f")


def test_names_of_members_are_all_there():
    assert len(set(MEMBERS)) == 13 and {case[2] for case in CHANGES} == set(MEMBERS) - {"other"}


@pytest.mark.parametrize("side", ["A", "B"])
def test_the_sentence_says_on_which_side_a_layer_is(side):
    whole, less = one_of_everything(), one_of_everything()
    less.vertex_costs = {}
    pair = (whole, less) if side == "A" else (less, whole)
    lines = [difference.line() for difference in found(*pair)]
    for layer in ("slope", "rough"):
        assert "layers/%s: only in %s" % (layer, side) in lines


def test_what_another_layout_keeps_in_a_group_is_not_missing(tmp_path, rich_mesh):
    """S2 names what is in /mesh/edge_attributes, and S1 the group, of which it knows nothing."""
    one, other = tmp_path / "s2.h5", tmp_path / "s1.h5"
    write_s2(one, rich_mesh)
    convert(one, other)
    named = [MapFile(path).other_contents() for path in (one, other)]
    edges = "/mesh/edge_attributes/edge_distances"
    assert edges in named[0] and "/mesh/edge_attributes" in named[1]
    for pair in ((one, other), (other, one)):
        differences = compare(*(MapFile(path) for path in pair))
        assert not [d.member for d in differences if d.member.startswith("other")], differences
    with h5py.File(other, "r+") as file:
        del file[edges]
        file["mesh/edge_attributes/more"] = np.zeros(3)
    differences = compare(MapFile(one), MapFile(other))
    assert [(d.member, d.kind) for d in differences if d.member.startswith("other")] == [
        ("other" + edges, "only in one"),
        ("other/mesh/edge_attributes/more", "only in other"),
    ]
