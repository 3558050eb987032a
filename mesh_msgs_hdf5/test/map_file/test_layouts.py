"""Files of every layout in the field are read bit for bit; each bad one is refused by name."""
import h5py
import numpy as np
import pytest
from map_samples import (
    MATERIAL,
    SAMPLES,
    assert_same,
    assert_same_mesh,
    write_hdf5_map_io,
    write_image,
    write_lvr2_l1,
    write_mesh_io,
    write_model_factory,
    write_s0,
    write_s2,
)

from mesh_msgs_hdf5.map_file import MapFile
from mesh_msgs_hdf5.map_file.hdf5.hdf5_files import reading
from mesh_msgs_hdf5.map_file.reading.map_reader import MapReader
from mesh_msgs_hdf5.model.errors import MapFileError
from mesh_msgs_hdf5.model.mesh import Label


def own_paths(path, part=None):
    with reading(path) as file:
        return MapReader(file, path, part).own_paths()


@pytest.mark.parametrize("name", SAMPLES)
def test_every_layout_is_read_as_it_was_put_in(tmp_path, rich_mesh, name):
    path = tmp_path / "a.h5"
    expected = SAMPLES[name](path, rich_mesh)
    file = MapFile(path)
    assert_same_mesh(file.read(), expected)
    schema, part = {
        "S0": ("S0", ""),
        "S2": ("S2", "mesh"),
        "model_factory": ("meshes", "meshes/garden"),
        "mesh_io": ("meshes", "meshes/garden"),
    }.get(name, ("S1", "mesh"))
    assert (file.schema, file.part, file.parts) == (schema, part, [part])
    assert file.schema_version == 0 and file.uuid == expected.uuid


@pytest.mark.parametrize("name", SAMPLES)
def test_each_member_alone_is_that_of_read(tmp_path, rich_mesh, name):
    path = tmp_path / "a.h5"
    mesh = SAMPLES[name](path, rich_mesh)
    file = MapFile(path)
    assert (file.vertex_count, file.face_count) == (40, 60)
    assert file.has_normals == (mesh.vertex_normals is not None)
    assert file.has_colors == (mesh.vertex_colors is not None)
    for member in (
        "vertices",
        "faces",
        "vertex_normals",
        "vertex_colors",
        "texture_coordinates",
        "materials",
        "features",
        "frame_id",
        "origin",
        "crs",
        "source",
    ):
        assert_same(getattr(file, member), getattr(mesh, member), member)
    assert file.layer_names() == sorted(mesh.vertex_costs)
    assert file.face_attribute_names() == sorted(mesh.face_attributes)
    assert file.texture_indices() == sorted(mesh.textures)
    assert file.label_names() == sorted(mesh.labels)
    for layer, costs in mesh.vertex_costs.items():
        assert_same(file.vertex_costs(layer), costs, layer)
        assert file.layer_parameters(layer) == {}
    for attribute, values in mesh.face_attributes.items():
        assert_same(file.face_attribute(attribute), values, attribute)
        assert file.face_parameters(attribute) == {}
    for index, image in mesh.textures.items():
        assert_same(file.texture(index), image, "texture")
    for text, label in mesh.labels.items():
        assert_same(file.label(text), label, text)
    assert_same(file.labels(), mesh.labels, "labels")


OTHERS = {
    "S0": [],
    "hdf5_map_io": [],
    "lvr2_l1": ["channels/edge_distances", "channels/edge_distances_idx", "channels/face_normals"],
    "S2": ["edge_attributes/edge_distances", "edge_attributes/edge_distances_idx"],
    "model_factory": [],
    "mesh_io": ["faces/materials", "materials", "surfaces", "vertices/texture_coordinates"],
}


@pytest.mark.parametrize("name", SAMPLES)
def test_all_that_is_not_in_the_mesh_is_named(tmp_path, rich_mesh, name):
    path = tmp_path / "a.h5"
    SAMPLES[name](path, rich_mesh)
    file = MapFile(path)
    prefix = "/" + file.part + "/" if file.part else "/"
    assert file.other_contents() == [prefix + place for place in OTHERS[name]]
    with h5py.File(path, "a") as raw:
        raw["raw/scans/0"] = np.zeros(9)
        raw[prefix + "labels/no_label"] = np.zeros(2, "u4")
        raw[prefix + "notes"] = "text"
    found = MapFile(path).other_contents()
    assert {"/raw", prefix + "notes"} < set(found) and found == sorted(found)
    labels = prefix + "labels" if file.schema == "meshes" else prefix + "labels/no_label"
    assert labels in found and len(found) == len(OTHERS[name]) + 3


@pytest.mark.parametrize("name", SAMPLES)
def test_own_paths_and_the_others_are_all_of_the_file(tmp_path, rich_mesh, name):
    """So that a conversion that writes the mesh and copies the others loses nothing."""
    path = tmp_path / "a.h5"
    SAMPLES[name](path, rich_mesh)
    own, others = own_paths(path), MapFile(path).other_contents()
    datasets = []
    with h5py.File(path, "r") as file:
        file.visititems(
            lambda place, item: datasets.append("/" + place)
            if isinstance(item, h5py.Dataset)
            else None
        )
        assert all(isinstance(file[place], h5py.Dataset) or not len(file[place]) for place in own)
    below = [x for x in datasets if any(x == o or x.startswith(o + "/") for o in others)]
    assert set(datasets) == (own & set(datasets)) | set(below)
    assert not own & set(below)


def test_an_array_where_a_group_should_be_is_something_else(tmp_path, rich_mesh):
    path = tmp_path / "a.h5"
    expected = write_hdf5_map_io(path, rich_mesh)
    with h5py.File(path, "a") as file:
        file["mesh/materials"] = np.zeros(3)
        del file["mesh/clustersets"]
        file["mesh/clustersets"] = h5py.SoftLink("/mesh/channels")
    assert MapFile(path).other_contents() == ["/mesh/clustersets", "/mesh/materials"]
    assert_same_mesh(MapFile(path).read(), expected)


def test_label_paths_lead_to_the_labels(tmp_path, rich_mesh):
    path = tmp_path / "a.h5"
    write_s2(path, rich_mesh)
    with reading(path) as file:
        paths = MapReader(file, path).label_paths()
    assert paths == {"tree_1": ("tree", "1"), "tree_2": ("tree", "2")}


# parts


@pytest.mark.parametrize("write", [write_hdf5_map_io, write_lvr2_l1, write_s2])
@pytest.mark.parametrize("part", ["mesh", "upper floor", "a/b", "a/b/c", ""])
def test_a_part_may_have_any_name_and_be_the_root(tmp_path, rich_mesh, write, part):
    path = tmp_path / "a.h5"
    expected = write(path, rich_mesh, part=part)
    for file in (MapFile(path), MapFile(path, part), MapFile(path, "/%s/" % part)):
        assert file.part == part and file.parts == [part]
        assert_same_mesh(file.read(), expected)


def test_a_deeper_part_is_found_only_by_its_name(tmp_path, rich_mesh):
    path = tmp_path / "a.h5"
    expected = write_s2(path, rich_mesh, part="a/b/c/d")
    assert_same_mesh(MapFile(path, "a/b/c/d").read(), expected)
    with pytest.raises(MapFileError) as refused:
        MapFile(path)
    assert refused.value.code == "no_mesh"


def test_mesh_is_meant_if_no_part_is_named(tmp_path, rich_mesh):
    path = tmp_path / "a.h5"
    write_hdf5_map_io(path, rich_mesh, part="first")
    assert MapFile(path).part == "first"
    write_s2(path, rich_mesh, part="second")
    write_model_factory(path, rich_mesh)
    with pytest.raises(MapFileError) as refused:
        MapFile(path)
    assert refused.value.code == "part"
    assert "name the part: first, second, meshes/garden" in str(refused.value)
    expected = write_lvr2_l1(path, rich_mesh)
    assert MapFile(path).part == "mesh"
    assert_same_mesh(MapFile(path).read(), expected)
    assert MapFile(path).parts == ["first", "mesh", "second", "meshes/garden"]
    with pytest.raises(MapFileError, match="no mesh in /third .*first, mesh, second, meshes/gard"):
        MapFile(path, "third")
    assert not [p for p in MapFile(path, "first").other_contents() if "second" in p or "mesh" in p]


def test_groups_that_hold_themselves_are_searched_once(tmp_path, rich_mesh):
    path = tmp_path / "a.h5"
    with h5py.File(path, "w") as file:
        file["again"] = file["/"]
        file["x/again"] = file["/"]
        file["x/x"] = file["x"]
    expected = write_s2(path, rich_mesh, part="z/mesh")
    assert MapFile(path).parts == ["z/mesh"]
    assert_same_mesh(MapFile(path).read(), expected)


def test_very_many_scans_do_not_hide_a_mesh(tmp_path, rich_mesh):
    path = tmp_path / "a.h5"
    with h5py.File(path, "w") as file:
        for i in range(1500):
            file.create_group("raw/scans/%d" % i)
    write_s2(path, rich_mesh, part="z/mesh")
    assert MapFile(path).parts == ["z/mesh"]
    with h5py.File(path, "a") as file:
        for i in range(1500):
            file.create_group("%d" % i)
    expected = write_s2(path, rich_mesh, part="00")
    assert MapFile(path).parts == ["00"]  # the search has an end
    assert_same_mesh(MapFile(path, "z/mesh").read(), expected)
    write_s2(path, rich_mesh)
    assert MapFile(path).parts == ["00", "mesh"] and MapFile(path).part == "mesh"


# variants of what is read


@pytest.mark.parametrize("alpha", [False, True])
@pytest.mark.parametrize("in_geometry", [False, True])
def test_s2_normals_and_colors_in_either_group(tmp_path, rich_mesh, alpha, in_geometry):
    path = tmp_path / "a.h5"
    expected = write_s2(path, rich_mesh, alpha=alpha, in_geometry=in_geometry)
    assert_same_mesh(MapFile(path).read(), expected)


def test_the_first_of_two_places_is_read_and_the_other_named(tmp_path, rich_mesh):
    path = tmp_path / "a.h5"
    expected = write_s2(path, rich_mesh)
    with h5py.File(path, "a") as file:
        file["mesh/geometry/vertex_normals"] = np.ones((40, 3), "f4")
        file["mesh/geometry/roughness"] = np.ones((40, 1), "f4")
    assert_same_mesh(MapFile(path).read(), expected)
    assert "/mesh/geometry/vertex_normals" in MapFile(path).other_contents()
    assert "/mesh/geometry/roughness" in MapFile(path).other_contents()


@pytest.mark.parametrize("write", [write_s0, write_hdf5_map_io, write_lvr2_l1, write_s2])
def test_edges_and_sparse_maps_are_no_layers(tmp_path, rich_mesh, write):
    path = tmp_path / "a.h5"
    layers = sorted(write(path, rich_mesh).vertex_costs)
    part = MapFile(path).part
    group = {"S0": "attributes", "S1": "channels", "S2": "vertex_attributes"}[MapFile(path).schema]
    with h5py.File(path, "a") as file:
        group = file["/".join((part, group))]
        group.require_dataset("edge_distances", (40, 1), "f4")
        group["sparse"] = np.zeros((40, 1), "f4")
        group["sparse_idx"] = np.zeros((40, 1), "u4")
        group["lonely_idx"] = np.zeros((40, 1), "f4")
        group["whole"] = np.zeros((40, 1), "i4")
        group["wide"] = np.zeros((40, 2), "f4")
        group["turned"] = np.zeros((1, 40), "f4")
        group["short"] = np.zeros(39, "f4")
        group["text"] = "cost"
        group["group/inner"] = np.zeros(40, "f4")
        group["link"] = h5py.SoftLink(group.name + "/wanted")
        group["wanted"] = np.arange(40, dtype=">f8")
    file = MapFile(path)
    assert file.layer_names() == sorted(layers + ["wanted"])
    assert_same(file.vertex_costs("wanted"), np.arange(40, dtype="f4"), "wanted")


FIELDS = {
    "reversed": [("b", "u1"), ("g", "u1"), ("r", "u1"), ("textureIndex", "<i4")],
    "wide": [("textureIndex", "<i8"), ("r", "<u4"), ("g", ">i2"), ("b", "<u8")],
    "big endian": [("textureIndex", ">i4"), ("r", "u1"), ("g", "u1"), ("b", "u1")],
    "more": [("textureIndex", "i1"), ("alpha", "<f4"), ("r", "u1"), ("g", "u1"), ("b", "u1")],
    "spec": MATERIAL,
}


@pytest.mark.parametrize("kind", FIELDS)
@pytest.mark.parametrize("rank", [1, 2])
def test_materials_of_any_integer_fields(tmp_path, rich_mesh, kind, rank):
    path = tmp_path / "a.h5"
    expected = write_hdf5_map_io(path, rich_mesh)
    with h5py.File(path, "a") as file:
        group = file["mesh/textures"]
        values = np.zeros(4, FIELDS[kind])
        for name in MATERIAL.names:
            values[name] = group["materials"][name]
        faces = group["mat_face_indices"][()].astype(">i8")
        del group["materials"], group["mat_face_indices"]
        group["materials"] = values if rank == 1 else values[:, None]
        group["mat_face_indices"] = faces if rank == 1 else faces[:, None]
    assert_same_mesh(MapFile(path).read(), expected)


@pytest.mark.parametrize("shape", [(80,), (120,), (40, 2), (40, 3)])
def test_texture_coordinates_of_two_or_three_values(tmp_path, rich_mesh, shape):
    path = tmp_path / "a.h5"
    expected = write_hdf5_map_io(path, rich_mesh)
    values = np.ones((40, shape[-1] if len(shape) == 2 else shape[0] // 40), "<f8")
    values[:, :2] = rich_mesh.texture_coordinates
    with h5py.File(path, "a") as file:
        del file["mesh/textures/coords"]
        file["mesh/textures/coords"] = values.reshape(shape)
    assert_same_mesh(MapFile(path).read(), expected)


@pytest.mark.parametrize("planes", [3, 4])
@pytest.mark.parametrize(
    "mode,axis", [("INTERLACE_PIXEL", 2), ("INTERLACE_LINE", 1), ("INTERLACE_PLANE", 0), (None, 2)]
)
def test_images_of_every_interlace(tmp_path, rich_mesh, planes, mode, axis):
    path = tmp_path / "a.h5"
    pixels = np.random.default_rng(1).integers(0, 256, (5, 7, planes)).astype("u1")
    expected = write_hdf5_map_io(path, rich_mesh)
    expected.textures[1] = pixels
    with h5py.File(path, "a") as file:
        stored = np.moveaxis(pixels, 2, axis)
        write_image(file["mesh/textures/images"], "1", stored, INTERLACE_MODE=mode)
        file["mesh/textures/images/01"] = np.zeros((2, 2, 3), "u1")
        file["mesh/textures/images/preview.png"] = np.zeros(9, "u1")
    file = MapFile(path)
    assert file.texture_indices() == [0, 1, 2, 10]
    assert_same_mesh(file.read(), expected)
    assert file.other_contents() == [
        "/mesh/textures/images/01",
        "/mesh/textures/images/preview.png",
    ]


@pytest.mark.parametrize("white", [None, np.uint8(0), np.uint8(1)])
@pytest.mark.parametrize("kind", ["IMAGE_GRAYSCALE", "IMAGE_INDEXED", None])
def test_gray_images_become_colored(tmp_path, rich_mesh, kind, white):
    path = tmp_path / "a.h5"
    gray = np.random.default_rng(1).integers(0, 256, (5, 7)).astype("u1")
    write_hdf5_map_io(path, rich_mesh)
    with h5py.File(path, "a") as file:
        images = file["mesh/textures/images"]
        write_image(images, "1", gray, IMAGE_SUBCLASS=kind, IMAGE_WHITE_IS_ZERO=white)
    shown = 255 - gray if white else gray
    assert_same(MapFile(path).texture(1), np.stack([shown] * 3, axis=2), "texture 1")


@pytest.mark.parametrize("shape", [(0,), (0, 1), (3,), (3, 1)])
@pytest.mark.parametrize("kind", ["<u4", ">i8", "<i4", "u1"])
@pytest.mark.parametrize("stored", ["contiguous", "chunked", "compact"])
def test_labels_of_any_rank_type_and_storage(tmp_path, rich_mesh, shape, kind, stored):
    path = tmp_path / "a.h5"
    write_lvr2_l1(path, rich_mesh)
    faces = np.array([59, 0, 7][: shape[0]], kind)
    with h5py.File(path, "a") as file:
        group = file["mesh/labels/tree"]
        if stored == "compact":
            properties = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
            properties.set_layout(h5py.h5d.COMPACT)
            space = h5py.h5s.create_simple(shape)
            made = h5py.h5d.create(group.id, b"3", h5py.h5t.py_create(kind), space, properties)
            made.write(h5py.h5s.ALL, h5py.h5s.ALL, faces.reshape(shape))
        else:
            more = {"chunks": (2,) + shape[1:], "maxshape": (None,) + shape[1:]}
            more = more if stored == "chunked" else {}
            group.create_dataset("3", data=faces.reshape(shape), **more)
    assert_same(MapFile(path).label("tree_3"), Label(faces.astype("<u4")), "label")


def test_label_texts_colors_and_their_order(tmp_path, rich_mesh):
    path = tmp_path / "a.h5"
    write_s2(path, rich_mesh)
    one = np.array([1], "u4")
    with h5py.File(path, "a") as file:
        labels = file["mesh/labels"]
        labels["tree/10"] = labels["big_oak/7"] = labels["any/%"] = labels["any/2"] = one
        labels["any/%"].attrs["label"] = "free text"
        labels["any/2"].attrs["label"] = "another"
        labels["any/2"].attrs["color"] = np.array([1, 2, 255], "<i8")
        labels["tree/02"] = np.array([4, 3, 4, 4, 3, 9], "u4")
        labels.create_group("nothing")
        labels["alone"] = one
        labels["tree/link"] = h5py.SoftLink("/mesh/labels/tree/1")
        labels["tree/deeper/3"] = one
    file = MapFile(path)
    texts = ["another", "big_oak_7", "free text", "tree_1", "tree_02", "tree_2", "tree_10"]
    assert file.label_names() == texts and list(file.labels()) == texts
    assert_same(file.label("another"), Label(one, (1, 2, 255)), "another")
    assert_same(file.label("tree_02"), Label(np.array([4, 3, 9], "u4")), "each face once")
    assert file.other_contents()[-3:] == [
        "/mesh/labels/alone",
        "/mesh/labels/tree/deeper",
        "/mesh/labels/tree/link",
    ]


def test_features_are_counted_not_spelled(tmp_path, rich_mesh):
    path = tmp_path / "a.h5"
    write_hdf5_map_io(path, rich_mesh)  # twelve: 10 and 11 come after 9, not after 1
    assert_same(MapFile(path).features, rich_mesh.features, "features")


def test_arrays_of_mesh_io_that_are_no_mesh_stay_unread(tmp_path, rich_mesh):
    path = tmp_path / "a.h5"
    expected = write_mesh_io(path, rich_mesh)
    with h5py.File(path, "a") as file:
        del file["meshes/garden/vertices/normals"], file["meshes/garden/vertices/colors"]
    expected.vertex_normals = expected.vertex_colors = None
    assert_same_mesh(MapFile(path).read(), expected)
