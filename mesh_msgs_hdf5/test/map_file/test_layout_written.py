"""What is written, looked at with plain h5py: each field as the programs in use have it."""
import json

import h5py
import numpy as np
import pytest
from map_samples import assert_same_mesh

from mesh_msgs_hdf5.map_file import MapFile
from mesh_msgs_hdf5.map_file.convert import convert

V, F = 40, 60  # of the fixtures
GZIP = ((h5py.h5z.FILTER_SHUFFLE, "shuffle"), (h5py.h5z.FILTER_DEFLATE, "deflate"))
# path below /mesh -> (type, shape, attributes); "|" and "<" are byte orders in the file
CHANNELS = {
    "channels/vertices": ("<f4", (V, 3), {}),
    "channels/face_indices": ("<u4", (F, 3), {}),
    "channels/vertex_normals": ("<f4", (V, 3), {}),
    "channels/vertex_colors": ("|u1", (V, 3), {}),
    "channels/height_diff": ("<f4", (V, 1), {"parameters"}),
    "channels/Grün und weich": ("<f4", (V, 1), {}),
    "channels/class_id": ("|u1", (V, 1), {}),
    "channels/id": ("<u8", (V, 1), {}),
    "channels/intensity": ("<f8", (V, 1), {"kind"}),
    "channels/echo": ("<f4", (V, 1), {"kind"}),
    "channels/SIFT": ("|i1", (V, 7), {"parameters"}),
    "channels/flow": ("<f4", (V, 3), {"parameters"}),
}
OURS = {
    "face_attributes/cost": ("<f4", (F,), {"parameters"}),
    "face_attributes/segment": ("<i8", (F,), {}),
    "face_attributes/face_normals": ("<f8", (F, 3), {}),
    "face_attributes/Fläche m²": ("<u2", (F, 2), {}),
}
LABELS = {
    "labels/tree/1": ("<u4", (3,), {"color"}),
    "labels/tree/2": ("<u4", (60,), {}),
    "labels/house/2_b": ("<u4", (1,), {"color"}),
    "labels/a free text/%": ("<u4", (2,), {"label"}),
    "labels/grass/%": ("<u4", (0,), {"color", "label"}),
    "labels/grass/% (2)": ("<u4", (1,), {"label"}),
    "labels/%/x": ("<u4", (1,), {"label"}),
    "labels/a/%2E%2E": ("<u4", (1,), {"label"}),
    "labels/%25/é": ("<u4", (1,), {"color", "label"}),
}
IMAGE = {"CLASS", "IMAGE_VERSION", "IMAGE_SUBCLASS", "INTERLACE_MODE"}
TEXTURES = {
    "textures/coords": ("<f4", (3 * V,), {}),
    "textures/materials": (
        {
            "names": ["textureIndex", "r", "g", "b"],
            "formats": ["<i4", "u1", "u1", "u1"],
            "offsets": [0, 4, 5, 6],
            "itemsize": 8,
        },
        (4,),
        {},
    ),
    "textures/mat_face_indices": ("<u4", (F,), {}),
    "textures/images/0": ("|u1", (5, 7, 3), IMAGE),
    "textures/images/2": ("|u1", (1, 1, 4), IMAGE),
    "textures/images/10": ("|u1", (33, 40, 3), IMAGE),
}
FEATURES = {"channels/texture_features/%d" % i: ("<f4", (64,), {"vector"}) for i in range(12)}
# LVR2's own form, width first
LVR2 = {
    "channels/texture_coordinates": ("<f4", (V, 2), {}),
    "channels/face_material_indices": ("<u4", (F, 1), {}),
    "materials/texture_handles": ("<i4", (4,), {}),
    "materials/rgb_color": ("<i2", (4, 3), {}),
    "textures/0": ("|u1", (7, 5, 3), {}),
    "textures/2": ("|u1", (1, 1, 4), {}),
    "textures/10": ("|u1", (40, 33, 3), {}),
}
SMALL = tuple(LABELS) + tuple(FEATURES)  # contiguous: the index of chunks would be larger


def datasets(part):
    found = {}
    part.visititems(
        lambda name, item: found.update({name: item} if isinstance(item, h5py.Dataset) else {})
    )
    return found


def filters(dataset):
    properties = dataset.id.get_create_plist()
    codes = [properties.get_filter(i) for i in range(properties.get_nfilters())]
    return tuple((code[0], code[3].decode()) for code in codes)


def check_layout(part, table):
    found = datasets(part)
    assert sorted(found) == sorted(table)
    for name, (dtype, shape, attributes) in table.items():
        dataset = found[name]
        assert dataset.dtype == np.dtype(dtype) and dataset.dtype.str == np.dtype(dtype).str, name
        assert dataset.id.get_type().get_size() == np.dtype(dtype).itemsize, name
        assert (dataset.shape, dataset.maxshape) == (shape, shape), name
        assert set(dataset.attrs) == set(attributes), name


def attribute_type(owner, name):
    attribute = h5py.h5a.open(owner.id, name.encode())
    assert attribute.get_space().get_simple_extent_type() == h5py.h5s.SCALAR
    return attribute.get_type()


@pytest.mark.parametrize("compression", ["gzip", "none"])
def test_every_field_is_that_of_the_sheet(tmp_path, rich_mesh, compression):
    path = tmp_path / "a.h5"
    MapFile.write(path, rich_mesh, compression=compression)
    with h5py.File(path, "r") as file:
        assert list(file) == ["mesh"] and not file.attrs
        part = file["mesh"]
        check_layout(part, {**CHANNELS, **OURS, **LABELS, **TEXTURES, **FEATURES})
        groups = ["channels", "clustersets", "face_attributes", "labels", "textures"]
        assert list(part) == groups and list(part["clustersets"]) == []
        for name, dataset in datasets(part).items():
            if compression == "none" or name in SMALL:
                assert dataset.chunks is None and filters(dataset) == (), name
            else:
                assert dataset.chunks == dataset.shape and filters(dataset) == GZIP, name
                assert dataset.compression_opts == 1, name


def test_large_arrays_have_chunks_of_32768_rows(tmp_path, full_mesh):
    rows = 70_000
    full_mesh.faces = np.zeros((rows, 3), "u4")
    full_mesh.face_attributes = {"x": np.zeros((rows, 2), "f8")}
    full_mesh.textures = {0: np.zeros((3000, 1000, 3), "u1")}
    MapFile.write(tmp_path / "a.h5", full_mesh)
    with h5py.File(tmp_path / "a.h5", "r") as file:
        assert file["mesh/channels/face_indices"].chunks == (32768, 3)
        assert file["mesh/face_attributes/x"].chunks == (32768, 2)
        rows, *rest = file["mesh/textures/images/0"].chunks
        assert rest == [1000, 3] and 1 <= rows * 3000 <= 1 << 20


def test_the_attributes_of_the_part(tmp_path, rich_mesh):
    """IO and CLASS of variable length, or LVR2 and mesh_map 1.x read no mesh."""
    MapFile.write(tmp_path / "a.h5", rich_mesh)
    with h5py.File(tmp_path / "a.h5", "r") as file:
        part = file["mesh"]
        assert set(part.attrs) == {
            *("IO", "CLASS", "schema_version", "frame_id", "uuid", "source", "origin", "crs")
        }
        for name, text in (("IO", "MeshIO"), ("CLASS", "MeshBuffer")):
            assert attribute_type(part, name).is_variable_str() and part.attrs[name] == text
        for name, text in (
            ("frame_id", "floor_2"),
            ("uuid", rich_mesh.uuid),
            ("crs", "EPSG:25832"),
        ):
            kind = attribute_type(part, name)
            assert not kind.is_variable_str() and kind.get_size() == len(text)
            assert part.attrs[name] == text.encode()
        assert part.attrs["schema_version"] == 1
        assert json.loads(part.attrs["source"]) == rich_mesh.source
        assert part.attrs["origin"].dtype.str == "<f8"
        assert tuple(part.attrs["origin"]) == rich_mesh.origin
        cost = part["channels/height_diff"]
        assert json.loads(cost.attrs["parameters"]) == rich_mesh.layer_parameters["height_diff"]


def test_the_values_of_textures_labels_and_features(tmp_path, rich_mesh):
    MapFile.write(tmp_path / "a.h5", rich_mesh)
    with h5py.File(tmp_path / "a.h5", "r") as file:
        part = file["mesh"]
        uvw = part["textures/coords"][()].reshape(-1, 3)
        assert np.array_equal(uvw[:, :2], rich_mesh.texture_coordinates) and not uvw[:, 2].any()
        table = part["textures/materials"][()]
        assert np.array_equal(table["textureIndex"], rich_mesh.materials.texture_indices)
        colors = np.stack([table[name] for name in "rgb"], axis=1)
        assert np.array_equal(colors, rich_mesh.materials.colors)
        assert np.array_equal(part["textures/mat_face_indices"], rich_mesh.materials.face_materials)
        for index, image in rich_mesh.textures.items():
            assert np.array_equal(part["textures/images/%d" % index], image)
        tree = part["labels/tree/1"]
        assert tree[()].tolist() == [5, 3, 4] and tree.attrs["color"].tolist() == [0, 128, 255]
        assert tree.attrs["color"].dtype.str == "|u1"
        assert part["labels/%25/é"].attrs["label"] == "%_é".encode()
        for i in range(12):
            feature = part["channels/texture_features/%d" % i]
            assert np.array_equal(feature, rich_mesh.features.descriptors[i])
            assert feature.attrs["vector"].dtype.str == "<f4"
            assert np.array_equal(feature.attrs["vector"], rich_mesh.features.locations[i])


def test_images_are_those_of_the_hdf5_image_library(tmp_path, rich_mesh):
    """H5IMis_image and H5IMget_image_info take attributes of exactly these types and lengths."""
    MapFile.write(tmp_path / "a.h5", rich_mesh)
    with h5py.File(tmp_path / "a.h5", "r") as file:
        for image in file["mesh/textures/images"].values():
            for name, text in (
                ("CLASS", b"IMAGE"),
                ("IMAGE_VERSION", b"1.2"),
                ("IMAGE_SUBCLASS", b"IMAGE_TRUECOLOR"),
                ("INTERLACE_MODE", b"INTERLACE_PIXEL"),
            ):
                kind = attribute_type(image, name)
                assert kind.get_class() == h5py.h5t.STRING and not kind.is_variable_str()
                assert kind.get_size() == len(text) + 1
                assert kind.get_strpad() == h5py.h5t.STR_NULLTERM
                assert kind.get_cset() == h5py.h5t.CSET_ASCII
                raw = np.zeros((), "V%d" % (len(text) + 1))
                h5py.h5a.open(image.id, name.encode()).read(raw, kind)
                assert raw.tobytes() == text + b"\0"


def test_every_field_for_lvr2(tmp_path, rich_mesh):
    """Its MeshIO takes every child of textures for an image, and needs two dimensions elsewhere."""
    MapFile.write(tmp_path / "a.h5", rich_mesh)
    assert convert(tmp_path / "a.h5", tmp_path / "b.h5", profile="lvr2") == []
    with h5py.File(tmp_path / "b.h5", "r") as file:
        part = file["mesh"]
        check_layout(part, {**CHANNELS, **OURS, **LABELS, **LVR2, **FEATURES})
        assert all(
            isinstance(item, h5py.Dataset) and name.isdigit()
            for name, item in part["textures"].items()
        )
        channels = [item for item in part["channels"].values() if isinstance(item, h5py.Dataset)]
        assert all(item.ndim == 2 for item in channels)
        for index, image in rich_mesh.textures.items():
            assert part["textures/%d" % index][()].tobytes() == image.tobytes()
        handles = part["materials/texture_handles"]
        assert np.array_equal(handles, rich_mesh.materials.texture_indices)
        assert np.array_equal(part["materials/rgb_color"], rich_mesh.materials.colors)
    assert_same_mesh(MapFile(tmp_path / "b.h5").read(), rich_mesh)


def test_a_mesh_without_anything_else(tmp_path, full_mesh):
    mesh = type(full_mesh)(full_mesh.vertices, full_mesh.faces)
    MapFile.write(tmp_path / "a.h5", mesh)
    with h5py.File(tmp_path / "a.h5", "r") as file:
        part = file["mesh"]
        assert sorted(datasets(part)) == ["channels/face_indices", "channels/vertices"]
        assert list(part) == ["channels", "clustersets", "labels", "textures"]
        assert {"origin", "crs"}.isdisjoint(part.attrs)
