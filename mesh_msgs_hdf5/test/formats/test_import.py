"""What importing keeps: every number of PLY and OBJ in its order.

The surface of STL and COLLADA.
"""
import datetime
import hashlib
import struct
import time
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from mesh_msgs import zoo
from mesh_writers import SQUARE, TWO_FACES, dae, obj, ply, stl, stl_text, xyz

from mesh_msgs_hdf5 import __version__
from mesh_msgs_hdf5.formats.importer import read_mesh
from mesh_msgs_hdf5.formats.obj import obj_lines

FORMS = ("ascii", "binary_little_endian", "binary_big_endian")
ANIMALS = [mesh for mesh in zoo.all_meshes() if len(mesh.faces)]


@pytest.fixture
def read(tmp_path):
    """Read the bytes of a file of that name: (mesh, report)."""

    def read(name, data):
        (tmp_path / name).write_bytes(data if isinstance(data, bytes) else data.encode())
        return read_mesh(tmp_path / name)

    return read


def fans(polygons):
    return np.array(
        [(p[0], p[i], p[i + 1]) for p in polygons for i in range(1, len(p) - 1)], np.uint32
    )


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("animal", ANIMALS, ids=lambda mesh: mesh.name)
def test_ply_keeps_vertices_and_faces(read, animal, form):
    mesh, report = read("a.ply", ply(xyz(animal.vertices), animal.faces, form))
    assert mesh.vertices.tobytes() == animal.vertices.tobytes()
    assert mesh.faces.tobytes() == animal.faces.tobytes()
    assert (report.vertices, report.faces, report.notes) == (
        *map(len, (mesh.vertices, mesh.faces)),
        [],
    )


@pytest.mark.parametrize("animal", ANIMALS, ids=lambda mesh: mesh.name)
def test_obj_keeps_vertices_and_faces(read, animal):
    mesh, report = read("a.obj", obj(animal.vertices, animal.faces))
    assert mesh.vertices.tobytes() == animal.vertices.tobytes()
    assert mesh.faces.tobytes() == animal.faces.tobytes()
    assert report.notes == []


def soup(vertices, faces):
    """Corner positions of each face; the first corner stays first."""
    return np.asarray(vertices)[faces] + np.float32(0)


@pytest.mark.parametrize("write", [stl, stl_text])
@pytest.mark.parametrize("animal", ANIMALS, ids=lambda mesh: mesh.name)
def test_stl_keeps_the_surface_and_welds(read, animal, write):
    mesh, report = read("a.stl", write(animal.vertices, animal.faces))
    assert np.array_equal(soup(mesh.vertices, mesh.faces), soup(animal.vertices, animal.faces))
    used = animal.vertices[np.unique(animal.faces)]
    assert len(mesh.vertices) == len(np.unique(used + np.float32(0), axis=0))
    assert len(np.unique(mesh.vertices, axis=0)) == len(mesh.vertices)
    assert report.merged == 3 * len(animal.faces) - len(mesh.vertices)
    _, first = np.unique(mesh.faces.ravel(), return_index=True)
    assert (np.diff(first) > 0).all()  # numbered in the order in which they come first
    assert report.notes == [
        "welded: %d corners at %d different positions; the order of vertices is that of the faces"
        % (3 * len(mesh.faces), len(mesh.vertices))
    ]


@pytest.mark.parametrize("animal", ANIMALS[::4], ids=lambda mesh: mesh.name)
def test_dae_keeps_the_surface_and_welds(read, animal):
    mesh, report = read("a.dae", dae(animal.vertices, animal.faces))
    # assimp reads decimal numbers to the last bit but one
    expected = soup(animal.vertices, animal.faces)
    assert np.allclose(soup(mesh.vertices, mesh.faces), expected, rtol=3e-7, atol=0)
    assert len(mesh.vertices) == len(np.unique(expected.reshape(-1, 3), axis=0))
    assert len(np.unique(mesh.vertices, axis=0)) == len(mesh.vertices)
    assert any("welded" in note for note in report.notes)


@settings(max_examples=80)
@given(
    places=st.lists(st.integers(-100, 100), min_size=7, max_size=7, unique=True),
    polygons=st.lists(st.sets(st.integers(0, 6), min_size=3).map(sorted), min_size=1, max_size=8),
    form=st.sampled_from(FORMS),
    counts=st.sampled_from("BbHhIi"),
    index=st.sampled_from("BbHhIi"),
)
def test_convex_polygons_are_cut_into_fans(read, places, polygons, form, counts, index):
    x = np.sort(np.array(places, np.float32))
    vertices = np.stack([x, x * x, 2 * x], axis=1)  # of a parabola
    expected = fans(polygons)
    large = sum(len(polygon) > 3 for polygon in polygons)
    after = [("area", "d", [0.5] * len(polygons))]
    for name, data in (
        ("a.ply", ply(xyz(vertices), polygons, form, counts, index, after=after)),
        ("a.obj", obj(vertices, polygons)),
    ):
        mesh, report = read(name, data)
        assert mesh.faces.tobytes() == expected.tobytes()
        assert mesh.vertices.tobytes() == vertices.tobytes()
        assert report.triangulated == large
        assert any("cut into triangles (fans)" in note for note in report.notes) == bool(large)


def strips_of(rng, count):
    """(strips, separated by -1 or in lists of their own, the triangles that they mean)."""
    strips, expected = [], []
    for _ in range(count):
        strip = rng.integers(0, 12, rng.integers(0, 9)).tolist()
        strips.append(strip)
        for i in range(len(strip) - 2):
            a, b, c = strip[i : i + 3]
            if len({a, b, c}) == 3:
                expected.append((a, c, b) if i % 2 else (a, b, c))
    return strips, expected


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("seed", range(5))
def test_triangle_strips(read, form, seed):
    rng = np.random.default_rng(seed)
    strips, expected = strips_of(rng, 6)
    vertices = rng.normal(size=(12, 3)).astype(np.float32)
    joined = [number for strip in strips for number in strip + [-1]]
    for lists in (strips, [joined]):
        data = ply(xyz(vertices), lists, form).replace(b"element face", b"element tristrips")
        mesh, report = read("a.ply", data)
        assert mesh.faces.tolist() == [list(face) for face in expected]
        assert mesh.vertices.tobytes() == vertices.tobytes()
        assert report.notes == []


def test_the_garden_equals_what_meshio_reads(real_mesh):
    meshio = pytest.importorskip("meshio")
    path = real_mesh("botanical_garden_gazebo.ply")
    mesh, report = read_mesh(path)
    other = meshio.read(path)
    assert np.array_equal(mesh.vertices, other.points)
    assert np.array_equal(mesh.faces, other.cells_dict["triangle"])
    assert (len(mesh.vertices), len(mesh.faces), report.notes) == (25033, 37650, [])


def test_the_tray_equals_its_bytes(real_mesh):
    """Row by row; meshio cannot read a face with two lists."""
    path = real_mesh("tray.ply")
    mesh, report = read_mesh(path)
    data = path.read_bytes()
    at = data.index(b"end_header\n") + 11
    vertices = np.frombuffer(data, "<f4", 4 * 1257, at).reshape(-1, 4)
    at += 16 * 1257
    faces, qualities = [], []
    for _ in range(2416):
        assert data[at] == 3 and data[at + 13] == 6
        faces.append(struct.unpack_from("<3i", data, at + 1))
        assert struct.unpack_from("<6f", data, at + 14) == (0,) * 6
        qualities += struct.unpack_from("<f", data, at + 38)
        at += 1 + 12 + 1 + 24 + 4
    assert at == len(data)
    assert np.array_equal(mesh.vertices, vertices[:, :3]) and np.array_equal(mesh.faces, faces)
    assert np.array_equal(mesh.vertex_costs["quality"], vertices[:, 3])
    assert mesh.face_attributes["quality"].tolist() == qualities
    assert mesh.texture_coordinates is None and mesh.materials is None
    assert report.notes == ["texture coordinates left out: all of them are 0"]


def test_a_mesh_that_meshio_wrote(tmp_path):
    meshio = pytest.importorskip("meshio")
    world = zoo.outdoor_world(faces=3000, seed=1)
    for binary in (True, False):
        path = tmp_path / "a.ply"
        meshio.write_points_cells(
            path,
            world.vertices,
            [("triangle", world.faces.astype("i4"))],
            point_data={"slope": world.vertices[:, 2].astype("f8")},
            binary=binary,
        )
        mesh, _ = read_mesh(path)
        assert np.array_equal(mesh.vertices, world.vertices) and np.array_equal(
            mesh.faces, world.faces
        )
        assert np.array_equal(mesh.vertex_costs["slope"], world.vertices[:, 2])


@pytest.mark.parametrize("form", FORMS)
def test_ply_properties_become_attributes(read, form):
    columns = xyz(SQUARE) + [
        ("nx", "f", [0.0] * 4),
        ("ny", "f", [0.0] * 4),
        ("nz", "f", [1.0] * 4),
        ("red", "B", [0, 1, 254, 255]),
        ("green", "B", [7] * 4),
        ("blue", "B", [9] * 4),
        ("alpha", "B", [255] * 4),
        ("quality", "f", [0.0, 1.5, 2.5, 1e30]),
        ("scalar/slope", "d", [0.25, 0.5, 1.0, 2.0]),
        ("label", "i", [1, 2, 3, 4]),
        ("s", "f", [0.0, 0.5, 0.5, 1.0]),
    ]
    mesh, report = read("a.ply", ply(columns, TWO_FACES, form))
    assert mesh.vertex_normals.tolist() == [[0, 0, 1]] * 4
    assert mesh.vertex_colors.tolist() == [[0, 7, 9], [1, 7, 9], [254, 7, 9], [255, 7, 9]]
    assert sorted(mesh.vertex_costs) == ["label", "quality", "scalar_slope"]
    assert mesh.vertex_costs["label"].tolist() == [1, 2, 3, 4]
    assert mesh.vertex_costs["quality"].tolist() == np.float32([0, 1.5, 2.5, 1e30]).tolist()
    assert mesh.vertex_costs["scalar_slope"].tolist() == [0.25, 0.5, 1, 2]
    assert report.notes == [
        "left out: property s of the vertices (f4)",
        "--labels-from label makes labels of what label says",
    ]


def test_ply_colors_may_be_floats(read):
    colors = [(name, "f", [0.0, 0.5, 1.0, 0.999]) for name in ("red", "green", "blue")]
    mesh, report = read("a.ply", ply(xyz(SQUARE) + colors, TWO_FACES))
    assert mesh.vertex_colors.tolist() == [[0] * 3, [128] * 3, [255] * 3, [255] * 3]
    colors[1] = ("green", "f", [0.0, 0.5, 1.5, np.nan])
    mesh, report = read("a.ply", ply(xyz(SQUARE) + colors, TWO_FACES))
    assert mesh.vertex_colors is None and not mesh.vertex_costs
    assert "colors left out: 2 of them are not within 0..1, first at vertex 2" in report.notes


def test_ply_colors_may_have_an_alpha_which_is_left_out(read):
    columns = [(name, "B", [1, 2, 3, 4]) for name in ("red", "green", "blue", "alpha")]
    mesh, report = read("a.ply", ply(xyz(SQUARE) + columns, TWO_FACES))
    assert mesh.vertex_colors[3].tolist() == [4, 4, 4]
    assert report.notes == ["left out: property alpha of the vertices (u1)"]


def test_ply_normals_that_are_not_finite_are_left_out(read):
    normals = [("nx", "f", [0, 0, np.nan, np.inf]), ("ny", "f", [0] * 4), ("nz", "f", [1] * 4)]
    mesh, report = read("a.ply", ply(xyz(SQUARE) + normals, TWO_FACES))
    assert mesh.vertex_normals is None and not mesh.vertex_costs
    assert report.notes == ["normals left out: 2 of them are not finite, first at vertex 2"]


def test_ply_costs_keep_unknown_and_lethal(read):
    costs = np.float32([np.nan, np.inf, -1, 0])
    mesh, report = read("a.ply", ply(xyz(SQUARE) + [("cost", "f", costs)], TWO_FACES))
    assert mesh.vertex_costs["cost"].tobytes() == costs.tobytes()
    assert report.notes == [
        "layer cost has 1 negative values, first -1 at vertex 2; costs are >= 0",
        "layer cost has 1 unknown (NaN), 1 lethal (inf) values",
    ]


def test_ply_doubles_are_rounded_and_the_report_says_so(read):
    vertices = SQUARE.astype(float) + 1e6 + 0.01
    mesh, report = read("a.ply", ply(xyz(vertices, "d"), TWO_FACES))
    assert np.array_equal(mesh.vertices, vertices.astype("f4"))
    change = np.abs(mesh.vertices - vertices).max()
    assert report.notes == [
        "coordinates were rounded to float32, by at most %.3g m (far from the origin?); "
        "--origin auto keeps them" % change
    ]
    _, report = read("a.obj", obj(vertices, TWO_FACES))
    assert report.notes and report.notes[0].startswith("coordinates were rounded")
    _, report = read("a.obj", obj(SQUARE + np.float32(0.1), TWO_FACES))
    assert report.notes == []


@pytest.mark.parametrize("form", FORMS)
def test_ply_elements_in_any_order_and_windows_lines(read, form):
    data = ply(xyz(SQUARE), TWO_FACES, form)
    head, body = data.split(b"end_header\n")
    head = head.replace(b"element face", b"element edge 2\nproperty list int short a\nelement face")
    if form == "ascii":
        lines = body.splitlines()
        body = b"\r\n".join(lines[:4] + [b"2 7 8", b"0"] + lines[4:] + [b""])
    else:
        order = "<" if "little" in form else ">"
        edges = (
            np.int32([2]).astype(order + "i4").tobytes()
            + np.int16([7, 8]).astype(order + "i2").tobytes()
        )
        body = body[:48] + edges + bytes(4) + body[48:]
    mesh, report = read("a.ply", head.replace(b"\n", b"\r\n") + b"end_header\r\n" + body + b"1")
    assert np.array_equal(mesh.vertices, SQUARE) and np.array_equal(mesh.faces, TWO_FACES)
    assert report.notes == [
        "left out: element edge (2 rows)",
        "left out: 1 values after the last element",
    ]


def test_ply_headers_of_other_systems(read):
    data = ply(xyz(SQUARE), TWO_FACES, "ascii")
    for data in (
        data.replace(b"\n", b"\r"),
        data.replace(b"comment made", b"comment before the end_header line"),
        data.replace(b"end_header", b"obj_info num_cols 512\nend_header  "),
    ):
        mesh, report = read("a.ply", data)
        assert np.array_equal(mesh.vertices, SQUARE) and np.array_equal(mesh.faces, TWO_FACES)
        assert report.notes == []


def test_ply_normals_and_colors_that_are_not_complete_are_no_layers(read):
    names = ("nx", "ny", "red", "green", "alpha")
    columns = [(name, "f", [0.0, 0.5, 0.5, 1.0]) for name in names]
    mesh, report = read("a.ply", ply(xyz(SQUARE) + columns, TWO_FACES))
    assert mesh.vertex_normals is None and mesh.vertex_colors is None and not mesh.vertex_costs
    assert report.notes == ["left out: property %s of the vertices (f4)" % name for name in names]


def test_faces_of_two_corners_are_left_out(read):
    polygons = [[0, 1], [0, 1, 2], [2], [0, 2, 3]]
    for name, data in (("a.ply", ply(xyz(SQUARE), polygons)), ("a.obj", obj(SQUARE, polygons))):
        mesh, report = read(name, data)
        assert np.array_equal(mesh.faces, TWO_FACES)
        assert report.notes == ["2 faces of fewer than three corners were left out, first face 0"]


def test_obj_begins_with_a_byte_order_mark(read):
    mesh, report = read("a.obj", b"\xef\xbb\xbf" + obj(SQUARE, TWO_FACES))
    assert np.array_equal(mesh.vertices, SQUARE) and report.notes == []


OBJ = """# a comment
mtllib a.mtl
o square
v 0 0 0 1 0 0   # red
v\t1 0 0  0 1 0
vn 0 0 1
vt 0.25 0.75
v 1 2 0 0 0 1
 v 0 2 3 1 1 1
usemtl stone
s off
f -4//1 -3//1 \\
  -2//1
f 1/1/1 3/1/-1 -1/1/1
l 1 2
"""


def test_obj_with_everything_in_blocks_of_any_size(read, monkeypatch):
    for block, text in (
        (8 << 20, OBJ),
        (8 << 20, OBJ.replace("\\", "\\ ")),
        (8 << 20, OBJ.replace("\n", "\r\n")),
        (8 << 20, OBJ.replace("\n", "\r")),
        *((block, OBJ.replace("\n", "\r\n")) for block in range(1, 60)),
    ):
        monkeypatch.setattr(obj_lines, "_BLOCK_BYTES", block)
        mesh, report = read("a.obj", text)
        assert np.array_equal(mesh.vertices, SQUARE) and np.array_equal(mesh.faces, TWO_FACES)
        assert mesh.vertex_normals.tolist() == [[0, 0, 1]] * 4
        assert mesh.vertex_colors.tolist() == [[255, 0, 0], [0, 255, 0], [0, 0, 255], [255] * 3]
        uv = [0.25, 0.75]
        assert mesh.texture_coordinates.tolist() == [uv, [0, 0], uv, uv] and mesh.materials is None
        assert report.notes == [
            "3 face corners have no texture coordinates",
            "left out: materials of a.mtl, which is not there",
            "1 materials are in no file, and white: stone",
            "left out: lines (1 l lines)",
        ]


def test_obj_normals_that_are_not_one_per_vertex_are_left_out(read):
    text = obj(SQUARE, []).decode() + "vn 0 0 1\nvn 1 0 0\n"
    mesh, report = read("a.obj", text + "f 1//1 2//1 3//1\nf 1//2 3//1 4//1\n")
    assert mesh.vertex_normals is None and "different ones in different faces" in report.notes[0]
    mesh, report = read("a.obj", text + "f 1//1 2//1 3//1\nf 1 3 4\n")
    assert mesh.vertex_normals is None and report.notes == [
        "normals left out: 3 face corners have none"
    ]


def test_obj_colors_of_some_vertices_or_as_bytes(read):
    faces = "f 1 2 3\n"
    mesh, report = read("a.obj", "v 0 0 0\nv 1 0 0 1 1 1\nv 0 1 0\n" + faces)
    assert mesh.vertex_colors is None and report.notes == [
        "colors left out: only 1 vertices have one"
    ]
    mesh, report = read("a.obj", "v 0 0 0 255 0 7\nv 1 0 0 1 1 1\nv 0 1 0 2 3 4\n" + faces)
    assert mesh.vertex_colors.tolist() == [[255, 0, 7], [1, 1, 1], [2, 3, 4]]


@pytest.mark.parametrize(
    "up,turn",
    [
        ("Z_UP", [[1, 0, 0], [0, 1, 0], [0, 0, 1]]),
        ("Y_UP", [[1, 0, 0], [0, 0, -1], [0, 1, 0]]),
        # right is -y, towards the viewer is +z (COLLADA 1.4.1, element up_axis)
        ("X_UP", [[0, -1, 0], [0, 0, -1], [1, 0, 0]]),
    ],
)
def test_dae_unit_and_up_axis(read, up, turn):
    mesh, report = read("a.dae", dae(SQUARE, [[0, 1, 2, 3]], up, "0.25"))
    assert np.allclose(mesh.vertices, SQUARE @ np.transpose(turn) * 0.25, rtol=0, atol=1e-7)
    assert np.array_equal(mesh.faces, TWO_FACES)
    assert "COLLADA's unit and up axis were applied: meters, z up" in report.notes


def test_dae_instances_are_moved_and_mirrors_keep_the_outside(read):
    moved = "1 0 0 5 0 1 0 0 0 0 1 0 0 0 0 1"
    mirrored = "1 0 0 0 0 1 0 0 0 0 -1 -9 0 0 0 1"
    mesh, _ = read("a.dae", dae(SQUARE, [[0, 1, 2, 3]], matrices=(moved, mirrored)))
    assert len(mesh.vertices) == 8
    first, second = soup(mesh.vertices, mesh.faces[:2]), soup(mesh.vertices, mesh.faces[2:])
    assert np.array_equal(first, SQUARE[TWO_FACES] + np.float32([5, 0, 0]))
    reversed_faces = TWO_FACES[:, ::-1]
    assert np.array_equal(
        second, SQUARE[reversed_faces] * np.float32([1, 1, -1]) - np.float32([0, 0, 9])
    )


def test_stl_color_bytes_and_several_solids_are_reported(read):
    data = bytearray(stl(SQUARE, TWO_FACES))
    data[84 + 48] = 7
    _, report = read("a.stl", bytes(data) + b"xyz")
    assert report.notes[:2] == [
        "left out: the attribute (color) of 1 triangles",
        "left out: 3 bytes after the last triangle",
    ]
    mesh, report = read("a.stl", stl_text(SQUARE, TWO_FACES) * 2)
    assert len(mesh.faces) == 4 and len(mesh.vertices) == 4
    assert report.notes[0] == "2 solids became one mesh"


def test_which_stl_is_text_and_which_is_binary(read):
    binary, text = stl(SQUARE, TWO_FACES), stl_text(SQUARE, TWO_FACES)
    for data in (
        b"solid facet".ljust(80) + binary[80:],
        b"solid facet".ljust(80) + binary[80:] + b"\n",
        text.upper(),
        text.replace(b"made for a test", b"x" * 3000),
        b" \r\n" + text.replace(b"\n", b"\r\n"),
    ):
        mesh, _ = read("a.stl", data)
        assert np.array_equal(mesh.vertices, SQUARE) and np.array_equal(mesh.faces, TWO_FACES)


def test_negative_zero_is_the_same_place(read):
    vertices = np.float32([[0, 0, 0], [1, 0, 0], [0, 1, 0], [-0.0, -0.0, 0], [0, -1, 0]])
    mesh, _ = read("a.stl", stl(vertices, [[3, 4, 1], [0, 1, 2]]))
    assert len(mesh.vertices) == 4 and not np.signbit(mesh.vertices[mesh.vertices == 0]).any()


def test_the_content_decides_before_the_suffix(read):
    mesh, report = read("a.stl", ply(xyz(SQUARE), TWO_FACES))
    assert report.format == "PLY" and np.array_equal(mesh.faces, TWO_FACES)


def test_the_source_is_remembered(read):
    mesh, report = read("a.ply", ply(xyz(SQUARE), [[0, 1, 2, 3]]))
    source = dict(mesh.source)
    date = datetime.datetime.fromisoformat(source.pop("file_date"))
    data = ply(xyz(SQUARE), [[0, 1, 2, 3]])
    assert abs(date.timestamp() - time.time()) < 3600 and date.utcoffset() == datetime.timedelta(0)
    assert source == {
        "file": "a.ply",
        "format": "PLY",
        "bytes": len(data),
        "sha256": hashlib.sha256(data).hexdigest(),
        "tool": "mesh_msgs_hdf5 " + __version__,
        "notes": report.notes,
    }


def test_the_version_is_that_of_the_package():
    text = (Path(__file__).parents[2] / "package.xml").read_text()
    assert "<version>%s</version>" % __version__ in text
