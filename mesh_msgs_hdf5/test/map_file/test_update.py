"""An edit changes what it says; everything else in the file stays, bit for bit."""
import copy
import os

import h5py
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from map_samples import assert_same_mesh
from raw_contents import add_strange_things, raw_contents, without

from mesh_msgs_hdf5.map_file import MapFile
from mesh_msgs_hdf5.map_file.convert import convert
from mesh_msgs_hdf5.map_file.writing import map_saving
from mesh_msgs_hdf5.model.edit import Edit
from mesh_msgs_hdf5.model.errors import MapFileError
from mesh_msgs_hdf5.model.mesh import Features, Label, Materials, Mesh

IN_MEMORY, ON_DISK = 1 << 40, 0


@pytest.fixture(scope="module", params=["s1", "lvr2"])
def form(request):
    """In which form the textures are."""
    return request.param


@pytest.fixture(scope="module")
def strange(tmp_path_factory, rich_data, form):
    """(bytes, raw contents, other contents) of a map of rich_mesh, with strange things in it."""
    folder = tmp_path_factory.mktemp("strange")
    path = folder / "a.h5"
    path.write_bytes(rich_data)
    if form == "lvr2":
        convert(path, folder / "b.h5", profile="lvr2")
        os.replace(folder / "b.h5", path)
    add_strange_things(path)
    return path.read_bytes(), raw_contents(path), MapFile(path).other_contents()


def apply(mesh, edit):
    """The Mesh after an edit, from the description of Edit."""
    mesh = copy.deepcopy(mesh)
    for name in ("vertex_costs", "face_attributes", "labels", "textures"):
        members = getattr(mesh, name)
        for key, value in getattr(edit, name).items():
            members.pop(key, None)
            if value is not None:
                members[key] = value
    for name, members in (("layer", "vertex_costs"), ("face", "face_attributes")):
        parameters = getattr(mesh, name + "_parameters")
        for key in getattr(edit, members):
            parameters.pop(key, None)
        for key, value in getattr(edit, name + "_parameters").items():
            parameters.pop(key, None)
            if value and key in getattr(mesh, members):
                parameters[key] = value
    for name in ("vertex_normals", "vertex_colors", "texture_coordinates", "materials"):
        if getattr(edit, name) is not None:
            setattr(mesh, name, getattr(edit, name))
    for name in ("features", "frame_id", "origin", "crs", "source"):
        if getattr(edit, name) is not None:
            setattr(mesh, name, getattr(edit, name))
    for name in edit.remove:
        setattr(mesh, name, None)
    return mesh


RNG = np.random.default_rng(5)
NEW_COSTS = RNG.random(40).astype("f4")
IMAGE = RNG.integers(0, 256, (9, 4, 3)).astype("u1")
MATERIALS = Materials(np.zeros((1, 3), "u1"), np.array([7], "i4"), np.zeros(60, "u4"))
# name -> (edit, what it changes below the part, in each form of the textures)
IMAGES = {"s1": "textures/images/", "lvr2": "textures/"}
MATERIAL_PATHS = {
    "s1": ["textures/materials", "textures/mat_face_indices"],
    "lvr2": [
        "materials/texture_handles",
        "materials/rgb_color",
        "channels/face_material_indices",
    ],
}
COORDINATES = {"s1": "textures/coords", "lvr2": "channels/texture_coordinates"}
EDITS = {
    "layer added": (Edit(vertex_costs={"new": NEW_COSTS}), ["channels/new"]),
    "layer with parameters": (
        Edit(vertex_costs={"new": NEW_COSTS}, layer_parameters={"new": {"a": [1, "ä"]}}),
        ["channels/new"],
    ),
    "layer replaced": (
        Edit(vertex_costs={"height_diff": NEW_COSTS}),
        ["channels/height_diff"],
    ),
    "layer removed": (Edit(vertex_costs={"height_diff": None}), ["channels/height_diff"]),
    "layer renamed": (
        Edit(vertex_costs={"height_diff": None, "steep": NEW_COSTS}),
        ["channels/height_diff", "channels/steep"],
    ),
    "parameters alone": (
        Edit(layer_parameters={"height_diff": {"radius": 0.5}}),
        ["channels/height_diff"],
    ),
    "parameters removed": (
        Edit(layer_parameters={"height_diff": None}, face_parameters={"cost": None}),
        ["channels/height_diff", "face_attributes/cost"],
    ),
    "face attributes": (
        Edit(
            face_attributes={"cost": None, "segment": np.arange(60, dtype="u1")},
            face_parameters={"segment": {"k": 3}},
        ),
        ["face_attributes/cost", "face_attributes/segment"],
    ),
    "label added": (
        Edit(labels={"car_3": Label(np.array([3, 1], "u4"), (1, 2, 3))}),
        ["labels/car"],
    ),
    "label in a class that is there": (
        Edit(labels={"tree_3": Label(np.arange(50, dtype="u4"))}),
        ["labels/tree/3"],
    ),
    "label replaced": (
        Edit(labels={"tree_1": Label(np.arange(9, dtype="u4"))}),
        ["labels/tree/1"],
    ),
    "label removed": (Edit(labels={"tree_1": None}), ["labels/tree/1"]),
    "last label of a class removed": (Edit(labels={"_x": None}), ["labels/%"]),
    "free labels": (
        Edit(labels={"grass": None, "grass_": Label(np.array([5], "u4"))}),
        ["labels/grass"],
    ),
    "label renamed within its class": (
        Edit(labels={"_x": None, "_y": Label(np.array([2], "u4"))}),
        ["labels/%"],
    ),
    "texture replaced": (Edit(textures={10: IMAGE}), ["IMAGES10"]),
    "texture added": (Edit(textures={7: IMAGE}), ["IMAGES7"]),
    "texture and materials": (
        Edit(textures={0: None, 2: None, 10: None, 7: IMAGE}, materials=MATERIALS),
        ["IMAGES0", "IMAGES2", "IMAGES10", "IMAGES7", "MATERIALS"],
    ),
    "no textures": (
        Edit(
            textures={0: None, 2: None, 10: None},
            remove=frozenset({"materials", "texture_coordinates"}),
        ),
        ["IMAGES0", "IMAGES2", "IMAGES10", "MATERIALS", "COORDINATES"],
    ),
    "texture coordinates": (
        Edit(texture_coordinates=np.zeros((40, 2), "f4")),
        ["COORDINATES"],
    ),
    "normals and colors": (
        Edit(vertex_normals=np.ones((40, 3), "f4"), vertex_colors=np.ones((40, 3), "u1")),
        ["channels/vertex_normals", "channels/vertex_colors"],
    ),
    "no normals and colors": (
        Edit(remove=frozenset({"vertex_normals", "vertex_colors"})),
        ["channels/vertex_normals", "channels/vertex_colors"],
    ),
    "features": (
        Edit(features=Features(np.ones((3, 3), "f4"), np.ones((3, 2), "f4"))),
        ["channels/texture_features/%d" % i for i in range(12)],
    ),
    "no features": (
        Edit(remove=frozenset({"features"})),
        ["channels/texture_features/%d" % i for i in range(12)],
    ),
    "header": (
        Edit(frame_id="odom", origin=(1.0, 2.0, 3.0), crs="EPSG:4326", source={"a": 1}),
        [],
    ),
    "header as if it said nothing": (Edit(origin=(0.0, 0.0, 0.0), crs="", source={}), []),
}


def changed_paths(places, form):
    for place in places:
        if place == "MATERIALS":
            yield from ("/mesh/" + inner for inner in MATERIAL_PATHS[form])
        elif place == "COORDINATES":
            yield "/mesh/" + COORDINATES[form]
        else:
            yield "/mesh/" + place.replace("IMAGES", IMAGES[form])


def without_header(contents):
    """All but the attributes of the part that an edit may set."""
    kind, attributes = contents["/mesh"]
    own = ("frame_id", "origin", "crs", "source")
    kept = {name: value for name, value in attributes.items() if name not in own}
    return {**contents, "/mesh": (kind, kept)}


@pytest.mark.parametrize("name", EDITS)
def test_an_edit_changes_what_it_says_and_nothing_else(
    tmp_path, strange, rich_mesh, monkeypatch, form, name
):
    """Built in memory for one form of the textures, on disk for the other."""
    turn = list(EDITS).index(name) + (form == "lvr2")
    monkeypatch.setattr(map_saving, "MEMORY_BUDGET", (IN_MEMORY, ON_DISK)[turn % 2])
    edit, places = EDITS[name]
    skip = set(changed_paths(places, form))
    data, whole, others = strange
    path = tmp_path / "a.h5"
    path.write_bytes(data)
    file = MapFile(path)
    file.update(edit)
    changed = raw_contents(path)
    before, after = without(whole, skip), without(changed, skip)
    if name.startswith("header"):
        before, after = without_header(before), without_header(after)
    assert after == before and len(before) > 40
    assert changed != whole
    assert_same_mesh(file.read(), apply(rich_mesh, edit))
    assert file.other_contents() == others
    assert os.listdir(tmp_path) == ["a.h5"]


def test_the_map_before_the_edits(tmp_path, strange, rich_mesh):
    """It reads as the mesh; and what the test above looks at is what raw_contents() leaves out."""
    data, whole, _ = strange
    (tmp_path / "a.h5").write_bytes(data)
    assert_same_mesh(MapFile(tmp_path / "a.h5").read(), rich_mesh)
    for skip in (["/mesh/channels"], ["/mesh/labels/%", "/raw"], ["/mesh/channels/height_diff"]):
        assert without(whole, skip) == raw_contents(tmp_path / "a.h5", skip) != whole


def test_a_label_of_another_program_keeps_its_place(tmp_path, rich_mesh):
    path = tmp_path / "a.h5"
    file = MapFile.write(path, rich_mesh)
    with h5py.File(path, "r+") as raw:
        raw["mesh/labels/big_tree/4"] = np.arange(3, dtype="u4")
        raw["mesh/labels/whole"] = np.arange(3, dtype="u4")
    assert file.label("big_tree_4").faces.tolist() == [0, 1, 2]
    file.update(Edit(labels={"big_tree_4": Label([9]), "whole_1": Label([8])}))
    with h5py.File(path, "r") as raw:
        assert raw["mesh/labels/big_tree/4"][:].tolist() == [9]
        assert not raw["mesh/labels/big_tree/4"].attrs and "big" not in raw["mesh/labels"]
        assert raw["mesh/labels/whole"][:].tolist() == [0, 1, 2]
    assert file.label("big_tree_4").faces.tolist() == [9]
    assert file.label("whole_1").faces.tolist() == [8]
    file.update(Edit(labels={"big_tree_4": None, "whole_1": None}))
    with h5py.File(path, "r") as raw:
        assert "big_tree" not in raw["mesh/labels"] and "whole (2)" not in raw["mesh/labels"]
    assert_same_mesh(file.read(), rich_mesh)


def test_an_empty_edit_does_not_touch_the_file(tmp_path, full_mesh):
    path = tmp_path / "a.h5"
    file = MapFile.write(path, full_mesh)
    before = os.stat(path)
    file.update(Edit())
    file.write_layers({})
    assert os.stat(path) == before


def test_to_remove_what_is_not_there_is_no_error(tmp_path, full_mesh):
    path = tmp_path / "a.h5"
    file = MapFile.write(path, full_mesh)
    before = raw_contents(path)
    file.update(
        Edit(
            vertex_costs={"gone": None},
            face_attributes={"gone": None},
            labels={"gone_1": None},
            textures={3: None},
            layer_parameters={"gone": None},
            remove=frozenset({"materials", "features", "texture_coordinates"}),
        )
    )
    assert raw_contents(path) == before
    assert_same_mesh(file.read(), full_mesh)


@pytest.mark.parametrize(
    "edit,code,words",
    [
        (Edit(vertex_costs={"new": np.ones(39)}), "shape", "layer new"),
        (Edit(vertex_costs={"vertices": None}), "layer", "kept for mesh data"),
        (Edit(vertex_costs={"taken": np.ones(40)}), "layer", "/mesh/channels/taken is there"),
        (Edit(layer_parameters={"gone": {"a": 1}}), "layer", "no layer 'gone'"),
        (Edit(face_parameters={"gone": {"a": 1}}), "layer", "no face attribute 'gone'"),
        (
            Edit(vertex_costs={"height_diff": None}, layer_parameters={"height_diff": {"a": 1}}),
            "layer",
            "no layer 'height_diff'",
        ),
        (Edit(layer_parameters={"height_diff": [1]}), "value", "no dict"),
        (Edit(face_attributes={"a/b": None}), "layer", "slash"),
        (Edit(face_attributes={"x": np.ones(59)}), "shape", "face attribute x"),
        (Edit(labels={"a/b": None}), "label", "slash"),
        (Edit(labels={"tree_1": Label([60])}), "index", "60"),
        (Edit(textures={0: None}), "index", "material 0 has the texture 0, which is not there"),
        (Edit(materials=MATERIALS), "index", "texture 7"),
        (Edit(textures={-1: IMAGE}), "index", "-1"),
        (Edit(vertex_normals=np.ones((39, 3))), "shape", "vertex_normals"),
        (Edit(vertex_colors=np.full((40, 3), 256)), "dtype", "vertex_colors"),
        (Edit(texture_coordinates=np.full((40, 2), np.nan)), "not_finite", "row 0"),
        (Edit(features=Features(np.ones((1, 2)), np.ones((1, 2)))), "shape", "locations"),
        (Edit(vertex_costs=[1]), "value", "vertex_costs of the edit is a list, not a dict"),
        (Edit(vertex_costs={1: np.ones(40)}), "value", "vertex_costs of the edit has the key 1"),
        (Edit(textures={"1": IMAGE}), "value", "textures of the edit has the key '1'"),
        (Edit(labels={"tree_1": [1]}), "value", "label 'tree_1' is a list, not a Label"),
        (Edit(materials=(1, 2, 3)), "value", "materials of the edit is a tuple, not a Materials"),
        (Edit(features=[1]), "value", "features of the edit is a list, not a Features"),
        (Edit(frame_id=3), "value", "frame_id of the edit is a int, not a str"),
        (Edit(frame_id="/x"), "frame", "slash"),
        (Edit(origin=(1, 2)), "value", "origin"),
        (Edit(crs="\n"), "value", "crs"),
        (Edit(source=[]), "value", "source"),
        (Edit(remove=frozenset({"vertices"})), "value", "cannot be removed"),
        (
            Edit(materials=MATERIALS, remove=frozenset({"materials"})),
            "value",
            "both given and to be removed",
        ),
    ],
)
def test_a_bad_edit_is_refused_and_changes_nothing(tmp_path, rich_data, edit, code, words):
    path = tmp_path / "a.h5"
    path.write_bytes(rich_data)
    file = MapFile(path)
    with h5py.File(path, "r+") as raw:
        raw["mesh/channels/taken"] = np.zeros(3, "i4")  # no layer
    before = path.read_bytes()
    with pytest.raises(MapFileError) as refused:
        file.update(edit)
    assert path.read_bytes() == before and os.listdir(tmp_path) == ["a.h5"]
    assert refused.value.code == code and words in str(refused.value)


@pytest.mark.parametrize("layout", ["s0", "s2", "meshes/x"])
def test_files_of_other_schemas_are_not_edited(tmp_path, full_mesh, layout):
    path = tmp_path / "a.h5"
    names = {
        "s0": ("geometry/vertices", "geometry/faces"),
        "s2": ("mesh/geometry/vertices", "mesh/geometry/face_indices"),
        "meshes/x": ("meshes/x/vertices", "meshes/x/indices"),
    }[layout]
    with h5py.File(path, "w") as raw:
        if layout == "s0":
            for name in ("attributes", "clustersets", "textures", "labels"):
                raw.create_group(name)
        raw[names[0]], raw[names[1]] = full_mesh.vertices, full_mesh.faces
    before = path.read_bytes()
    with pytest.raises(MapFileError, match="mesh_tool convert") as refused:
        MapFile(path).update(Edit(vertex_costs={"x": NEW_COSTS}))
    assert refused.value.code == "schema" and path.read_bytes() == before


def test_a_file_in_another_format_generation(tmp_path, full_mesh):
    """Dense groups and attributes above 64 kB, as libver latest writes them; a user block."""
    path = tmp_path / "a.h5"
    MapFile.write(tmp_path / "b.h5", full_mesh)
    with h5py.File(tmp_path / "b.h5", "r") as old:
        with h5py.File(path, "w", libver="latest", userblock_size=512, track_order=True) as file:
            old.copy("mesh", file)
            file.attrs["long"] = np.zeros(100_000)
            for name in "zyx":
                file.create_group(name).attrs["long"] = np.arange(50_000)
    with open(path, "r+b") as raw:
        raw.write(b"the user's own 512 bytes")
    skip = ["/mesh/channels/new"]
    before = raw_contents(path, skip)
    MapFile(path).update(Edit(vertex_costs={"new": NEW_COSTS}))
    assert raw_contents(path, skip) == before
    assert path.read_bytes()[:24] == b"the user's own 512 bytes"
    with h5py.File(path, "r") as file:
        assert list(file["/"]) == ["mesh", "z", "y", "x"]


TEXTS = st.sampled_from(["tree_1", "tree_2", "tree", "tree_", "a_b_c", "ä ö", "_", "%", "x_."])
NAMES = st.sampled_from(["height_diff", "Grün und weich", "new", "b", "%", "(2)"])
COLORS = st.none() | st.tuples(*[st.integers(0, 255)] * 3)


@st.composite
def edits(draw):
    seed = np.random.default_rng(draw(st.integers(0, 2**32)))
    costs = st.none() | st.builds(lambda: seed.random(40).astype("f4"))
    values = st.none() | st.builds(
        lambda kind: seed.integers(0, 100, 60).astype(kind), st.sampled_from(["u1", "f8", "i2"])
    )
    labels = st.none() | st.builds(
        lambda count, color: Label(seed.permutation(60)[:count].astype("u4"), color),
        st.integers(0, 60),
        COLORS,
    )
    edit = Edit(
        vertex_costs=draw(st.dictionaries(NAMES, costs, max_size=3)),
        face_attributes=draw(st.dictionaries(NAMES, values, max_size=2)),
        labels=draw(st.dictionaries(TEXTS, labels, max_size=4)),
        vertex_colors=draw(
            st.none() | st.builds(lambda: seed.integers(0, 256, (40, 3)).astype("u1"))
        ),
        crs=draw(st.none() | st.sampled_from(["", "EPSG:1"])),
        origin=draw(st.none() | st.sampled_from([(0.0, 0.0, 0.0), (1.5, -2.0, 1e7)])),
    )
    edit.layer_parameters = {
        name: draw(st.none() | st.just({"n": 1}))
        for name, costs in edit.vertex_costs.items()
        if costs is not None
    }
    if edit.vertex_colors is None and draw(st.booleans()):
        edit.remove = frozenset({"vertex_colors"})
    return edit


@settings(max_examples=40)
@given(sequence=st.lists(edits(), max_size=5))
def test_any_sequence_of_edits(tmp_path, full_mesh, sequence):
    path = tmp_path / "a.h5"
    file = MapFile.write(path, full_mesh)
    model = copy.deepcopy(full_mesh)
    for edit in sequence:
        file.update(edit)
        model = apply(model, edit)
        assert_same_mesh(file.read(), model)
        assert file.other_contents() == []
    assert_same_mesh(MapFile.write(tmp_path / "b.h5", model).read(), model)


def test_labels_on_a_mesh_of_two_parts(tmp_path, full_mesh):
    """An edit of one part leaves the other."""
    path = tmp_path / "a.h5"
    MapFile.write(path, full_mesh, part="storey/1")
    MapFile.write(tmp_path / "b.h5", Mesh(full_mesh.vertices + 1, full_mesh.faces), part="x")
    with h5py.File(path, "r+") as file, h5py.File(tmp_path / "b.h5", "r") as other:
        other.copy("x", file["storey"], "2")
    one, two = MapFile(path, "storey/1"), MapFile(path, "storey/2")
    before = two.read()
    one.update(Edit(labels={"a_1": Label([1])}, remove=frozenset({"vertex_colors"})))
    assert_same_mesh(two.read(), before)
    two.update(Edit(labels={"b_1": Label([2])}))
    assert one.label_names() == ["a_1"] and two.label_names() == ["b_1"]


@pytest.mark.parametrize("part", ["", "storey/2"])
def test_parts_of_other_names(tmp_path, rich_mesh, part):
    path = tmp_path / "a.h5"
    file = MapFile.write(path, rich_mesh, part=part)
    add_strange_things(path, part)
    skip = ["/".join(["", part, "channels", "new"]).replace("//", "/")]
    before = raw_contents(path, skip)
    edit = Edit(vertex_costs={"new": NEW_COSTS})
    file.update(edit)
    assert raw_contents(path, skip) == before
    assert_same_mesh(file.read(), apply(rich_mesh, edit))


def test_what_is_stored_elsewhere_stays_there(tmp_path, full_mesh):
    """External storage and virtual datasets are carried over as what they are, and not read."""
    path = tmp_path / "a.h5"
    file = MapFile.write(path, full_mesh)
    secret = tmp_path / "secret.txt"
    secret.write_bytes(b"the password is 1234" * 100)
    with h5py.File(tmp_path / "source.h5", "w") as source:
        source["v"] = np.full((40, 3), 42, "f4")
    with h5py.File(path, "r+") as raw:
        external = [(str(secret), 0, 480)]
        raw.create_dataset("outside", (40, 3), "f4", external=external)
        layout = h5py.VirtualLayout((40, 3), "f4")
        layout[:] = h5py.VirtualSource(tmp_path / "source.h5", "v", shape=(40, 3))
        raw.create_virtual_dataset("virtual", layout)
    file.update(Edit(vertex_costs={"new": NEW_COSTS}))
    assert b"password" not in path.read_bytes()
    with h5py.File(path, "r") as raw:
        assert [(name, start, size) for name, start, size in raw["outside"].external] == external
        (source,) = raw["virtual"].virtual_sources()
        assert source.file_name == str(tmp_path / "source.h5") and source.dset_name == "v"
        assert (raw["virtual"][()] == 42).all() and raw["outside"][()].tobytes()[:3] == b"the"
    os.unlink(secret)
    os.unlink(tmp_path / "source.h5")
    file.update(Edit(vertex_costs={"new": None}))
    assert "new" not in file.layer_names()
    with h5py.File(path, "r") as raw:
        assert raw["virtual"].is_virtual and raw["outside"].external


@pytest.mark.parametrize("budget", [IN_MEMORY, ON_DISK])
def test_what_has_several_names_keeps_them(tmp_path, full_mesh, monkeypatch, budget):
    """Names that come before and after those that the edit uses; of the part and in it."""
    monkeypatch.setattr(map_saving, "MEMORY_BUDGET", budget)
    path = tmp_path / "a.h5"
    file = MapFile.write(path, full_mesh)
    with h5py.File(path, "r+") as raw:
        part = raw["mesh"]
        raw["a mesh"] = raw["z/mesh"] = part
        part["a channels"] = part["channels"]
        part["channels/a"] = part["channels/zz"] = part["channels/height_diff"]
        link = raw.create_dataset("link", (1,), dtype=h5py.ref_dtype)
        link[0] = raw["a mesh/channels/height_diff"].ref
    costs = file.vertex_costs("height_diff")
    file.update(Edit(frame_id="odom", vertex_costs={"height_diff": NEW_COSTS}))
    with h5py.File(path, "r") as raw:
        part = raw["mesh"]
        assert raw["a mesh"] == raw["z/mesh"] == part and part.attrs["frame_id"] == b"odom"
        assert part["a channels"] == part["channels"]
        assert part["channels/a"] == part["channels/zz"] != part["channels/height_diff"]
        assert raw[raw["link"][0]] == part["channels/a"]
        np.testing.assert_array_equal(part["channels/height_diff"][:, 0], NEW_COSTS)
        np.testing.assert_array_equal(part["channels/a"][:, 0], costs)
    mesh = file.read()
    assert mesh.frame_id == "odom" and {"a", "height_diff", "zz"} <= set(mesh.vertex_costs)


def test_groups_that_lead_back_or_are_too_deep_are_refused(tmp_path, full_mesh):
    """HDF5 copies group in group by recursion in C, on a stack that ends."""
    path = tmp_path / "a.h5"
    for code, words in (("link", "/raw/up leads back to the root"), ("size", "200 deep")):
        file = MapFile.write(path, full_mesh)
        with h5py.File(path, "r+") as raw:
            group = raw.create_group("raw")
            if code == "link":
                group["up"] = raw["/"]
            else:
                for _ in range(300):
                    group = group.create_group("g")
        before = path.read_bytes()
        with pytest.raises(MapFileError) as refused:
            file.update(Edit(vertex_costs={"new": NEW_COSTS}))
        assert refused.value.code == code and words in str(refused.value)
        assert path.read_bytes() == before
    with h5py.File(path, "r+") as raw:
        del raw["raw"]
        raw["raw/a/b"] = raw["mesh"]  # a circle that does not go through the root
        raw["mesh/raw"] = raw["raw"]
    skip = ["/mesh/channels/new", "/mesh/raw", "/raw/a/b"]
    before = raw_contents(path, skip)
    file.update(Edit(vertex_costs={"new": NEW_COSTS}))
    assert raw_contents(path, skip) == before
    with h5py.File(path, "r") as raw:
        assert raw["raw/a/b"] == raw["mesh"] and raw["mesh/raw"] == raw["raw"]
