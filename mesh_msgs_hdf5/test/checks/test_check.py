"""Each rule about the values of a mesh lets a good one pass and refuses a bad one by name."""
import dataclasses

import numpy as np
import pytest

from mesh_msgs_hdf5.checks.check import (
    checked_attribute,
    checked_features,
    checked_image,
    checked_label,
    checked_materials,
    checked_mesh,
    checked_texture_coordinates,
    from_json,
    identical,
    to_json,
)
from mesh_msgs_hdf5.model.errors import MapFileError
from mesh_msgs_hdf5.model.mesh import Features, Label, Materials, Mesh

COLORS = np.array([[1, 2, 3], [4, 5, 6]], "u1")
IMAGE = np.arange(24, dtype="u1").reshape(2, 4, 3)


def refusal(function, *arguments):
    with pytest.raises(MapFileError) as refused:
        function("a.h5", *arguments)
    assert refused.value.path == "a.h5" and "\n" not in str(refused.value)
    return refused.value


def materials(indices=(0, -1), faces=(0, 1, 1), colors=COLORS):
    return Materials(colors, np.asarray(indices), np.asarray(faces))


@pytest.mark.parametrize(
    "faces,color,expected",
    [
        ([3, 1, 2], None, [3, 1, 2]),
        ([], (0, 128, 255), []),
        (np.zeros((0, 1), "f4"), None, []),
        ([[5], [4]], [0, 0, 0], [5, 4]),
        (np.array([9, 0], ">i8"), np.array([255, 0, 7], "u1"), [9, 0]),
        ([7, 1, 7, 7, 1, 0], None, [7, 1, 0]),
        (range(10), None, list(range(10))),
    ],
)
def test_good_labels(faces, color, expected):
    label = checked_label("a.h5", "tree_1", Label(faces, color), 10)
    assert identical(label.faces, np.array(expected, "<u4"))
    assert label.color is None if color is None else label.color == tuple(int(c) for c in color)
    assert label.color is None or all(type(value) is int for value in label.color)


@pytest.mark.parametrize(
    "text,faces,color,code,words",
    [
        ("tree_1", [0, 10, 11], None, "index", "entry 1 refers to face 10, but the mesh has 10"),
        ("tree_1", [0, 10, 11], None, "index", "label tree_1, entry 1 refers to face 10"),
        ("tree_1", [4, -1], None, "index", "entry 1 refers to face -1"),
        ("tree_1", np.array([2**32], "u8"), None, "index", "refers to face 4294967296"),
        ("tree_1", [0.5], None, "dtype", "label tree_1 is of type float64"),
        ("tree_1", [[1, 2]], None, "shape", "label tree_1 has the shape [1, 2]"),
        ("a/b", [1], None, "label", "slash"),
        ("", [1], None, "label", "empty"),
        ("..", [1], None, "label", ".."),
        ("x" * 256, [1], None, "label", "255"),
        ("tree_1", [1], (0, 0), "value", "color of label tree_1 is (0, 0)"),
        ("tree_1", [1], (0, 0, 256), "value", "256"),
        ("tree_1", [1], (0, -1, 0), "value", "-1"),
        ("tree_1", [1], (0, 0, 1.0), "value", "whole numbers"),
        ("tree_1", [1], "red", "value", "red"),
    ],
)
def test_bad_labels(text, faces, color, code, words):
    error = refusal(checked_label, text, Label(faces, color), 10)
    assert error.code == code and words in str(error)


@pytest.mark.parametrize("kind", ["u1", "i2", ">u4"])
@pytest.mark.parametrize("channels", [3, 4])
def test_good_images(kind, channels):
    image = np.arange(2 * 3 * channels).reshape(2, 3, channels)
    for index in (0, np.int32(5), 2**31 - 1):
        assert identical(checked_image("a.h5", index, image.astype(kind)), image.astype("u1"))


@pytest.mark.parametrize(
    "index,image,code,words",
    [
        (-1, IMAGE, "index", "the index -1"),
        (2**31, IMAGE, "index", "2147483648"),
        ("0", IMAGE, "index", "'0'"),
        (True, IMAGE, "index", "True"),
        (3, IMAGE[..., :2], "shape", "texture 3 has the shape [2, 4, 2]"),
        (3, IMAGE[0], "shape", "[4, 3]"),
        (3, IMAGE[:0], "shape", "[0, 4, 3]"),
        (3, IMAGE / 255, "dtype", "texture 3 is of type float64"),
        (3, IMAGE.astype("i4") + 240, "dtype", "texture 3 is of type int32, and 8 values"),
    ],
)
def test_bad_images(index, image, code, words):
    error = refusal(checked_image, index, image)
    assert error.code == code and words in str(error)


def test_good_materials():
    found = checked_materials(
        "a.h5", materials(np.array([7, -1], "i8"), np.array([[0], [1], [1]], "i2")), 3, [7, 2]
    )
    assert identical(found.colors, COLORS)
    assert identical(found.texture_indices, np.array([7, -1], "<i4"))
    assert identical(found.face_materials, np.array([0, 1, 1], "<u4"))


@pytest.mark.parametrize(
    "changed,code,words",
    [
        ({"indices": [0, 1]}, "index", "material 1 has the texture 1, which is not there; 1 mat"),
        ({"indices": [-2, -2]}, "index", "material 0 has the texture -2, which is not there; 2"),
        ({"indices": np.array([0, 2**32 - 1], "u4")}, "dtype", "row 1"),
        ({"indices": [0.0, 0.0]}, "dtype", "float64"),
        ({"indices": [0]}, "shape", "[2,1]"),
        ({"faces": [0, 1]}, "shape", "the materials of faces has the shape [2]"),
        ({"faces": [0, 2, 3]}, "index", "face 1 refers to material 2, but the mesh has 2"),
        ({"faces": [0, 0, -1]}, "index", "face 2 refers to material -1"),
        ({"faces": [0.0, 0.0, 0.0]}, "dtype", "float64"),
        ({"colors": np.zeros((2, 4), "u1")}, "shape", "[2, 4]"),
        ({"colors": np.full((2, 3), 256)}, "dtype", "6 values"),
    ],
)
def test_bad_materials(changed, code, words):
    error = refusal(checked_materials, materials(**changed), 3, [0])
    assert error.code == code and words in str(error)
    if code == "index" and "texture" in words:
        assert "textures: 0" in error.hint


def test_texture_coordinates():
    uv = np.arange(8.0).reshape(4, 2)
    assert identical(checked_texture_coordinates("a.h5", uv, 4), uv.astype("f4"))
    assert refusal(checked_texture_coordinates, uv, 5).code == "shape"
    assert refusal(checked_texture_coordinates, np.zeros((4, 3)), 4).code == "shape"
    uv[2:] = np.nan
    error = refusal(checked_texture_coordinates, uv, 4)
    assert error.code == "not_finite" and "row 2 of texture coordinates" in str(error)
    assert "2 in all" in str(error)


def test_features():
    good = Features(np.ones((2, 3)), np.ones((2, 5), "f2"))
    found = checked_features("a.h5", good)
    assert identical(found.locations, np.ones((2, 3), "f4"))
    assert identical(found.descriptors, np.ones((2, 5), "f4"))
    assert checked_features("a.h5", Features(np.ones((0, 3)), np.ones((0, 5)))) is None
    for locations, descriptors, code, words in (
        (np.ones((2, 2)), np.ones((2, 5)), "shape", "[2, 2]"),
        (np.ones((2, 3)), np.ones((3, 5)), "shape", "descriptors of 2 features"),
        (np.ones((2, 3)), np.ones(2), "shape", "[2]"),
        (np.full((2, 3), np.inf), np.ones((2, 5)), "not_finite", "row 0 of the locations"),
        (np.ones((2, 3)), np.full((2, 5), np.nan), "not_finite", "row 0 of the descriptors"),
        (np.ones((2, 3)), np.ones((2, 5), "U1"), "dtype", "<U1"),
        (np.ones((100_001, 3)), np.ones((100_001, 1)), "size", "100001 features"),
    ):
        error = refusal(checked_features, Features(locations, descriptors))
        assert error.code == code and words in str(error)


@pytest.mark.parametrize("kind", ["i1", "u2", "<i4", ">u8", "<f2", "f4", ">f8"])
def test_face_attributes_keep_their_type(kind):
    for shape in ((3,), (3, 2)):
        values = np.arange(np.prod(shape)).reshape(shape).astype(kind)
        found = checked_attribute("a.h5", "face", "x", values, 3)
        assert identical(found, values.astype(np.dtype(kind).newbyteorder("<")))
        assert found.flags.c_contiguous
    assert checked_attribute("a.h5", "face", "x", values[:, :1], 3).shape == (3,)


@pytest.mark.parametrize(
    "name,values,code,words",
    [
        ("x", np.ones(2), "shape", "face attribute x has the shape [2], not [3] or [3,C]"),
        ("x", np.ones((3, 0)), "shape", "[3, 0]"),
        ("x", np.ones((3, 1, 1)), "shape", "[3, 1, 1]"),
        ("x", np.ones(3, bool), "dtype", "bool"),
        ("x", np.ones(3, "c8"), "dtype", "complex64"),
        ("x", np.array(["a"] * 3), "dtype", "not numbers"),
        ("x", np.array([0, 1, -np.inf], "f4"), "value", "-inf at face 2, 1 in all"),
        ("a/b", np.ones(3), "layer", "slash"),
        ("", np.ones(3), "layer", "face attribute name"),
        ("\n", np.ones(3), "layer", "printable"),
    ],
)
def test_bad_face_attributes(name, values, code, words):
    error = refusal(checked_attribute, "face", name, values, 3)
    assert error.code == code and words in str(error)


def test_all_members_of_a_mesh_are_checked(rich_mesh):
    """What is right stays the same array; each member, made wrong, is refused."""
    mesh = checked_mesh("a.h5", rich_mesh)
    for name in ("vertices", "faces", "vertex_normals", "vertex_colors", "texture_coordinates"):
        assert np.shares_memory(getattr(mesh, name), getattr(rich_mesh, name)), name
    for field in dataclasses.fields(Mesh):
        assert isinstance(
            getattr(mesh, field.name), getattr(rich_mesh, field.name).__class__
        ), field.name
    assert sorted(mesh.labels) == sorted(rich_mesh.labels)
    assert sorted(mesh.textures) == sorted(rich_mesh.textures)
    assert mesh.face_parameters == rich_mesh.face_parameters
    wrong = {
        "vertices": np.full((40, 3), np.nan),
        "faces": np.full((60, 3), -1),
        "vertex_normals": np.ones((39, 3)),
        "vertex_colors": np.full((40, 3), 300),
        "vertex_costs": {"vertices": np.ones(40)},
        "frame_id": "/map",
        "source": [1],
        "layer_parameters": {"height_diff": {"a": object()}},
        "face_attributes": {"x": np.ones(59)},
        "vertex_attributes": {"height_diff": np.ones(40, np.uint8)},
        "vertex_parameters": {"SIFT": [1]},
        "face_parameters": {next(iter(rich_mesh.face_attributes)): [1]},
        "texture_coordinates": np.ones((40, 3)),
        "textures": {},
        "materials": materials(faces=[0] * 59),
        "labels": {"tree_1": Label([60])},
        "features": Features(np.ones((2, 3)), np.ones((1, 1))),
        "origin": (0, np.nan, 0),
        "seam_originals": np.array([39]),
        "crs": "\n",
    }
    assert set(wrong) == {field.name for field in dataclasses.fields(Mesh)}
    for name, value in wrong.items():
        refusal(checked_mesh, dataclasses.replace(rich_mesh, **{name: value}))


def test_parameters_of_what_is_not_there_are_left_out(rich_mesh):
    rich_mesh.layer_parameters = {"gone": {"a": 1}, "height_diff": {}}
    assert checked_mesh("a.h5", rich_mesh).layer_parameters == {}


@pytest.mark.parametrize("origin", [(1, 2), "abc", (1, 2, "x"), None, (1, 2, np.inf)])
def test_bad_origins(rich_mesh, origin):
    rich_mesh.origin = origin
    error = refusal(checked_mesh, rich_mesh)
    assert error.code == "value" and "origin" in str(error)


def test_json_of_numpy_values():
    text = to_json("a.h5", "x", {"b": np.float32(0.5), "a": np.arange(2)})
    assert text == '{"a": [0, 1], "b": 0.5}' and from_json("a.h5", "x", text)["a"] == [0, 1]
    deep = {}
    deep["self"] = deep
    for value in (deep, {"a": object()}, {"a": {1, 2}}):
        assert "x cannot be stored" in str(refusal(to_json, "x", value))
    for text in ("{", "[1]", "[" * 100_000):
        assert refusal(from_json, "x", text).code == "value"
