"""Exporting and importing gives the same arrays bit for bit, for everything that a format takes."""
import json
import os

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from mesh_msgs import zoo
from mesh_writers import SQUARE, TWO_FACES, pixels

from mesh_msgs_hdf5.checks.check import identical
from mesh_msgs_hdf5.formats.exporter import WRITERS, write_mesh
from mesh_msgs_hdf5.formats.importer import read_mesh
from mesh_msgs_hdf5.model.errors import MapFileError
from mesh_msgs_hdf5.model.mesh import Label, Materials, Mesh

ANIMALS = [mesh for mesh in zoo.all_meshes() if len(mesh.faces)]
EXACT = (".ply", ".obj", ".glb", ".gltf")
# of rich_mesh
ORIGIN = "coordinates are without the origin 430000.0, 5790000.0, -0.1"
ADDED = "; --georeferenced adds it"
ARRAYS = ("vertices", "faces", "vertex_normals", "vertex_colors", "texture_coordinates")
LARGEST, TINIEST = float(np.finfo(np.float32).max), float(np.float32(1e-45))
NUMBERS = st.floats(width=32, allow_nan=False, allow_infinity=False)


def again(folder, mesh, suffix, **more):
    """(the mesh after export and import, notes of the export, report of the import)."""
    path = folder / ("a mesh" + suffix)
    notes = write_mesh(path, mesh, overwrite=True, **more)
    found, report = read_mesh(path)
    return found, notes, report


def assert_same(found, mesh, members):
    for name in members:
        wanted, value = getattr(mesh, name), getattr(found, name)
        if isinstance(wanted, dict) and all(hasattr(v, "dtype") for v in wanted.values()):
            assert sorted(value) == sorted(wanted), name
            assert all(identical(value[key], wanted[key]) for key in wanted), name
        elif name == "materials":
            assert all(identical(getattr(value, k), getattr(wanted, k)) for k in vars(wanted))
        elif name == "labels":
            assert list(value) == list(wanted)
            for text in wanted:
                assert value[text].color == wanted[text].color
                faces = np.sort(wanted[text].faces)
                assert identical(np.sort(value[text].faces), faces), text
        elif wanted is None or hasattr(wanted, "dtype"):
            assert identical(value, wanted), name
        else:
            assert value == wanted, name


def of_zoo(animal):
    rng = np.random.default_rng(3)
    rows = len(animal.vertices)
    return Mesh(
        animal.vertices,
        animal.faces,
        vertex_normals=rng.normal(size=(rows, 3)).astype(np.float32),
        vertex_colors=rng.integers(0, 256, (rows, 3)).astype(np.uint8),
        texture_coordinates=rng.normal(size=(rows, 2)).astype(np.float32),
    )


@pytest.mark.parametrize("suffix", EXACT)
@pytest.mark.parametrize("animal", ANIMALS, ids=lambda mesh: mesh.name)
def test_the_zoo_comes_back(tmp_path, animal, suffix):
    mesh = of_zoo(animal)
    found, notes, report = again(tmp_path, mesh, suffix)
    assert_same(found, mesh, ARRAYS)
    assert notes == [] and report.notes == []
    bare = Mesh(animal.vertices, animal.faces)
    found, _, _ = again(tmp_path, bare, suffix)
    assert_same(found, bare, ARRAYS)


def test_everything_comes_back_from_ply(tmp_path, rich_mesh):
    found, notes, report = again(tmp_path, rich_mesh, ".ply")
    members = set(vars(rich_mesh)) - {"features", "source"}
    assert_same(found, rich_mesh, members)
    assert found.source["before"] == rich_mesh.source
    assert notes == ["left out: 12 texture features, which PLY does not have", ORIGIN + ADDED]
    assert report.notes == [
        "layer %s has 1 unknown (NaN), 1 lethal (inf) values" % name
        for name in rich_mesh.vertex_costs
    ]
    assert (report.materials, report.textures, report.labels) == (4, 3, 9)
    assert report.lines()[0].endswith(
        "40 vertices, 60 faces, 2 layers, 6 vertex attributes, 4 face attributes, 4 materials, "
        "3 textures, 9 labels"
    )


@pytest.mark.parametrize("suffix", [".glb", ".gltf"])
def test_everything_comes_back_from_gltf(tmp_path, rich_mesh, suffix):
    found, notes, _ = again(tmp_path, rich_mesh, suffix)
    assert_same(found, rich_mesh, set(vars(rich_mesh)) - {"features", "source"})
    assert len(notes) == 5 and "12 texture features" in notes[-2]
    assert notes[0].startswith("vertex colors are attribute _VERTEX_COLOR")
    assert notes[-1] == ORIGIN


def test_gltf_has_its_data_and_images_beside_it(tmp_path, rich_mesh):
    """What others read: JSON that names files which are there."""
    write_mesh(tmp_path / "a.gltf", rich_mesh)
    document = json.loads((tmp_path / "a.gltf").read_text())
    (buffer,) = document["buffers"]
    assert buffer == {"byteLength": (tmp_path / "a.bin").stat().st_size, "uri": "a.bin"}
    names = [image["uri"] for image in document["images"]]
    assert names == ["a_gltf_texture_%d.png" % index for index in (0, 2, 10)]
    assert sorted(os.listdir(tmp_path)) == sorted(["a.gltf", "a.bin", *names])
    with pytest.raises(MapFileError, match="a.gltf: the file exists already"):
        write_mesh(tmp_path / "a.gltf", rich_mesh)


def test_what_collada_takes_comes_back(tmp_path, rich_mesh):
    """Through assimp, which takes no vertex that no face has, and which gives faces by material."""
    mesh = Mesh(SQUARE, TWO_FACES, vertex_normals=np.float32([[0, 0, 1]] * 4))
    mesh.vertex_colors = np.uint8([[0, 1, 2], [128, 254, 255], [7, 8, 9], [3, 2, 1]])
    mesh.texture_coordinates = np.float32([[0.1, 0.2], [1, 0], [1, 1], [0, 1 / 3]])
    mesh.textures = {4: rich_mesh.textures[0], 7: rich_mesh.textures[10]}
    colors = np.full((2, 3), 255, np.uint8)
    mesh.materials = Materials(colors, np.int32([4, 7]), np.uint32([1, 0]))
    found, notes, report = again(tmp_path, mesh, ".dae")
    assert notes == [] and len(report.notes) == 2 and "were applied: meters" in report.notes[0]
    for face in range(2):
        # faces of one material come together
        row = int(
            np.flatnonzero((found.vertices[found.faces] == SQUARE[TWO_FACES[face]]).all((1, 2)))
        )
        for name in ("vertex_colors", "vertex_normals", "texture_coordinates"):
            wanted = getattr(mesh, name)[TWO_FACES[face]]
            assert np.allclose(getattr(found, name)[found.faces[row]], wanted, rtol=3e-7), name
        of_face = found.materials.face_materials[row]
        image = found.textures[int(found.materials.texture_indices[of_face])]
        before = mesh.materials.texture_indices[mesh.materials.face_materials[face]]
        assert identical(image, mesh.textures[int(before)])


def test_colors_of_collada_materials_come_back(tmp_path):
    colors = np.uint8([[1, 2, 3], [254, 128, 0]])
    mesh = Mesh(SQUARE, TWO_FACES)
    mesh.materials = Materials(colors, np.int32([-1, -1]), np.uint32([1, 0]))
    found, _, _ = again(tmp_path, mesh, ".dae")
    assert {tuple(color) for color in found.materials.colors} == {(1, 2, 3), (254, 128, 0)}


def test_colors_of_textured_collada_materials_come_back(tmp_path):
    """Also more than ten textures, under their numbers, and materials that no face has."""
    count = 13
    vertices = np.concatenate([SQUARE + np.float32([0, 0, 5 * i]) for i in range(count)])
    faces = np.concatenate([TWO_FACES + np.uint32(4 * i) for i in range(count)])
    uv = (vertices[:, :2] / 2).astype(np.float32)
    mesh = Mesh(vertices, faces, texture_coordinates=uv)
    mesh.textures = {3 * i: pixels(i) for i in range(count)}
    colors = np.random.default_rng(1).integers(0, 256, (count + 1, 3)).astype(np.uint8)
    numbers = np.append(np.arange(count) * 3, -1).astype(np.int32)
    mesh.materials = Materials(colors, numbers, np.repeat(np.arange(count), 2).astype(np.uint32))
    found, notes, report = again(tmp_path, mesh, ".dae")
    assert_same(found, mesh, ["materials", "textures"])
    assert notes == []
    # the extra of a document whose materials others have renamed is believed no more
    path = tmp_path / "a mesh.dae"
    path.write_text(path.read_text().replace("material_3", "stone"))
    found, _ = read_mesh(path)
    assert len(found.materials.colors) == count and len(found.textures) == count


def test_collada_says_what_it_leaves_out(tmp_path, rich_mesh):
    _, notes, _ = again(tmp_path, rich_mesh, ".dae")
    assert [note.split(",")[0].replace("left out: ", "") for note in notes] == [
        "2 layers",
        "6 vertex attributes",
        "4 face attributes",
        "9 labels",
        "12 texture features",
        "the origin (3 coordinates)",
        "the coordinate reference system (10 letters)",
        "the frame floor_2",
    ]


def test_what_obj_takes_comes_back(tmp_path, rich_mesh):
    found, notes, report = again(tmp_path, rich_mesh, ".obj")
    members = ARRAYS + ("textures", "materials", "labels", "frame_id", "origin", "crs")
    assert_same(found, rich_mesh, members)
    assert report.notes == []
    assert notes == [
        "left out: 2 layers, which OBJ does not have; --layer NAME paints one into the colors",
        "left out: 6 vertex attributes, which OBJ does not have",
        "left out: 4 face attributes, which OBJ does not have",
        "left out: 12 texture features, which OBJ does not have",
        ORIGIN + ADDED,
    ]


@pytest.mark.parametrize("animal", ANIMALS, ids=lambda mesh: mesh.name)
def test_stl_keeps_the_surface(tmp_path, animal):
    mesh = Mesh(animal.vertices, animal.faces)
    found, notes, _ = again(tmp_path, mesh, ".stl")
    corners = mesh.vertices[mesh.faces] + np.float32(0)
    assert found.vertices[found.faces].tobytes() == corners.tobytes()
    assert len(notes) == 1 and "welds" in notes[0]


def test_stl_says_what_it_leaves_out(tmp_path, rich_mesh):
    _, notes, _ = again(tmp_path, rich_mesh, ".stl")
    assert [note.split(",")[0] for note in notes[:-1]] == [
        "left out: " + what
        for what in (
            "40 normals",
            "40 vertex colors",
            "2 layers",
            "6 vertex attributes",
            "4 face attributes",
            "40 texture coordinates",
            "3 textures",
            "4 materials",
            "9 labels",
            "12 texture features",
            "the origin (3 coordinates)",
            "the coordinate reference system (10 letters)",
            "the frame floor_2",
        )
    ]


@pytest.mark.parametrize("suffix", EXACT)
@pytest.mark.parametrize("name", ["botanical_garden_gazebo.ply", "tray.ply"])
def test_the_real_meshes_come_back(tmp_path, real_mesh, name, suffix):
    mesh, _ = read_mesh(real_mesh(name))
    rng = np.random.default_rng(5)
    mesh.labels = {
        "tree_%d" % i: Label(rng.choice(len(mesh.faces), 500, False).astype(np.uint32), (i, i, i))
        for i in range(5)
    }
    found, _, _ = again(tmp_path, mesh, suffix)
    members = ARRAYS + ("labels",)
    assert_same(found, mesh, members + (() if suffix == ".obj" else ("vertex_costs",)))
    if suffix != ".obj":
        assert_same(found, mesh, ["face_attributes"])


@st.composite
def meshes(draw):
    """Meshes of any values, with any of what PLY and OBJ take."""
    rows, faces = draw(st.integers(1, 6)), draw(st.integers(1, 5))

    def maybe(*shape, kind=np.float32, elements=NUMBERS):
        return draw(st.none() | hnp.arrays(kind, (rows,) + shape, elements=elements))

    mesh = Mesh(
        draw(hnp.arrays(np.float32, (rows, 3), elements=NUMBERS)),
        draw(hnp.arrays(np.uint32, (faces, 3), elements=st.integers(0, rows - 1))),
        vertex_normals=maybe(3),
        vertex_colors=maybe(3, kind=np.uint8, elements=st.integers(0, 255)),
        texture_coordinates=maybe(2),
    )
    names = st.text(
        st.characters(blacklist_categories=("C", "Z"), blacklist_characters="/"), min_size=1
    )
    label_faces = st.lists(st.integers(0, faces - 1), unique=True)
    for name in draw(st.lists(names, max_size=3, unique=True)):
        if name not in (".", ".."):
            color = draw(st.none() | st.tuples(*[st.integers(0, 255)] * 3))
            mesh.labels[name] = Label(np.array(draw(label_faces), np.uint32), color)
    if draw(st.booleans()):
        mesh.textures = {3: pixels(1), 0: pixels(2, bands=4)}
        mesh.materials = Materials(
            np.array([[1, 2, 3], [255, 255, 255], [0, 0, 0]], np.uint8),
            np.array([3, -1, 0], np.int32),
            draw(hnp.arrays(np.uint32, faces, elements=st.integers(0, 2))),
        )
    return mesh


@settings(max_examples=100)
@given(mesh=meshes(), suffix=st.sampled_from(EXACT))
def test_any_mesh_comes_back(tmp_path, mesh, suffix):
    found, _, _ = again(tmp_path, mesh, suffix)
    assert_same(found, mesh, ARRAYS + ("labels", "materials") if mesh.materials else ARRAYS)
    assert {k: v.tobytes() for k, v in found.textures.items()} == {
        k: v.tobytes() for k, v in mesh.textures.items()
    }


@settings(max_examples=60)
@given(
    names=st.lists(
        st.sampled_from(
            [
                "x",
                "nx",
                "red",
                "s",
                "alpha",
                "flags",
                "layer_x",
                "a b",
                "a_b",
                "ä",
                "_LETHAL",
                "Ä",
                "q",
            ]
        ),
        unique=True,
        max_size=6,
    ),
    suffix=st.sampled_from([".ply", ".glb"]),
    special=hnp.arrays(
        np.float32,
        4,
        elements=st.sampled_from([0.0, -0.0, LARGEST, -LARGEST, TINIEST, np.inf, np.nan]),
    ),
)
def test_layers_of_any_name_come_back(tmp_path, names, suffix, special):
    mesh = Mesh(SQUARE, TWO_FACES, vertex_costs={name: special.copy() for name in names})
    mesh.layer_parameters = {name: {"radius": 0.5} for name in names[::2]}
    mesh.face_attributes = {
        name: np.arange(2).astype(kind)
        for name, kind in zip(names, ("u1", "i2", "f2", "f8", "i8", "u8"))
    }
    found, _, _ = again(tmp_path, mesh, suffix)
    assert_same(found, mesh, ["vertex_costs", "layer_parameters", "face_attributes"])


@pytest.mark.parametrize("suffix", EXACT)
def test_a_layer_is_painted_in_the_colors_of_rviz(tmp_path, rich_mesh, suffix):
    costs = np.linspace(0, 5, 40).astype(np.float32)
    costs[[3, 4]] = np.inf, np.nan
    rich_mesh.vertex_costs["slope"] = costs
    found, notes, _ = again(tmp_path, rich_mesh, suffix, layer="slope")
    assert found.vertex_colors[[0, 39, 3, 4]].tolist() == [
        [255, 0, 255],
        [255, 0, 0],
        [255, 20, 147],
        [104, 78, 40],
    ]
    assert found.materials is None and not found.textures and len(rich_mesh.textures) == 3
    assert notes[:2] == [
        "the vertex colors are those of layer slope, not of the mesh",
        "left out: materials and textures, which would hide the colors of the layer",
    ]
    with pytest.raises(MapFileError, match="no layer steepness to paint.*height_diff, slope"):
        write_mesh(tmp_path / "b.ply", rich_mesh, layer="steepness")


def test_other_programs_read_what_was_written(tmp_path):
    """meshio reads geometry, layers and numbers of faces."""
    meshio = pytest.importorskip("meshio")
    world = zoo.outdoor_world(faces=2000, seed=2)
    mesh = Mesh(world.vertices, world.faces, vertex_costs={"slope": world.vertices[:, 2].copy()})
    for suffix in (".ply", ".obj", ".stl"):
        write_mesh(tmp_path / ("a" + suffix), mesh)
        other = meshio.read(tmp_path / ("a" + suffix))
        triangles = other.points[other.cells_dict["triangle"]]
        assert np.array_equal(triangles.astype(np.float32), world.vertices[world.faces])
        if suffix != ".stl":
            assert np.array_equal(other.points.astype(np.float32), world.vertices)
    assert np.array_equal(
        meshio.read(tmp_path / "a.ply").point_data["slope"], mesh.vertex_costs["slope"]
    )


def test_nothing_is_replaced_unasked(tmp_path, rich_mesh):
    path = tmp_path / "a.obj"
    write_mesh(path, rich_mesh)
    files = sorted(os.listdir(tmp_path))
    assert files == ["a.mtl", "a.obj"] + ["a_obj_texture_%d.png" % i for i in (0, 10, 2)]
    before = {name: (tmp_path / name).read_bytes() for name in files}
    with pytest.raises(MapFileError, match="exists already"):
        write_mesh(path, rich_mesh)
    for changed in ("a.mtl", "a_obj_texture_2.png"):
        path.unlink()
        (tmp_path / changed).write_bytes(b"of somebody else")
        with pytest.raises(MapFileError, match=changed + ".*exists already"):
            write_mesh(path, rich_mesh)
        assert sorted(os.listdir(tmp_path)) == [name for name in files if name != "a.obj"]
        (tmp_path / changed).write_bytes(before[changed])
        write_mesh(path, rich_mesh)  # textures that are the same stay
    (tmp_path / "a.mtl").write_bytes(b"old")
    write_mesh(path, rich_mesh, overwrite=True)
    assert before == {name: (tmp_path / name).read_bytes() for name in files}


@pytest.mark.parametrize("failing", range(1, 6))
def test_a_failure_leaves_no_litter(tmp_path, rich_mesh, monkeypatch, failing):
    """The disk is full at the k-th file: those before it are gone."""
    calls = []

    def replace(source, target):
        calls.append(target)
        if len(calls) == failing:
            raise OSError(28, "No space left on device")
        os.rename(source, target)

    monkeypatch.setattr(os, "replace", replace)
    with pytest.raises(MapFileError) as refused:
        write_mesh(tmp_path / "a.obj", rich_mesh)
    assert refused.value.code == "save" and os.listdir(tmp_path) == []
    assert len(calls) == failing and (failing < 5 or calls[-1].endswith("a.obj"))


@pytest.mark.parametrize("name,code", [("a.xyz", "format"), ("a", "format"), ("no/a.ply", "save")])
def test_places_that_cannot_be(tmp_path, name, code):
    with pytest.raises(MapFileError) as refused:
        write_mesh(tmp_path / name, Mesh(SQUARE, TWO_FACES))
    assert refused.value.code == code and os.listdir(tmp_path) == []


@pytest.mark.parametrize("suffix", WRITERS)
def test_a_mesh_that_is_not_sound_is_not_written(tmp_path, suffix):
    vertices = SQUARE.copy()
    vertices[1, 1] = np.nan
    for mesh, code in (
        (Mesh(vertices, TWO_FACES), "not_finite"),
        (Mesh(SQUARE, TWO_FACES + np.uint32(1)), "index"),
        (Mesh(SQUARE, TWO_FACES[:0]), "no_faces"),
    ):
        with pytest.raises(MapFileError) as refused:
            write_mesh(tmp_path / ("a" + suffix), mesh)
        assert refused.value.code == code
    assert os.listdir(tmp_path) == []


def test_every_color_of_obj_is_read_by_others(tmp_path):
    """As float32 it is the very number; whoever cuts off the fraction gets the same byte, too."""
    rows = np.arange(256, dtype=np.uint8)
    colors = np.stack([rows, rows[::-1], rows // 2], axis=1)
    vertices = np.random.default_rng(1).normal(size=(256, 3)).astype(np.float32)
    mesh = Mesh(vertices, np.arange(255, dtype=np.uint32).reshape(-1, 3), vertex_colors=colors)
    mesh.materials = Materials(colors, np.full(256, -1, np.int32), np.zeros(85, np.uint32))
    write_mesh(tmp_path / "a.obj", mesh)
    for name, key, first in (("a.obj", "v", 4), ("a.mtl", "Kd", 1)):
        lines = (tmp_path / name).read_text().splitlines()
        found = [line.split()[first:] for line in lines if line.startswith(key + " ")]
        found = np.array(found, np.float64)
        assert np.array_equal(found.astype(np.float32), (colors / 255).astype(np.float32))
        assert np.array_equal((found * 255).astype(np.uint8), colors)
        assert np.array_equal((found.astype(np.float32) * np.float32(255)).astype(np.uint8), colors)
