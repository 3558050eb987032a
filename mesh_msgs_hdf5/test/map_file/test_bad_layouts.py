"""What is wrong in a file of any layout is refused with its name, the first index and how many."""
import h5py
import numpy as np
import pytest
from map_samples import (
    MATERIAL,
    assert_same,
    write_hdf5_map_io,
    write_image,
    write_lvr2_l1,
    write_mesh_io,
    write_s0,
    write_s2,
)

from mesh_msgs_hdf5.map_file import MapFile
from mesh_msgs_hdf5.map_file.hdf5 import guarded_group
from mesh_msgs_hdf5.map_file.hdf5.hdf5_storage import MAX_RATIO, RATIO_FREE_BYTES, check_ratio
from mesh_msgs_hdf5.model.errors import MapFileError

ONES = np.ones(60, "u4")


def with_value(values, index, value):
    values = np.array(values)
    values[index] = value
    return values


def materials(texture=0, kind=MATERIAL, **fields):
    values = np.zeros(3, kind)
    values["textureIndex"] = [0, texture, -1]
    for name, value in fields.items():
        values[name] = value
    return values


WIDE = [("textureIndex", "<i8"), ("r", "<i2"), ("g", "u1"), ("b", "u1")]
NO_BLUE = [("textureIndex", "<i4"), ("r", "u1"), ("g", "u1")]
FLOATS = [("textureIndex", "<f4"), ("r", "u1"), ("g", "u1"), ("b", "u1")]
TEXTS = [("textureIndex", "<i4"), ("r", "S1"), ("g", "u1"), ("b", "u1")]

# writer, what is replaced below the part, by what, code, words of the message
REPLACED = [
    (write_s0, "geometry/vertices", np.zeros((40, 4), "f4"), "shape", "/geometry/vertices has the"),
    (write_s0, "geometry/faces", np.full(180, 40, "u4"), "index", "face 0 refers to vertex 40"),
    (write_s0, "geometry/faces", np.zeros(181, "u4"), "shape", "/geometry/faces has the shape"),
    (write_s0, "attributes/normals", np.zeros(117, "f4"), "shape", "/attributes/normals has"),
    (write_s0, "attributes/rgb_colors", np.full(120, 0.5, "f4"), "dtype", "/attributes/rgb_colors"),
    (write_s0, "attributes/roughness", np.full(40, -np.inf, "f4"), "value", "vertex 0, 40 in all"),
    (write_s0, "geometry/vertices", None, "no_mesh", "/geometry/vertices is missing"),
    (write_s2, "geometry/face_indices", None, "no_mesh", "/mesh/geometry/face_indices is miss"),
    (
        write_s2,
        "vertex_attributes/vertex_colors",
        with_value(np.full((40, 4), 255, "u1"), (7, 3), 254),
        "value",
        "/mesh/vertex_attributes/vertex_colors has an alpha other than 255 in row 7, 1 in all",
    ),
    (write_s2, "vertex_attributes/vertex_colors", np.zeros((40, 2), "u1"), "shape", "[40,3/4]"),
    (
        write_s2,
        "vertex_attributes/vertex_normals",
        with_value(np.ones((40, 3), "f8"), 9, np.nan),
        "not_finite",
        "row 9 of /mesh/vertex_attributes/vertex_normals is not finite",
    ),
    (write_s2, "face_attributes/face_normals", np.zeros((59, 3), "f4"), "shape", "[60,C]"),
    (write_s2, "geometry/texture_coordinates", np.zeros((40, 4), "f4"), "shape", "[40,3/2]"),
    (write_mesh_io, "faces/indices", np.full((60, 3), -1, "i4"), "index", "(60 in all)"),
    (
        write_hdf5_map_io,
        "textures/coords",
        with_value(np.zeros(120, "f4"), 15, np.inf),
        "not_finite",
        "row 5 of texture coordinates is not finite",
    ),
    (
        write_hdf5_map_io,
        "textures/materials",
        materials(7),
        "index",
        "material 1 has the texture 7",
    ),
    (write_hdf5_map_io, "textures/materials", materials(-2), "index", "material 1 has the texture"),
    (
        write_hdf5_map_io,
        "textures/materials",
        materials(kind=WIDE, r=256),
        "dtype",
        "r of /mesh/te",
    ),
    (write_hdf5_map_io, "textures/materials", materials(kind=WIDE, r=-1), "dtype", "3 values do"),
    (write_hdf5_map_io, "textures/materials", materials(2**31, WIDE), "dtype", "at row 1"),
    (write_hdf5_map_io, "textures/materials", materials(kind=FLOATS), "dtype", "textureIndex of"),
    (write_hdf5_map_io, "textures/materials", materials(kind=NO_BLUE), "dtype", "fields texture"),
    (write_hdf5_map_io, "textures/materials", materials(kind=TEXTS), "dtype", "not numbers"),
    (write_hdf5_map_io, "textures/materials", np.zeros(3, "i4"), "dtype", "fields none"),
    (
        write_hdf5_map_io,
        "textures/materials",
        materials()[:, None, None],
        "shape",
        "textures/mater",
    ),
    (
        write_hdf5_map_io,
        "textures/mat_face_indices",
        with_value(ONES, 33, 4),
        "index",
        "face 33 refers to material 4, but the mesh has 4 materials (1 in all)",
    ),
    (write_hdf5_map_io, "textures/mat_face_indices", ONES[:59], "shape", "mat_face_indices has"),
    (write_hdf5_map_io, "textures/images/2", np.zeros((5, 7), "f4"), "dtype", "texture 2"),
    (write_hdf5_map_io, "textures/images/2", np.zeros((5, 7, 2), "u1"), "shape", "images/2 has"),
    (write_hdf5_map_io, "textures/images/2", np.full((5, 7, 3), 256), "dtype", "105 values do"),
    (write_hdf5_map_io, "textures/images/2", np.zeros((0, 7, 3), "u1"), "shape", "images/2 has"),
    (
        write_hdf5_map_io,
        "labels/tree/2",
        with_value(np.zeros(9, "i8"), [4, 6], -3),
        "index",
        "label tree_2, entry 4 refers to face -3, but the mesh has 60 faces (2 in all)",
    ),
    (write_hdf5_map_io, "labels/tree/2", np.full(2, 60, "u4"), "index", "label tree_2, entry 0"),
    (write_hdf5_map_io, "labels/tree/2", np.zeros((3, 2), "u4"), "shape", "labels/tree/2 has the"),
    (write_hdf5_map_io, "labels/tree/2", np.zeros(3, "f4"), "dtype", "label tree_2 is of type"),
    (write_hdf5_map_io, "labels/tree/2", "1,2,3", "dtype", "labels/tree/2 holds"),
    (
        write_hdf5_map_io,
        "channels/texture_features/7",
        np.zeros(63, "f4"),
        "shape",
        "texture_features/7 has 63 values, but the first feature has 64",
    ),
    (
        write_hdf5_map_io,
        "channels/texture_features/7",
        np.zeros(64),
        "value",
        "no attribute vector",
    ),
    (
        write_lvr2_l1,
        "textures/2",
        np.zeros((2, 2), "u1"),
        "shape",
        "/mesh/textures/2 has the shape",
    ),
    (write_lvr2_l1, "textures/2", np.zeros((2, 2, 5), "u1"), "shape", "texture 2 has the shape"),
    (
        write_lvr2_l1,
        "materials/texture_handles",
        np.zeros(5, "i4"),
        "shape",
        "rgb_color has the sh",
    ),
    (write_lvr2_l1, "materials/rgb_color", np.full((4, 3), 300, "i2"), "dtype", "12 values do not"),
    (write_lvr2_l1, "materials/rgb_color", np.full((4, 3), -2, "i2"), "dtype", "rgb_color is of"),
    (
        write_lvr2_l1,
        "channels/face_material_indices",
        np.full((60, 1), -1, "i4"),
        "index",
        "face 0 refers to material -1, but the mesh has 4 materials (60 in all)",
    ),
]


@pytest.mark.parametrize(
    "write,place,values,code,words",
    REPLACED,
    ids=["%s-%d" % (row[1].split("/")[-1], i) for i, row in enumerate(REPLACED)],
)
def test_what_is_wrong_is_named(tmp_path, rich_mesh, write, place, values, code, words):
    path = tmp_path / "a.h5"
    write(path, rich_mesh)
    part = {write_s0: "", write_mesh_io: "meshes/garden"}.get(write, "mesh")
    assert MapFile(path).read() is not None
    with h5py.File(path, "a") as file:
        del file["/" + part][place]
        if values is not None:
            file["/" + part][place] = values
    with pytest.raises(MapFileError) as refused:
        MapFile(path, part, strict=True).read()
    assert refused.value.code == code and words in refused.value.message


@pytest.mark.parametrize(
    "place,name,value,code,words",
    [
        (
            "labels/tree/2",
            "color",
            [1, 2],
            "value",
            "color of /mesh/labels/tree/2 is not 3 numbers",
        ),
        ("labels/tree/2", "color", [1, 2, 256], "value", "the color of label tree_2"),
        ("labels/tree/2", "color", [1.0, 2.0, 3.0], "value", "the color of label tree_2"),
        ("labels/tree/2", "color", "red", "value", "not 3 numbers"),
        ("labels/tree/2", "label", 5, "value", "label of /mesh/labels/tree/2 is not a text"),
        ("labels/tree/2", "label", "a/b", "label", "'a/b' (of the dataset /mesh/labels/tree/2)"),
        ("labels/tree/2", "label", "", "label", "labels/tree/2) is empty"),
        ("labels/tree/2", "label", "tree_1", "label", "tree_1 is there twice, in /mesh/labels/"),
        ("channels/texture_features/7", "vector", [1, 2], "value", "vector of /mesh/channels/text"),
        ("channels/texture_features/7", "vector", [np.nan, 1, 2], "not_finite", "row 7 of"),
        ("textures/images/2", "INTERLACE_MODE", "INTERLACE_NONE", "shape", "images/2 has the sha"),
        ("textures/images/2", "INTERLACE_MODE", "INTERLACE_PLANE", "shape", "images/2 has the sha"),
        (
            "textures/images/2",
            "IMAGE_SUBCLASS",
            "IMAGE_BITMAP",
            "value",
            "unknown kind IMAGE_BITMAP",
        ),
        ("textures/images/2", "PALETTE", 0, "value", "an image with a palette"),
        (
            "channels/height_diff",
            "parameters",
            "[1]",
            "value",
            "of /mesh/channels/height_diff is not",
        ),
        ("channels/height_diff", "parameters", np.bytes_(b"\xff"), "value", "is not UTF-8"),
        (".", "uuid", np.bytes_(b"\xff"), "value", "uuid of /mesh is not UTF-8"),
        (".", "uuid", b"\xff", "value", "uuid of /mesh is not UTF-8"),
        (".", "origin", [1.0, 2.0], "value", "origin of /mesh is not 3 numbers"),
        (".", "origin", [1.0, 2.0, np.inf], "value", "the origin"),
        (".", "crs", "EPSG\n1", "value", "crs 'EPSG"),
        (".", "crs", 25832, "value", "crs of /mesh is not a text"),
    ],
)
def test_wrong_attributes_are_named(tmp_path, rich_mesh, place, name, value, code, words):
    path = tmp_path / "a.h5"
    write_hdf5_map_io(path, rich_mesh)
    with h5py.File(path, "a") as file:
        file["mesh"][place].attrs[name] = value
    with pytest.raises(MapFileError) as refused:
        MapFile(path, strict=True).read()
    assert refused.value.code == code and words in refused.value.message


def test_references_are_not_followed(tmp_path, rich_mesh):
    path = tmp_path / "a.h5"
    write_hdf5_map_io(path, rich_mesh)
    with h5py.File(path, "a") as file:
        mesh = file["mesh"]
        reference = mesh["channels/vertices"].ref
        mesh["labels/tree/3"] = np.array([reference] * 2, h5py.ref_dtype)
        mesh["channels/height_diff"].attrs["parameters"] = reference
        mesh["textures/images/0"].attrs["PALETTE"] = reference
    file = MapFile(path, strict=True)
    for ask, words in (
        (lambda: file.label("tree_3"), "/mesh/labels/tree/3 holds object, not numbers"),
        (lambda: file.layer_parameters("height_diff"), "parameters .* is neither text nor number"),
        (lambda: file.texture(0), "/mesh/textures/images/0 is an image with a palette"),
    ):
        with pytest.raises(MapFileError, match=words):
            ask()


@pytest.mark.parametrize(
    "ask,words",
    [
        (lambda file: file.vertex_costs("x"), "no layer 'x'.*height_diff, roughness"),
        (lambda file: file.layer_parameters("vertices"), "no layer 'vertices'"),
        (lambda file: file.face_attribute("x"), "no face attribute 'x'.*: none"),
        (lambda file: file.face_parameters("x"), "no face attribute 'x'"),
        (lambda file: file.texture(1), "no texture 1.*: 0, 2, 10"),
        (lambda file: file.label("x"), "no label 'x'.*tree_1, tree_2"),
    ],
)
def test_what_is_not_there_is_told_from_what_is(tmp_path, rich_mesh, ask, words):
    write_hdf5_map_io(tmp_path / "a.h5", rich_mesh)
    with pytest.raises(MapFileError, match=words):
        ask(MapFile(tmp_path / "a.h5"))


def test_names_that_are_not_utf8_are_refused(tmp_path, rich_mesh):
    path = tmp_path / "a.h5"
    write_hdf5_map_io(path, rich_mesh)
    with h5py.File(path, "a") as file:
        h5py.h5g.create(file["mesh/labels"].id, b"\xff")
    with pytest.raises(MapFileError) as refused:
        MapFile(path, strict=True).label_names()
    assert refused.value.code == "value" and "/mesh/labels is not UTF-8" in str(refused.value)


def test_materials_without_those_of_the_faces_are_left_to_the_file(tmp_path, rich_mesh):
    path = tmp_path / "a.h5"
    write_hdf5_map_io(path, rich_mesh)
    with h5py.File(path, "a") as file:
        del file["mesh/textures/mat_face_indices"]
    assert MapFile(path).materials is None and MapFile(path).read().materials is None
    assert MapFile(path).other_contents() == ["/mesh/textures/materials"]


# sizes


def test_much_in_almost_nothing_is_refused():
    check_ratio("a", "b", RATIO_FREE_BYTES, 0)
    check_ratio("a", "b", MAX_RATIO << 23, 1 << 23)
    with pytest.raises(MapFileError, match="b declares 838860801 bytes, which is 100 times"):
        check_ratio("a", "b", (MAX_RATIO << 23) + 1, 1 << 23)


def test_one_dataset_under_many_names_is_counted_each_time(tmp_path, rich_mesh, monkeypatch):
    path = tmp_path / "a.h5"
    write_hdf5_map_io(path, rich_mesh)
    arrays = 40 * 3 * (4 + 4 + 1 + 4) + 60 * 3 * 4 + 60 * 4 + 4 * 8 + 2 * 40 * 4
    with h5py.File(path, "a") as file:
        arrays += sum(image.size for image in file["mesh/textures/images"].values())
        arrays += 4 * sum(label.size for label in file["mesh/labels/tree"].values())
        arrays += 12 * 64 * 4
    monkeypatch.setattr(guarded_group, "default_budget", lambda: arrays + 40 * 40)
    MapFile(path).read()
    with h5py.File(path, "a") as file:
        for i in range(11):
            file["mesh/channels/again%d" % i] = file["mesh/channels/roughness"]
    with pytest.raises(MapFileError) as refused:
        MapFile(path).read()
    assert refused.value.code == "size" and "its arrays declare" in refused.value.message
    assert_same(MapFile(path).vertices, rich_mesh.vertices, "one by one")


@pytest.mark.parametrize("place", ["labels/tree", "labels", "", "textures/images", "channels"])
def test_very_many_names_are_refused(tmp_path, rich_mesh, place):
    path = tmp_path / "a.h5"
    write_hdf5_map_io(path, rich_mesh, part="garden")
    with h5py.File(path, "a", libver="latest") as file:
        group = file["garden/" + place if place else "/"]
        for i in range(50_001):
            group.id.links.create_soft(b"n%d" % i, b"/x")
    with pytest.raises(MapFileError) as refused:
        MapFile(path).read()
    assert refused.value.code == "size" and "entries allowed" in refused.value.message


def test_a_chunk_larger_than_its_array_is_refused(tmp_path, rich_mesh):
    path = tmp_path / "a.h5"
    write_hdf5_map_io(path, rich_mesh)
    with h5py.File(path, "a") as file:
        del file["mesh/channels/roughness"]
        made = file["mesh/channels"].create_dataset(
            "roughness", (40,), "f4", maxshape=(None,), chunks=(1 << 25,), compression="gzip"
        )
        made.id.write_direct_chunk((0,), b"\0" * 100)
    with pytest.raises(MapFileError) as refused:
        MapFile(path).vertex_costs("roughness")
    assert refused.value.code == "size"
    assert "has chunks of 134217728 bytes for 160 bytes of data" in refused.value.message


def test_a_white_is_zero_image_of_more_than_bytes_is_refused(tmp_path, rich_mesh):
    path = tmp_path / "a.h5"
    write_hdf5_map_io(path, rich_mesh)
    with h5py.File(path, "a") as file:
        group = file["mesh/textures/images"]
        write_image(group, "1", np.zeros((3, 4), "<u2"), IMAGE_SUBCLASS="IMAGE_GRAYSCALE")
        group["1"].attrs["IMAGE_WHITE_IS_ZERO"] = np.uint8(1)
    with pytest.raises(MapFileError, match="images/1 has the shape"):
        MapFile(path).texture(1)
