"""Textures survive: vertices get copies along seams, and nothing else of the mesh changes."""
import numpy as np
import pytest
from mesh_writers import SQUARE, image_bytes, pixels
from seam_samples import IMAGES, MODELS, closed_box, striped_terrain, write_obj

from mesh_msgs_hdf5.formats.any_mesh import open_members
from mesh_msgs_hdf5.formats.base.report import ImportReport
from mesh_msgs_hdf5.formats.exporter import write_mesh
from mesh_msgs_hdf5.formats.importer import read_mesh
from mesh_msgs_hdf5.formats.merge import merge_vertices
from mesh_msgs_hdf5.formats.repair import repair
from mesh_msgs_hdf5.map_file import MapFile
from mesh_msgs_hdf5.model.mesh import Label, Mesh
from mesh_msgs_hdf5.model.seams import without_copies


@pytest.fixture(params=MODELS)
def model(request):
    return MODELS[request.param]()


@pytest.fixture
def path(tmp_path, model):
    return write_obj(tmp_path, model)


def same(one, other, *but):
    """Everything of two meshes is the same, but for these members."""
    for name in set(vars(one)) - set(but) - {"source"}:
        a, b = getattr(one, name), getattr(other, name)
        if name == "materials":
            for part in ("colors", "texture_indices", "face_materials"):
                assert np.array_equal(getattr(a, part), getattr(b, part)), part
        elif name == "labels":
            assert {k: (v.faces.tolist(), v.color) for k, v in a.items()} == {
                k: (v.faces.tolist(), v.color) for k, v in b.items()
            }
        elif isinstance(a, dict):
            assert a.keys() == b.keys(), name
            assert all(np.array_equal(a[key], b[key], equal_nan=True) for key in a), name
        else:
            assert np.array_equal(a, b) if isinstance(a, np.ndarray) else a == b, name


def test_what_is_seen_is_what_the_file_has(path, model):
    """Each corner of each face has its position, texture coordinates and image."""
    vertices, faces, uv = model
    mesh, report = read_mesh(path)
    assert np.array_equal(mesh.vertices[mesh.faces], vertices[faces])
    assert np.array_equal(mesh.texture_coordinates[mesh.faces], np.float32(uv))
    assert [mesh.textures[i].tobytes() for i in sorted(mesh.textures)] == [
        image.tobytes() for image in IMAGES.values()
    ]
    assert mesh.materials.face_materials.tolist() == [int(i % 3 == 2) for i in range(len(faces))]
    assert report.split == len(mesh.seam_originals) > 0
    assert not [note for note in report.notes if "left out" in note]


def test_original_vertices_and_faces_stay(path, model):
    vertices, faces, _ = model
    mesh, _ = read_mesh(path)
    assert np.array_equal(mesh.vertices[: len(vertices)], vertices)
    assert np.array_equal(mesh.vertices[len(vertices) :], vertices[mesh.seam_originals])
    assert np.array_equal(mesh.parent_faces, faces)
    plain, report = read_mesh(path, split_seams=False)
    assert plain.uuid == mesh.parent_uuid and plain.seam_originals is None
    assert plain.texture_coordinates is None and not plain.textures
    assert any("seams" in note for note in report.notes)
    same(without_copies(mesh), plain, "materials")  # white ones say nothing


def test_a_mesh_without_seams_has_no_copies(tmp_path, model):
    vertices, faces, _ = model
    uv = (vertices[:, :2] / 7)[faces]
    mesh, report = read_mesh(write_obj(tmp_path, (vertices, faces, uv)))
    assert mesh.seam_originals is None and mesh.parent_uuid == "" and len(mesh.textures) == 2
    assert np.array_equal(mesh.vertices, vertices) and np.array_equal(mesh.faces, faces)
    assert report.split == 0 and report.notes == []


def test_faces_without_material_and_vertices_without_faces(tmp_path):
    vertices, faces, uv = closed_box()
    vertices = np.concatenate([vertices, [[9, 9, 9], [8, 8, 8]]]).astype(np.float32)
    faces, uv = faces.copy(), uv.copy()
    faces[-1, 1] = faces[-1, 0]  # without area, and with two places in the texture
    material = np.array([-1, -1, 0, 0, 1, 1, 2, 2, 2, 0, 0, 1])
    mesh, _ = read_mesh(write_obj(tmp_path, (vertices, faces, uv), material=material))
    assert np.array_equal(mesh.parent_vertices, vertices)
    assert np.array_equal(mesh.vertices[mesh.faces], vertices[faces])
    assert np.array_equal(mesh.texture_coordinates[mesh.faces], np.float32(uv))
    colors = mesh.materials.colors[mesh.materials.face_materials]
    images = mesh.materials.texture_indices[mesh.materials.face_materials]
    assert images.tolist() == [-1, -1, 0, 0, 1, 1, -1, -1, -1, 0, 0, 1]
    assert (colors[6:9] == (255, 0, 0)).all() and (colors[:6] == 255).all()


@pytest.mark.parametrize("suffix", ["obj", "ply", "glb", "h5"])
def test_through_every_format_and_back(tmp_path, path, suffix):
    """V, faces, textures, UUID and the table of copies come back."""
    mesh, _ = read_mesh(path)
    mesh.labels = {"side_1": Label(np.arange(4, dtype=np.uint32), (1, 2, 3))}
    colors = np.arange(len(mesh.parent_vertices))[:, None] * [1, 3, 7] % 256
    mesh.vertex_colors = np.concatenate([colors, colors[mesh.seam_originals]]).astype(np.uint8)
    normals = np.random.default_rng(1).normal(size=mesh.vertices.shape)  # also of copies
    mesh.vertex_normals = np.float32(normals / np.linalg.norm(normals, axis=1)[:, None])
    out = tmp_path / ("out." + suffix)
    if suffix == "h5":
        MapFile.write(out, mesh)
    else:
        assert not [note for note in write_mesh(out, mesh) if "left out" in note]
    back, report = read_mesh(out)
    same(back, mesh)
    assert back.uuid == mesh.uuid and back.parent_uuid == mesh.parent_uuid
    assert report.split == 0
    if suffix == "obj":  # other programs get the surface uncut
        text = out.read_text()
        assert text.count("\nv ") == len(mesh.parent_vertices)
        stripped = "\n".join(line for line in text.splitlines() if not line.startswith("#"))
        (tmp_path / "foreign.obj").write_text(stripped)
        found, _ = read_mesh(tmp_path / "foreign.obj")
        assert found.parent_uuid == mesh.parent_uuid and len(found.vertices) == len(mesh.vertices)


def test_obj_of_copies_that_are_not_like_their_originals(tmp_path, path):
    """A v line has one color: all vertices are written, and textures are not lost."""
    mesh, _ = read_mesh(path)
    mesh.vertex_colors = np.zeros((len(mesh.vertices), 3), np.uint8)
    mesh.vertex_colors[-1] = 7
    write_mesh(tmp_path / "out.obj", mesh)
    back, _ = read_mesh(tmp_path / "out.obj")
    same(back, mesh, "seam_originals")


def test_a_mesh_that_is_opened_by_itself_has_its_textures(path):
    opened = open_members(path)
    assert opened.members.texture_indices() == [0, 1] and opened.members.has_seams
    assert opened.members.texture_coordinates is not None


def merged(mesh, tolerance=0.0):
    return merge_vertices("a", mesh, tolerance, ImportReport("a", "PLY"))


def test_merging_makes_copies_of_what_came_split(path):
    """A mesh that other programs have split gets its table, and is whole again."""
    mesh, _ = read_mesh(path)
    order = np.random.default_rng(3).permutation(len(mesh.vertices))
    place = np.argsort(order)
    shuffled = Mesh(
        mesh.vertices[order],
        place[mesh.faces].astype(np.uint32),
        texture_coordinates=mesh.texture_coordinates[order],
    )
    found = merged(shuffled)
    assert len(found.vertices) == len(mesh.vertices)
    assert len(found.seam_originals) == len(mesh.seam_originals)
    assert np.array_equal(found.vertices[found.faces], mesh.vertices[mesh.faces])
    uv = mesh.texture_coordinates[mesh.faces]
    assert np.array_equal(found.texture_coordinates[found.faces], uv)
    assert merged(found) is found
    shuffled.texture_coordinates = None
    assert merged(shuffled).uuid == found.parent_uuid


def test_merging_seams_is_merging_without_textures(tmp_path):
    """Whatever the distance: the parent is the mesh that came without textures, merged."""
    vertices, faces, uv = striped_terrain(8)
    rng = np.random.default_rng(5)
    vertices = np.concatenate([vertices, vertices + rng.normal(0, 1e-3, vertices.shape)])
    vertices = vertices.astype(np.float32)
    faces = np.where(rng.random(faces.shape) < 0.5, faces, faces + len(vertices) // 2)
    path = write_obj(tmp_path, (vertices, faces, uv))
    for options in ({"merge_vertices": 0.01}, {"merge_vertices": 0.0}, {"merge_vertices": 0.5}):
        mesh, _ = read_mesh(path, **options)
        plain, _ = read_mesh(path, split_seams=False, **options)
        assert mesh.parent_uuid == plain.uuid and len(plain.vertices) <= len(vertices)
        assert len(mesh.textures) == 2 and len(mesh.seam_originals)


def test_repairing_seams_is_repairing_without_textures(tmp_path):
    vertices, faces, uv = striped_terrain(6)
    rng = np.random.default_rng(2)
    vertices = np.concatenate([vertices, rng.random((5, 3))]).astype(np.float32)
    some = rng.integers(0, len(faces), 9)
    faces = np.concatenate([faces, faces[some][:, [1, 2, 0]]])  # double, elsewhere in the texture
    uv = np.concatenate([uv, rng.random((9, 3, 2))])
    faces[3, 1] = faces[3, 0]
    turned = rng.random(len(faces)) < 0.1
    turned |= vertices[faces][:, :, 0].mean(1) < 1.4  # most of a stripe, which the others turn
    faces[turned], uv[turned] = faces[turned][:, ::-1], uv[turned][:, ::-1]
    vertices[faces[0, 0]] = np.nan
    path = write_obj(tmp_path, (vertices, faces, uv))
    mesh, report = read_mesh(path, repair=True)
    plain, of_plain = read_mesh(path, repair=True, split_seams=False)
    assert mesh.parent_uuid == plain.uuid
    counts = ("dropped_vertices", "dropped_faces", "flipped")
    assert [getattr(report, c) for c in counts] == [getattr(of_plain, c) for c in counts]
    assert min(getattr(report, c) for c in counts) > 0
    used = np.zeros(len(mesh.vertices), bool)
    used[mesh.faces] = True
    assert used.all() and len(mesh.textures) == 2


def test_a_copy_takes_the_place_of_an_original_without_faces():
    mesh = Mesh(
        np.float32([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [1, 0, 0], [1, 0, 0]]),
        np.uint32([[0, 4, 2], [0, 2, 3], [3, 2, 5]]),
        vertex_costs={"a": np.arange(6, dtype=np.float32)},
        texture_coordinates=np.float32([[i, i] for i in range(6)]),
        seam_originals=np.uint32([1, 1]),
    )
    found = repair("a", mesh, ImportReport("a", "PLY"))
    assert found.vertices.tolist() == [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [1, 0, 0]]
    assert found.parent_faces.tolist() == [[0, 1, 2], [0, 2, 3], [3, 2, 1]]
    assert found.texture_coordinates[:, 0].tolist() == [0, 4, 2, 3, 5]
    assert found.vertex_costs["a"].tolist() == [0, 1, 2, 3, 5]  # the original's
    assert found.seam_originals.tolist() == [1]


def test_copies_that_differ_are_said_where_they_go(tmp_path, path):
    mesh, _ = read_mesh(path)
    count, copies = len(mesh.vertices), len(mesh.seam_originals)
    originals = np.append(np.arange(count - copies), mesh.seam_originals)
    rng = np.random.default_rng(4)
    values = rng.random((count, 3)).astype(np.float32)
    mesh.vertex_costs = {"same": values[originals, 0], "slope": values[:, 0].copy()}
    mesh.vertex_costs["same"][originals == 1] = np.nan
    mesh.vertex_attributes = {"feature": values.copy(), "alike": values[originals]}
    mesh.vertex_attributes["feature"][:-2] = values[originals][:-2]
    mesh.vertex_colors = np.uint8(values * 255)[originals]
    mesh.vertex_colors[-1] += 1
    MapFile.write(tmp_path / "a.h5", mesh)
    _, report = read_mesh(tmp_path / "a.h5", split_seams=False)
    (note,) = [note for note in report.notes if "differ from their originals" in note]
    assert note.endswith(": 1 colors, 2 attribute feature, %d layer slope" % copies)
    mesh.vertex_costs, mesh.vertex_attributes, mesh.vertex_colors = {}, {}, None
    MapFile.write(tmp_path / "a.h5", mesh)
    _, report = read_mesh(tmp_path / "a.h5", split_seams=False)
    assert not any("differ from" in note for note in report.notes)


def test_a_map_without_its_textures(tmp_path, path):
    mesh, _ = read_mesh(path)
    costs = np.arange(len(mesh.vertices), dtype=np.float32)
    mesh.vertex_costs = {"a": costs}
    MapFile.write(tmp_path / "a.h5", mesh)
    plain, report = read_mesh(tmp_path / "a.h5", split_seams=False)
    assert plain.uuid == mesh.parent_uuid and not plain.textures
    largest = costs[: len(plain.vertices)].copy()
    np.maximum.at(largest, mesh.seam_originals, costs[len(plain.vertices) :])
    assert np.array_equal(plain.vertex_costs["a"], largest)
    assert any("seams" in note for note in report.notes)
    back, report = read_mesh(tmp_path / "a.h5")
    same(back, mesh)
    assert report.notes == []


def test_one_texture_in_many_materials_of_a_square(tmp_path):
    """The smallest mesh with a seam: two faces, an edge of which is elsewhere in the image."""
    (tmp_path / "a.png").write_bytes(image_bytes(pixels(1)))
    (tmp_path / "a.mtl").write_text("newmtl m\nmap_Kd a.png\n")
    head = "mtllib a.mtl\n" + "".join("v %g %g %g\n" % tuple(v) for v in SQUARE)
    vt = "vt 0 0\nvt 1 0\nvt 1 1\nvt -3 2.5\nvt 0 1\n"
    (tmp_path / "a.obj").write_text(head + vt + "usemtl m\nf 1/1 2/2 3/3\nf 1/4 3/3 4/5\n")
    mesh, _ = read_mesh(tmp_path / "a.obj")
    assert mesh.faces.tolist() == [[0, 1, 2], [4, 2, 3]] and mesh.seam_originals.tolist() == [0]
    assert mesh.texture_coordinates[4].tolist() == [-3, 2.5]
