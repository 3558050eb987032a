"""Every array of a map in every type and shape: read with the same values, or refused.

Never cast silently: what is read is equal to what was stored, number by number.
"""
import h5py
import numpy as np
import pytest

from mesh_msgs_hdf5.map_file import MapFile
from mesh_msgs_hdf5.model.errors import MapFileError

# place -> (how to read it, kinds of numbers that it may be made of, shape of 40 vertices, 60 faces)
PLACES = {
    "channels/vertices": (lambda file: file.vertices, "fiu"),
    "channels/vertex_normals": (lambda file: file.vertex_normals, "fiu"),
    "channels/vertex_colors": (lambda file: file.vertex_colors, "iu"),
    "channels/face_indices": (lambda file: file.faces, "iu"),
    "channels/height_diff": (lambda file: file.vertex_costs("height_diff"), "f"),
    "face_attributes/cost": (lambda file: file.face_attribute("cost"), "fiu"),
    "textures/coords": (lambda file: file.texture_coordinates, "fiu"),
    "textures/mat_face_indices": (lambda file: file.materials.face_materials, "iu"),
    "textures/images/0": (lambda file: file.texture(0), "iu"),
    "labels/tree/1": (lambda file: file.label("tree_1").faces, "iu"),
    "channels/texture_features/0": (lambda file: file.features.descriptors[0], "fiu"),
}
NUMBERS = ["f2", "f4", "f8", ">f2", ">f4", ">f8", "i1", "i2", "i4", "i8", ">i2", ">i4", ">i8"]
NUMBERS += ["u1", "u2", "u4", "u8", ">u2", ">u4", ">u8"]
CODES = {"dtype", "shape", "layer", "value", "no_mesh", "index", "size"}


def enumeration(values):
    return values.astype(h5py.enum_dtype({"a": 0, "b": 1, "c": 2, "d": 3}, "u1"))


OTHERS = {
    "bool": lambda values: values.astype(bool),
    "enum": enumeration,
    "text": lambda values: values.astype("S4"),
    "opaque": lambda values: np.full(values.shape, b"ab").astype("V2"),
    "complex": lambda values: values.astype("c8"),
    "record": lambda values: np.zeros(values.shape, [("x", "f4"), ("y", "f4")]),
    "array": lambda values: np.zeros(values.shape, [("x", "f4", 3)]),
}


@pytest.fixture
def stored(tmp_path, rich_data):
    """A function that replaces a dataset by values made of its own, and opens the file."""
    path = tmp_path / "a.h5"

    def store(place, change, **arguments):
        path.write_bytes(rich_data)
        with h5py.File(path, "r+") as file:
            del file["mesh"].attrs["uuid"]
            old = file["mesh/" + place]
            small = (np.arange(old.size) % 4).reshape(old.shape)
            attributes = dict(old.attrs)
            del file["mesh/" + place]
            new = file["mesh"].create_dataset(place, data=change(small), **arguments)
            for name, value in attributes.items():
                new.attrs[name] = value
        return path, small

    return store


@pytest.mark.parametrize("kind", NUMBERS)
@pytest.mark.parametrize("place", PLACES)
def test_numbers_of_every_type(stored, place, kind):
    path, values = stored(place, lambda values: values.astype(kind))
    read, kinds = PLACES[place]
    try:
        found = read(MapFile(path, strict=True))
    except MapFileError as error:
        assert error.code in CODES and np.dtype(kind).kind not in kinds, error
        return
    # images and indices are wider or narrower in the file, but never of another value
    assert np.dtype(kind).kind in kinds
    expected = values.reshape(-1, 3)[:, :2] if place.endswith("coords") else values
    assert np.array_equal(found.reshape(-1), expected.reshape(-1))


@pytest.mark.parametrize("other", OTHERS)
@pytest.mark.parametrize("place", PLACES)
def test_what_is_no_number_is_refused(stored, place, other):
    path, _ = stored(place, OTHERS[other])
    with pytest.raises(MapFileError) as refused:
        PLACES[place][0](MapFile(path, strict=True))
    assert refused.value.code in CODES
    if place == "channels/height_diff":  # it is no layer then
        assert "height_diff" not in MapFile(path).read().vertex_costs
        return
    with pytest.raises(MapFileError) as refused:
        MapFile(path, strict=True).read()
    assert refused.value.code in CODES


@pytest.mark.parametrize("place", PLACES)
def test_texts_of_variable_length_are_refused(stored, place):
    path, _ = stored(place, lambda values: values.astype(str).astype(object))
    with pytest.raises(MapFileError) as refused:
        PLACES[place][0](MapFile(path, strict=True))
    assert refused.value.code in CODES


SHAPES = {
    "turned": lambda values: values.T,
    "longer": lambda values: np.concatenate([values, values[:1]]),
    "shorter": lambda values: values[:-1],
    "deeper": lambda values: values.reshape(values.shape + (1, 1)),
    "in one": lambda values: values.reshape(-1),
    "single": lambda values: values.reshape(-1)[0],
    "empty": lambda values: values.reshape(-1)[:0],
}


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("place", PLACES)
def test_shapes(stored, place, shape):
    """Read with the same numbers in the same order, or refused."""
    path, values = stored(place, lambda values: SHAPES[shape](values).astype("u1"))
    changed = SHAPES[shape](values)
    free = place in ("labels/tree/1", "textures/images/0", "channels/texture_features/0")
    try:
        found = PLACES[place][0](MapFile(path, strict=True))
    except MapFileError as error:
        assert error.code in CODES | {"no_faces"}
        assert free or changed.shape != values.shape or place.endswith("height_diff")
        return
    expected = changed.reshape(-1, 3)[:, :2] if place.endswith("coords") else changed
    if place.startswith("labels"):
        expected = np.unique(expected)  # each face once
    assert np.array_equal(found.reshape(-1), expected.reshape(-1))


@pytest.mark.parametrize("value", [-1, 60, 2**31, 2**40])
@pytest.mark.parametrize(
    "place", ["labels/tree/1", "textures/mat_face_indices", "channels/face_indices"]
)
def test_indices_out_of_range_are_named(stored, place, value):
    def change(values):
        values = values.astype("i8")
        values.reshape(-1)[2] = value
        return values

    path, _ = stored(place, change)
    with pytest.raises(MapFileError) as refused:
        PLACES[place][0](MapFile(path, strict=True))
    assert refused.value.code in ("index", "dtype") and str(value) in refused.value.message


@pytest.mark.parametrize("value", [np.nan, np.inf, 1e60])
@pytest.mark.parametrize(
    "place", ["channels/vertices", "channels/vertex_normals", "textures/coords"]
)
def test_values_that_are_not_finite_are_named(stored, place, value):
    def change(values):
        values = values.astype("f8")
        values.reshape(-1)[3] = value
        return values

    path, _ = stored(place, change)
    with pytest.raises(MapFileError) as refused:
        PLACES[place][0](MapFile(path, strict=True))
    assert refused.value.code in ("not_finite", "dtype") and "row 1" in refused.value.message


@pytest.mark.parametrize("place", ["", "channels", "labels", "labels/tree", "face_attributes"])
def test_names_that_are_not_utf8(stored, place):
    path, _ = stored("channels/vertices", lambda values: values.astype("f4"))
    with h5py.File(path, "r+") as file:
        group = file["mesh/" + place] if place else file["mesh"]
        h5py.h5d.create(group.id, b"\xff\xfe", h5py.h5t.IEEE_F32LE, h5py.h5s.create_simple((40, 1)))
    assert MapFile(path).read().uuid
    if not place:
        assert "/mesh/(name that is not UTF-8)" in MapFile(path).other_contents()
        return
    file = MapFile(path)
    file.read()
    assert ["not UTF-8" in note for note in file.notes] == [True]
    with pytest.raises(MapFileError) as refused:
        MapFile(path, strict=True).read()
    assert refused.value.code == "value" and "not UTF-8" in refused.value.message
