"""What a user may ask of an import: an origin, merging, repairing; everything else follows."""
import numpy as np
import pytest
from mesh_msgs import zoo
from mesh_writers import SQUARE, TWO_FACES, obj, ply, stl, xyz

from mesh_msgs_hdf5.formats.base.report import ImportReport
from mesh_msgs_hdf5.formats.importer import read_mesh
from mesh_msgs_hdf5.formats.merge import merge_vertices
from mesh_msgs_hdf5.formats.repair import faces_to_flip, repair
from mesh_msgs_hdf5.map_file import MapFile
from mesh_msgs_hdf5.model.errors import MapFileError
from mesh_msgs_hdf5.model.mesh import Label, Materials, Mesh

ANIMALS = {mesh.name: mesh for mesh in zoo.all_meshes() if len(mesh.faces)}
FAR = np.array([431234.567, 5791234.321, 87.6])


@pytest.fixture
def read(tmp_path):
    """Read the bytes of a file of that name: (mesh, report)."""

    def read(name, data, **options):
        (tmp_path / name).write_bytes(data)
        return read_mesh(tmp_path / name, **options)

    return read


def far_files():
    vertices = SQUARE + FAR
    yield "a.ply", ply(xyz(vertices, "d"), TWO_FACES)
    yield "a.ply", ply(xyz(vertices, "d"), TWO_FACES, "ascii")
    yield "a.obj", obj(vertices, TWO_FACES)


@pytest.mark.parametrize("name,data", far_files())
def test_the_origin_is_subtracted_before_rounding(read, name, data):
    mesh, report = read(name, data, origin="auto")
    assert mesh.origin == (431235.0, 5791235.0, 89.0)  # the middle is 431235.067 5791235.321 89.1
    assert np.abs(mesh.vertices + np.array(mesh.origin) - (SQUARE + FAR)).max() < 1e-6
    assert report.notes == [
        "origin (431235.0, 5791235.0, 89.0) was subtracted from the coordinates"
    ]
    assert mesh.source["options"] == {"origin": "auto"}
    mesh, _ = read(name, data, origin=(431000, 5791000, 0))
    assert mesh.origin == (431000.0, 5791000.0, 0.0)
    assert np.abs(mesh.vertices + np.array(mesh.origin) - (SQUARE + FAR)).max() < 1e-4
    mesh, report = read(name, data)
    assert mesh.origin == (0, 0, 0) and np.array_equal(mesh.vertices, np.float32(SQUARE + FAR))
    change = np.abs(mesh.vertices - (SQUARE + FAR)).max()
    assert report.notes == [
        "coordinates were rounded to float32, by at most %.3g m (far from the origin?); "
        "--origin auto keeps them" % change
    ]


def test_the_origin_of_stl_and_of_meshes_near_zero(read):
    mesh, _ = read("a.stl", stl(SQUARE + np.float32(100), TWO_FACES), origin="auto")
    assert mesh.origin == (100.0, 101.0, 102.0) and np.array_equal(
        mesh.vertices, SQUARE - np.float32([0, 1, 2])
    )
    mesh, report = read("a.ply", ply(xyz(SQUARE * np.float32(0.1)), TWO_FACES), origin="auto")
    assert mesh.origin == (0.0, 0.0, 0.0) and report.notes == []
    assert not np.signbit(mesh.origin).any()


def test_the_origin_of_a_map_is_moved(tmp_path):
    path = tmp_path / "a.h5"
    MapFile.write(path, Mesh(SQUARE, TWO_FACES, origin=(1000.0, 0.0, 0.0)))
    mesh, _ = read_mesh(path, origin=(990, 0, 0))
    assert mesh.origin == (990.0, 0.0, 0.0)
    assert np.array_equal(mesh.vertices, SQUARE + np.float32([10, 0, 0]))
    mesh, report = read_mesh(path)
    assert mesh.origin == (1000.0, 0.0, 0.0) and report.notes == []


@pytest.mark.parametrize(
    "options",
    [
        {"origin": "here"},
        {"origin": (1, 2)},
        {"origin": (1, 2, np.nan)},
        {"origin": 7},
        {"merge_vertices": -1},
        {"merge_vertices": np.inf},
        {"merge_vertices": "near"},
    ],
)
def test_options_that_are_none(read, options):
    with pytest.raises(MapFileError) as refused:
        read("a.ply", ply(xyz(SQUARE), TWO_FACES), **options)
    assert refused.value.code == "value" and str(list(options)[0]) in refused.value.message


def annotated(vertices, faces, **more):
    """A mesh whose every value tells which vertex or face it is of."""
    rows, count = len(vertices), len(faces)
    number = np.arange(rows)
    mesh = Mesh(
        np.asarray(vertices, np.float32),
        np.asarray(faces, np.uint32),
        vertex_normals=np.stack([number] * 3, axis=1).astype(np.float32),
        vertex_colors=np.stack([number % 256] * 3, axis=1).astype(np.uint8),
        vertex_costs={"number": number.astype(np.float32)},
        face_attributes={"number": np.arange(count), "pair": np.arange(2 * count).reshape(-1, 2)},
        materials=Materials(
            np.zeros((count, 3), np.uint8),
            np.full(count, -1, np.int32),
            np.arange(count, dtype=np.uint32),
        ),
        labels={"all_1": Label(np.arange(count, dtype=np.uint32), (1, 2, 3))},
    )
    for name, value in more.items():
        setattr(mesh, name, value)
    return mesh


def check_follows(mesh, vertices_of, faces_of):
    """Each vertex and face of the mesh has the values of those that it comes from."""
    assert mesh.vertex_normals[:, 0].tolist() == vertices_of
    assert mesh.vertex_colors[:, 0].tolist() == [i % 256 for i in vertices_of]
    assert mesh.vertex_costs["number"].tolist() == vertices_of
    assert mesh.face_attributes["number"].tolist() == faces_of
    assert mesh.face_attributes["pair"].tolist() == [[2 * i, 2 * i + 1] for i in faces_of]
    assert mesh.materials.face_materials.tolist() == faces_of
    assert sorted(mesh.labels["all_1"].faces.tolist()) == list(range(len(faces_of)))


def merged(mesh, tolerance):
    report = ImportReport("a", "PLY")
    return merge_vertices("a", mesh, tolerance, report), report


def test_vertices_at_the_same_place_merge():
    vertices = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 0, 0], [0.0, 1, 0], [1, 1, 0], [-0.0, 0, 0]]
    faces = [[0, 1, 2], [3, 5, 4], [6, 1, 0], [2, 2, 1]]
    mesh, report = merged(annotated(vertices, faces), 0)
    assert mesh.vertices.tolist() == [[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]]
    # the third face has no area any more; the fourth had none before
    assert mesh.faces.tolist() == [[0, 1, 2], [1, 3, 2], [2, 2, 1]]
    check_follows(mesh, [0, 1, 2, 5], [0, 1, 3])
    assert report.notes == [
        "merging within 0 m: 3 vertices fell into others",
        "merging: 1 faces without area were dropped, first face 2",
    ]
    assert (report.merged, report.dropped_faces) == (3, 1)


def test_chains_merge_and_seams_keep_copies():
    vertices = [[0, 0, 0], [0.09, 0, 0], [0.18, 0, 0], [5, 0, 0], [5, 5, 0], [5, 0, 0.05]]
    mesh = annotated(vertices, [[2, 3, 4], [1, 5, 4]])
    mesh.texture_coordinates = np.zeros((6, 2), np.float32)
    mesh.texture_coordinates[5] = 1
    result, _ = merged(mesh, 0.1)
    assert np.array_equal(result.vertices, mesh.vertices[[0, 3, 4, 3]])
    assert result.seam_originals.tolist() == [1] and len(result.parent_vertices) == 3
    assert result.faces.tolist() == [[0, 1, 2], [0, 3, 2]]
    check_follows(result, [0, 3, 4, 5], [0, 1])
    mesh.texture_coordinates = None
    assert len(merged(mesh, 0.1)[0].vertices) == 3
    same, report = merged(mesh, 0.01)
    assert same is mesh and report.notes == ["merging within 0.01 m: there was nothing to merge"]


@pytest.mark.parametrize("tolerance", [0.0, 0.02, 0.2])
def test_merging_is_what_brute_force_says(tolerance):
    rng = np.random.default_rng(6)
    vertices = rng.integers(0, 12, (150, 3)).astype(np.float32) / 40
    mesh = annotated(vertices, rng.integers(0, 150, (50, 3)))
    far = np.linalg.norm(vertices[:, None].astype(float) - vertices[None], axis=2)
    group = np.arange(150)
    while True:
        new = np.array([group[far[i] <= tolerance].min() for i in range(150)])
        if np.array_equal(new, group):
            break
        group = new
    result, _ = merged(mesh, tolerance)
    first = np.unique(group)
    assert np.array_equal(result.vertices, vertices[first])
    faces = np.searchsorted(first, group[mesh.faces])
    before = [len(set(face)) == 3 for face in mesh.faces.tolist()]
    kept = [not b or len(set(face)) == 3 for b, face in zip(before, faces.tolist())]
    assert result.faces.tolist() == faces[kept].tolist()


def test_a_distance_that_joins_everything():
    vertices = np.random.default_rng(1).random((20000, 3))
    mesh = Mesh(vertices.astype(np.float32), np.array([[0, 1, 2]], np.uint32))
    with pytest.raises(MapFileError, match="joins 199990000 pairs.*far below the length"):
        merged(mesh, 10.0)


def test_a_distance_that_leaves_no_face():
    mesh = annotated(np.eye(3), [[0, 1, 2]])
    with pytest.raises(MapFileError, match="within 2 m leaves no face .*length of the edges") as at:
        merged(mesh, 2.0)
    assert at.value.code == "value"


def repaired(mesh):
    report = ImportReport("a", "PLY")
    return repair("a", mesh, report), report


def test_everything_is_repaired(read):
    inf, nan = np.inf, np.nan
    vertices = [
        [0, 0, 0],
        [nan, 0, 0],
        [1, 0, 0],
        [1, 2, 0],
        [0, 2, 0],
        [7, 7, 7],
        [inf, 1, 1],
        [2, 0, 0],
    ]
    faces = [
        [0, 2, 3],
        [0, 1, 2],
        [0, 0, 3],
        [0, 2, 7],
        [4, 3, 0],
        [3, 0, 2],
        [2, 3, 6],
        [0, 4, 3],
    ]
    mesh, report = repaired(annotated(vertices, faces))
    assert mesh.vertices.tolist() == [[0, 0, 0], [1, 0, 0], [1, 2, 0], [0, 2, 0]]
    assert mesh.faces.tolist() == [[0, 1, 2], [3, 0, 2]]
    check_follows(mesh, [0, 2, 3, 4], [0, 4])
    assert report.notes == [
        "repair: 2 faces at vertices that are not finite were dropped, first face 1",
        "repair: 2 faces without area were dropped, first face 1",
        "repair: 2 duplicate faces were dropped, first face 2",
        "repair: 4 vertices without faces were dropped, first vertex 1",
        "repair: 1 faces were turned over, first face 1",
    ]
    assert (report.dropped_faces, report.dropped_vertices, report.flipped) == (6, 4, 1)
    # the same through a file; without asking it is refused
    data = ply(xyz(vertices), faces)
    found, _ = read("a.ply", data, repair=True)
    assert np.array_equal(found.vertices, mesh.vertices)
    assert np.array_equal(found.faces, mesh.faces) and found.source["options"] == {"repair": True}
    with pytest.raises(MapFileError, match="vertex 1 is not finite"):
        read("a.ply", data)
    found, _ = read("a.stl", stl(np.float32(vertices), faces), repair=True)
    assert len(found.faces) == 2 and len(found.vertices) == 4
    found, _ = read("a.obj", obj(vertices, faces), repair=True, origin="auto")
    assert len(found.faces) == 2 and found.origin == (4.0, 4.0, 4.0)


def test_labels_of_duplicates_go_to_their_twins():
    faces = [[0, 1, 2], [2, 1, 0], [0, 2, 3], [1, 1, 2]]
    mesh = Mesh(SQUARE, np.array(faces, np.uint32))
    mesh.labels = {
        "a_1": Label(np.array([3, 1, 2], np.uint32), (4, 5, 6)),
        "b_1": Label(np.array([1, 0], np.uint32)),
        "c_1": Label(np.array([3], np.uint32)),
    }
    mesh, _ = repaired(mesh)
    assert {text: label.faces.tolist() for text, label in mesh.labels.items()} == {
        "a_1": [0, 1],
        "b_1": [0],
        "c_1": [],
    }
    assert mesh.labels["a_1"].color == (4, 5, 6) and mesh.labels["c_1"].faces.dtype == np.uint32


def edges_that_disagree(faces):
    """Edges of two faces that run through them in the same direction."""
    seen = {}
    for face in faces.tolist():
        for a, b in zip(face, face[1:] + face[:1]):
            seen.setdefault((min(a, b), max(a, b)), []).append(a < b)
    return sum(len(way) == 2 and way[0] == way[1] for way in seen.values())


@pytest.mark.parametrize("name", ANIMALS)
def test_orientation_of_the_zoo(name):
    animal = ANIMALS[name]
    sound = (animal.faces != np.roll(animal.faces, 1, axis=1)).all(axis=1)
    faces = animal.faces[sound]
    rng = np.random.default_rng(2)
    some = rng.random(len(faces)) < 0.3
    mixed = faces.copy()
    mixed[some, 1:] = mixed[some, :0:-1]
    flip, one_sided = faces_to_flip(mixed)
    turned = mixed.copy()
    turned[flip, 1:] = turned[flip, :0:-1]
    if "manifold" in animal.traits:
        assert one_sided == (0 if "orientable" in animal.traits else len(faces))
    if not one_sided:
        assert edges_that_disagree(turned) == 0
        if len(faces) > 20 and {"connected", "manifold", "oriented"} <= animal.traits:
            assert np.array_equal(flip, some) and np.array_equal(turned, faces)
    else:
        assert not flip.any()


def edges(mesh):
    corners = mesh.vertices[mesh.faces]
    return corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]


@pytest.mark.parametrize("name", ANIMALS)
def test_repairing_the_zoo_changes_what_its_traits_say(name):
    animal = ANIMALS[name]
    mesh, report = repaired(Mesh(animal.vertices.copy(), animal.faces.copy()))
    traits = animal.traits
    assert (report.dropped_vertices > 0) == ("isolated_vertices" in traits)
    if "duplicate_faces" in traits or name == "zero_area_face":
        assert report.dropped_faces
    elif "degenerate" not in traits:
        assert not report.dropped_faces
    if "oriented" in traits and "duplicate_faces" not in traits:
        assert not report.flipped
    if name == "flipped_face":
        grid = zoo.grid(3, 3.0)
        assert report.flipped == 1 and np.array_equal(
            np.cross(*edges(mesh))[:, 2], np.cross(*edges(grid))[:, 2]
        )
    again, report = repaired(mesh)
    assert [note for note in report.notes if "one-sided" not in note] == []
    assert np.array_equal(again.faces, mesh.faces)


def test_nothing_is_left(read):
    with pytest.raises(MapFileError) as refused:
        read("a.ply", ply(xyz(SQUARE), [[0, 0, 1]]), repair=True)
    assert refused.value.code == "no_faces" and "leaves no face" in refused.value.message
    mesh, report = read("a.ply", ply(xyz(SQUARE), [[0, 0, 1]]))
    assert mesh.faces.tolist() == [[0, 0, 1]] and report.notes == []


def test_minus_infinity_becomes_unknown(read):
    data = ply(xyz(SQUARE) + [("cost", "f", [-np.inf, 0, 1, np.inf])], TWO_FACES)
    with pytest.raises(MapFileError, match="layer cost is -inf at vertex 0"):
        read("a.ply", data)
    mesh, report = read("a.ply", data, repair=True)
    assert np.isnan(mesh.vertex_costs["cost"][0]) and mesh.vertex_costs["cost"][3] == np.inf
    assert "repair: 1 values -inf of layer cost became unknown (NaN)" in report.notes


def test_a_map_is_merged_and_repaired(tmp_path):
    path = tmp_path / "a.h5"
    vertices = np.concatenate([SQUARE, SQUARE[:1]])
    mesh = annotated(vertices, [[0, 1, 2], [4, 2, 3], [3, 3, 1]], source={"file": "x"})
    MapFile.write(path, mesh)
    found, report = read_mesh(path, merge_vertices=0, repair=True)
    assert found.faces.tolist() == [[0, 1, 2], [0, 2, 3]] and len(found.vertices) == 4
    check_follows(found, [0, 1, 2, 3], [0, 1])
    assert found.source == {"file": "x", "options": {"merge_vertices": 0.0, "repair": True}}
    assert (report.merged, report.dropped_faces, report.vertices) == (1, 1, 4)


def test_without_options_a_map_is_as_it_is(tmp_path):
    path = tmp_path / "a.h5"
    mesh = annotated(SQUARE, TWO_FACES)
    MapFile.write(path, mesh)
    found, report = read_mesh(path)
    assert report.notes == [] and np.array_equal(found.vertices, SQUARE)
    assert found.source == {} and report.labels == 1
