"""What is written is read back, bit for bit; what is in the file besides survives."""
import dataclasses
import json
import stat
import time

import h5py
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from map_samples import SAMPLES, assert_same_mesh
from mesh_msgs import zoo
from mesh_msgs.identity import geometry_uuid

from mesh_msgs_hdf5.checks.check import identical
from mesh_msgs_hdf5.isolation import IsolatedMapFile
from mesh_msgs_hdf5.map_file import MapFile
from mesh_msgs_hdf5.model.edit import Edit
from mesh_msgs_hdf5.model.errors import MapFileError
from mesh_msgs_hdf5.model.mesh import Label, Mesh

FINITE = st.floats(width=32, allow_nan=False, allow_infinity=False)
COSTS = st.floats(width=32).filter(lambda x: x != -np.inf)
NAMES = st.text(
    st.characters(blacklist_categories=("C", "Z"), blacklist_characters="/"),
    min_size=1,
    max_size=20,
).filter(lambda name: name not in (".", "..") and not name.endswith("_idx"))


def mesh_with(mesh, layer, costs):
    return dataclasses.replace(mesh, vertex_costs=dict(mesh.vertex_costs, **{layer: costs}))


@st.composite
def meshes(draw):
    rows = draw(st.integers(1, 12))
    vector = hnp.arrays(np.float32, (rows, 3), elements=FINITE)
    face_shape = (draw(st.integers(1, 9)), 3)
    return Mesh(
        vertices=draw(vector),
        faces=draw(hnp.arrays(np.uint32, face_shape, elements=st.integers(0, rows - 1))),
        vertex_normals=draw(st.none() | vector),
        vertex_colors=draw(st.none() | hnp.arrays(np.uint8, (rows, 3))),
        vertex_costs=draw(
            st.dictionaries(NAMES, hnp.arrays(np.float32, rows, elements=COSTS), max_size=3)
        ),
        frame_id=draw(st.sampled_from(["map", "floor/2", "é"])),
        source=draw(st.dictionaries(st.text(max_size=5), st.integers() | st.text(), max_size=3)),
    )


@settings(max_examples=60)
@given(mesh=meshes())
def test_what_is_written_is_read_back_bit_for_bit(tmp_path, mesh):
    path = tmp_path / "a.h5"
    assert_same_mesh(MapFile.write(path, mesh).read(), mesh)


@pytest.mark.parametrize("animal", zoo.all_meshes(), ids=lambda mesh: mesh.name)
def test_every_mesh_of_the_zoo_is_read_back(tmp_path, animal):
    mesh = Mesh(animal.vertices, animal.faces)
    if not len(animal.faces):
        with pytest.raises(MapFileError) as refused:
            MapFile.write(tmp_path / "a.h5", mesh)
        assert refused.value.code == "no_faces" and not (tmp_path / "a.h5").exists()
        return
    file = MapFile.write(tmp_path / "a.h5", mesh)
    assert_same_mesh(file.read(), mesh)
    assert file.uuid == geometry_uuid(animal.vertices, animal.faces)


def test_several_chunks_are_read_back(tmp_path):
    world = zoo.outdoor_world(faces=150_000, seed=3)
    mesh = Mesh(world.vertices, world.faces, vertex_costs={"z": world.vertices[:, 2].copy()})
    assert len(mesh.vertices) > 65536
    assert_same_mesh(MapFile.write(tmp_path / "a.h5", mesh).read(), mesh)


def test_single_arrays_equal_those_of_read(tmp_path, rich_mesh):
    file = MapFile.write(tmp_path / "a.h5", rich_mesh)
    assert (file.vertex_count, file.face_count) == (40, 60)
    assert file.layer_names() == ["Grün und weich", "height_diff"]
    assert file.face_attribute_names() == ["Fläche m²", "cost", "face_normals", "segment"]
    assert file.texture_indices() == [0, 2, 10]
    assert sorted(file.label_names()) == sorted(rich_mesh.labels)
    single = Mesh(
        vertices=file.vertices,
        faces=file.faces,
        vertex_normals=file.vertex_normals,
        vertex_colors=file.vertex_colors,
        vertex_costs={name: file.vertex_costs(name) for name in file.layer_names()},
        frame_id=file.frame_id,
        source=file.source,
        layer_parameters={"height_diff": file.layer_parameters("height_diff")},
        face_attributes={name: file.face_attribute(name) for name in file.face_attribute_names()},
        face_parameters={"cost": file.face_parameters("cost")},
        vertex_attributes={
            name: file.vertex_attribute(name) for name in file.vertex_attribute_names()
        },
        vertex_parameters={name: file.vertex_parameters(name) for name in ("SIFT", "flow")},
        texture_coordinates=file.texture_coordinates,
        textures={index: file.texture(index) for index in file.texture_indices()},
        materials=file.materials,
        labels={text: file.label(text) for text in file.label_names()},
        features=file.features,
        origin=file.origin,
        crs=file.crs,
    )
    assert_same_mesh(single, rich_mesh)
    assert_same_mesh(file.read(), rich_mesh)
    assert file.layer_parameters("Grün und weich") == file.face_parameters("segment") == {}
    parameters = rich_mesh.layer_parameters["height_diff"]
    assert file.all_layer_parameters() == {"Grün und weich": {}, "height_diff": parameters}
    assert file.other_contents() == []


def test_the_layout_is_that_of_the_field(tmp_path, full_mesh):
    """Ranks and types that mesh_map 1.x, LVR2 and hdf5_map_io read, looked at with plain h5py."""
    path = tmp_path / "a.h5"
    MapFile.write(path, full_mesh)
    with h5py.File(path, "r") as file:
        assert list(file) == ["mesh"]
        mesh = file["mesh"]
        assert sorted(mesh) == ["channels", "clustersets", "labels", "textures"]
        for name in ("clustersets", "labels", "textures"):
            assert isinstance(mesh[name], h5py.Group) and not len(mesh[name])
        expected = {
            "vertices": ("<f4", (40, 3)),
            "face_indices": ("<u4", (60, 3)),
            "vertex_normals": ("<f4", (40, 3)),
            "vertex_colors": ("|u1", (40, 3)),
            "height_diff": ("<f4", (40, 1)),
            "Grün und weich": ("<f4", (40, 1)),
        }
        found = {name: (d.dtype.str, d.shape) for name, d in mesh["channels"].items()}
        assert found == expected
        for name, values in mesh["channels"].items():
            assert (values.compression, values.compression_opts, values.shuffle) == (
                "gzip",
                1,
                True,
            )
            assert values.chunks == values.shape and values.maxshape == values.shape
        assert sorted(mesh.attrs) == [
            "CLASS",
            "IO",
            "frame_id",
            "schema_version",
            "source",
            "uuid",
        ]
        for name, text in (("IO", "MeshIO"), ("CLASS", "MeshBuffer")):
            kind = h5py.h5a.open(mesh.id, name.encode()).get_type()
            assert kind.is_variable_str() and mesh.attrs[name] == text
            assert mesh.attrs.get_id(name).shape == ()
        assert mesh.attrs["schema_version"] == 1
        assert mesh.attrs["uuid"] == full_mesh.uuid.encode()
        assert mesh.attrs["frame_id"] == b"floor_2"
        assert json.loads(mesh.attrs["source"]) == full_mesh.source
        parameters = mesh["channels/height_diff"].attrs["parameters"]
        assert parameters == b'{"radius": 0.3, "type": "mesh_layers/HeightDiffLayer"}'


def test_the_same_mesh_gives_the_same_bytes(tmp_path, full_mesh):
    MapFile.write(tmp_path / "a.h5", full_mesh)
    time.sleep(1.1)  # times in a file have seconds
    MapFile.write(tmp_path / "b.h5", full_mesh)
    assert (tmp_path / "a.h5").read_bytes() == (tmp_path / "b.h5").read_bytes()


@pytest.mark.parametrize("rank", [1, 2])
@pytest.mark.parametrize("order", "<>")
@pytest.mark.parametrize("floats,integers", [("f8", "i8"), ("f4", "i4"), ("f4", "u4")])
def test_other_types_and_ranks_are_read_without_loss(
    tmp_path, full_mesh, rank, order, floats, integers
):
    path = tmp_path / "a.h5"
    with h5py.File(path, "w") as file:
        channels = file.create_group("mesh/channels")
        for name, values, kind in (
            ("vertices", full_mesh.vertices, floats),
            ("face_indices", full_mesh.faces, integers),
            ("vertex_colors", full_mesh.vertex_colors, integers),
            ("cost", full_mesh.vertex_costs["height_diff"][:, None], floats),
        ):
            values = values.astype(order + kind)
            channels[name] = values.ravel() if rank == 1 else values
    mesh = MapFile(path).read()
    assert identical(mesh.vertices, full_mesh.vertices) and identical(mesh.faces, full_mesh.faces)
    assert identical(mesh.vertex_colors, full_mesh.vertex_colors)
    assert np.array_equal(
        mesh.vertex_costs["cost"], full_mesh.vertex_costs["height_diff"], equal_nan=True
    )
    assert mesh.frame_id == "map" and mesh.source == {}
    assert MapFile(path).uuid == full_mesh.uuid and MapFile(path).schema_version == 0


def test_only_vertex_costs_are_layers(tmp_path, full_mesh):
    path = tmp_path / "a.h5"
    file = MapFile.write(path, full_mesh)
    with h5py.File(path, "r+") as raw:
        channels = raw["mesh/channels"]
        channels["face_normals"] = np.zeros((60, 3), "f4")
        channels["edge_distances"] = np.zeros((40, 1), "f4")  # as many edges as vertices
        channels["edge_distances_idx"] = np.zeros((40, 1), "u4")
        channels["other"] = np.zeros((40, 1), "f4")  # LVR2's general map of that name
        channels["other_idx"] = np.zeros((40, 1), "u4")
        channels["wide"] = np.zeros((40, 2), "f4")
        channels["short"] = np.zeros((39, 1), "f4")
        channels["whole"] = np.zeros((40, 1), "i4")
        channels["texture_features/0"] = np.zeros(40, "f4")
        channels["flat"] = np.zeros(40, "f2")
        channels["soft"] = h5py.SoftLink("/mesh/channels/flat")
    assert MapFile(path).layer_names() == ["Grün und weich", "flat", "height_diff", "short"]
    with pytest.raises(MapFileError, match="there is no layer 'wide'.*flat, height_diff"):
        file.vertex_costs("wide")
    with pytest.raises(MapFileError, match=r"short has the shape \[39, 1\], not \[40\]"):
        file.vertex_costs("short")


def fill_with_strange_things(path):
    with h5py.File(path, "r+") as file:
        file.attrs["made by"] = ["another", "program"]
        scans = file.create_group("raw/scans")
        scans.attrs["pose"] = np.arange(16.0).astype(">f8").reshape(4, 4)
        scans.attrs["nothing"] = h5py.Empty("f4")
        scans.attrs["fixed"] = np.bytes_(b"abc")
        scans.create_dataset("0", data=np.arange(5000), chunks=(100,), compression="lzf")
        scans["compound"] = np.zeros(3, [("index", "<i4"), ("r", "u1"), ("name", "S4")])
        scans["text"] = np.array(["ä", "b"], dtype=h5py.string_dtype())
        scans["again"] = file["raw/scans/0"]
        file["mesh/labels/tree/1"] = np.arange(7, dtype="u4")
        file["mesh/channels/face_normals"] = np.zeros((60, 3), "f4")
        file["mesh/channels"].attrs["kept"] = "yes"
        file["mesh"].attrs["origin"] = [1e6, 2e6, 0.0]
        file["mesh/soft"] = h5py.SoftLink("/nowhere")
        file["outside"] = h5py.ExternalLink("/etc/passwd", "/x")
        file["mesh 2/channels/vertices"] = np.zeros((3, 3), "f4")
        file["mesh 2/channels/face_indices"] = np.zeros((1, 3), "u4")


def contents(path, skip):
    """Everything in a file: paths, attributes, links, stored bytes."""
    found = {}

    def visit(group, name):
        for key, kind in ((k, group.get(k, getlink=True)) for k in group):
            path = name + "/" + key
            if isinstance(kind, (h5py.SoftLink, h5py.ExternalLink)):
                found[path] = (type(kind), kind.path, getattr(kind, "filename", None))
            elif isinstance(group[key], h5py.Group):
                found[path] = attributes(group[key])
                visit(group[key], path)
            elif path not in skip:
                data = group[key]
                found[path] = (
                    attributes(data),
                    data.dtype,
                    data.shape,
                    data.chunks,
                    repr(data[()].tolist()),
                )
                found[path] += (data.compression, data.id.get_storage_size())

    def attributes(item):
        return {
            k: (v.dtype, v.shape, repr(item.attrs[k]))
            for k in item.attrs
            for v in [item.attrs.get_id(k)]
        }

    with h5py.File(path, "r") as file:
        found["/"] = attributes(file)
        visit(file, "")
    return found


def test_writing_layers_keeps_everything_else(tmp_path, full_mesh):
    path = tmp_path / "a.h5"
    file = MapFile.write(path, full_mesh)
    fill_with_strange_things(path)
    path.chmod(0o640)
    written = {"/mesh/channels/height_diff", "/mesh/channels/new"}
    before = contents(path, written)
    new = np.linspace(0, 1, 40)
    file.write_layers(
        {
            "new": (new.astype("f4"), {"radius": np.float32(0.5)}),
            "height_diff": (new.astype("f4"), None),
        }
    )
    assert contents(path, written) == before
    assert len(before) > 20
    assert identical(file.vertex_costs("new"), new.astype("f4"))
    assert file.layer_parameters("new") == {"radius": 0.5}
    assert file.layer_parameters("height_diff") == {}
    assert stat.S_IMODE(path.stat().st_mode) == 0o640
    assert file.other_contents() == [
        "/mesh/channels/face_normals",
        "/mesh/soft",
        "/outside",
        "/raw",
    ]
    assert file.parts == ["mesh", "mesh 2"]
    assert identical(file.label("tree_1").faces, np.arange(7, dtype="u4"))
    assert file.origin == (1e6, 2e6, 0.0)


def test_writing_layers_again_and_again_does_not_grow_the_file(tmp_path, full_mesh):
    path = tmp_path / "a.h5"
    file = MapFile.write(path, full_mesh)
    sizes = []
    for _ in range(5):
        file.write_layers({"new": (np.ones(40, "f4"), {"a": 1})})
        sizes.append(path.stat().st_size)
    # the second save replaces what the first one added, which leaves a hole of one header
    assert sizes[1] - sizes[0] < 1024 and len(set(sizes[1:])) == 1


def test_a_part_of_another_name(tmp_path, full_mesh):
    file = MapFile.write(tmp_path / "a.h5", full_mesh, part="storey/2")
    assert_same_mesh(file.read(), full_mesh)
    file.write_layers({"new": (np.ones(40, "f4"), None)})
    assert file.layer_names() == ["Grün und weich", "height_diff", "new"]
    with pytest.raises(MapFileError) as refused:
        MapFile(tmp_path / "a.h5", part="mesh")
    assert refused.value.code == "part" and "parts of this file: storey/2" in str(refused.value)
    assert MapFile(tmp_path / "a.h5").part == "storey/2"
    assert_same_mesh(
        MapFile(tmp_path / "a.h5").read(), mesh_with(full_mesh, "new", np.ones(40, "f4"))
    )


def test_a_replaced_map_is_not_mixed_with_the_old_one(tmp_path, full_mesh):
    path = tmp_path / "a.h5"
    file = MapFile.write(path, full_mesh)
    MapFile.write(path, Mesh(full_mesh.vertices + 1, full_mesh.faces))
    for access in (lambda: file.vertices, file.layer_names, file.read):
        with pytest.raises(MapFileError) as refused:
            access()
        assert refused.value.code == "changed"
    other = MapFile(path)
    MapFile(path).write_layers({"new": (np.ones(40, "f4"), None)})
    assert other.layer_names() == ["new"]  # the same geometry: goes on


@pytest.mark.parametrize("kind", [MapFile, IsolatedMapFile])
@pytest.mark.parametrize("layout", ["hdf5_map_io", "lvr2_l1"])
def test_what_has_no_uuid_is_saved_again_and_again(tmp_path, rich_mesh, layout, kind):
    """The released programs store none: then only what is saved through it is known as the same."""
    path = tmp_path / "a.h5"
    SAMPLES[layout](path, rich_mesh)
    file = kind(path)
    file.update(Edit(labels={"tree_7": Label(np.array([4], "u4"))}))
    assert file.label("tree_7").faces.tolist() == [4]
    file.write_layers({"new": (np.ones(40, "f4"), None)})
    assert "new" in file.layer_names() and "tree_7" in file.labels()
    MapFile(path).write_layers({"other": (np.ones(40, "f4"), None)})
    for access in (file.layer_names, lambda: file.write_layers({"x": (np.ones(40, "f4"), None)})):
        with pytest.raises(MapFileError) as refused:
            access()
        assert refused.value.code == "changed"

    known = kind(path)
    assert known.uuid == rich_mesh.uuid
    MapFile(path).write_layers({"third": (np.ones(40, "f4"), None)})
    assert "third" in known.layer_names()  # now it can tell
    with h5py.File(path, "r+") as raw:
        vertices = raw["mesh/channels/vertices"]
        vertices[...] = vertices[()] + np.float32(1)
    with pytest.raises(MapFileError) as refused:
        known.layer_names()
    assert refused.value.code == "changed"


@pytest.mark.parametrize("kind", [MapFile, IsolatedMapFile])
def test_what_an_edit_adds_is_known_at_once(tmp_path, full_mesh, kind):
    file = kind.write(tmp_path / "a.h5", Mesh(full_mesh.vertices, full_mesh.faces))
    assert not file.has_colors and not file.has_normals
    colors, normals = full_mesh.vertex_colors, full_mesh.vertex_normals
    file.update(Edit(vertex_colors=colors, vertex_normals=normals))
    assert file.has_colors and file.has_normals


def test_a_long_source_and_long_parameters(tmp_path, full_mesh):
    full_mesh.source = {"notes": ["n" * 200_000]}
    full_mesh.layer_parameters["height_diff"]["points"] = list(range(30_000))
    file = MapFile.write(tmp_path / "a.h5", full_mesh)
    assert_same_mesh(file.read(), full_mesh)
    file.write_layers({"new": (np.ones(40, "f4"), None)})
    assert file.source == full_mesh.source


def test_a_changed_geometry_of_ours_is_noticed(tmp_path, full_mesh):
    path = tmp_path / "a.h5"
    MapFile.write(path, full_mesh)
    with h5py.File(path, "r+") as file:
        file["mesh/channels/vertices"][3, 1] += np.float32(0.25)
    with pytest.raises(MapFileError) as refused:
        MapFile(path).read()
    assert refused.value.code == "uuid"


def test_another_programs_uuid_is_kept(tmp_path, full_mesh):
    path = tmp_path / "a.h5"
    MapFile.write(path, full_mesh)
    with h5py.File(path, "r+") as file:
        del file["mesh"].attrs["schema_version"]
        file["mesh"].attrs["uuid"] = "garden"
    assert MapFile(path).uuid == "garden" and MapFile(path).read().vertices.shape == (40, 3)


def test_a_newer_schema_is_read_but_not_rewritten(tmp_path, full_mesh):
    path = tmp_path / "a.h5"
    file = MapFile.write(path, full_mesh)
    with h5py.File(path, "r+") as raw:
        raw["mesh"].attrs["schema_version"] = 2
    old = path.read_bytes()
    with pytest.raises(MapFileError) as refused:
        file.write_layers({"new": (np.ones(40, "f4"), None)})
    assert refused.value.code == "version" and path.read_bytes() == old
    assert_same_mesh(file.read(), full_mesh)
