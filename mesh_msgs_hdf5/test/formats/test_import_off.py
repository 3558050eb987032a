"""OFF files: every number of them, and every way in which they may be broken."""
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from mesh_msgs import zoo
from mesh_writers import SQUARE, TWO_FACES

from mesh_msgs_hdf5.formats.importer import read_mesh
from mesh_msgs_hdf5.model.errors import MapFileError

ANIMALS = [mesh for mesh in zoo.all_meshes() if len(mesh.faces)]
U = [(0, 0, 0), (3, 0, 0), (3, 3, 0), (2, 3, 0), (2, 1, 0), (1, 1, 0), (1, 3, 0), (0, 3, 0)]


def off(vertices, polygons, prefix="", columns=(), behind=None):
    """columns: what stands behind the positions, rows of numbers; behind: ... the corners."""
    lines = [prefix + "OFF", "%d %d 0" % (len(vertices), len(polygons))]
    for i, vertex in enumerate(vertices):
        row = list(map(float, vertex)) + [value for column in columns for value in column[i]]
        lines.append(" ".join(map(repr, row)))
    for i, polygon in enumerate(polygons):
        row = [len(polygon), *map(int, polygon)] + (list(behind[i]) if behind else [])
        lines.append(" ".join(map(str, row)))
    return "\n".join(lines) + "\n"


@pytest.fixture
def read(tmp_path):
    """Read a text as an OFF file: (mesh, report)."""

    def read(text, name="a.off"):
        (tmp_path / name).write_bytes(text if isinstance(text, bytes) else text.encode())
        return read_mesh(tmp_path / name)

    return read


@pytest.mark.parametrize("animal", ANIMALS, ids=lambda mesh: mesh.name)
def test_vertices_and_faces_are_kept(read, animal):
    mesh, report = read(off(animal.vertices, animal.faces))
    assert mesh.vertices.tobytes() == animal.vertices.tobytes()
    assert mesh.faces.tobytes() == animal.faces.tobytes()
    assert report.notes == [] and report.format == "OFF"
    assert mesh.vertex_colors is None and mesh.vertex_normals is None


def test_comments_blanks_and_counts_behind_the_name(read):
    text = off(SQUARE, TWO_FACES)
    lines = text.splitlines()
    for changed in (
        "# of a test\n\n" + text.replace("\n", "  # more\n\n"),
        text.replace("\n", "\r\n"),
        text.replace("\n", "\r"),
        "\n".join([lines[0] + " " + lines[1]] + lines[2:]),
        "\n".join([lines[0] + lines[1]] + lines[2:]),  # as ModelNet has it
        text.replace(" ", "\t ").rstrip(),
    ):
        mesh, report = read(changed)
        assert np.array_equal(mesh.vertices, SQUARE) and np.array_equal(mesh.faces, TWO_FACES)
        assert report.notes == []


def test_the_values_of_vertices(read):
    rng = np.random.default_rng(2)
    normals = rng.normal(size=(4, 3)).astype(np.float32)
    uv = rng.random((4, 2)).astype(np.float32)
    colors = rng.integers(0, 256, (4, 3))
    opaque = np.column_stack([colors, [255] * 4])
    light = opaque / 255.0
    for normal in (0, 1):
        for written in (None, colors, opaque, light):
            for texture in (0, 1):
                columns = [normals.tolist()] * normal
                columns += [] if written is None else [written.tolist()]
                columns += [uv.tolist()] * texture
                prefix = "ST" * texture + ("" if written is None else "C") + "N" * normal
                mesh, report = read(off(SQUARE, TWO_FACES, prefix, columns))
                assert report.notes == []
                assert np.array_equal(mesh.vertices, SQUARE)
                if normal:
                    assert mesh.vertex_normals.tobytes() == normals.tobytes()
                if written is not None:
                    assert np.array_equal(mesh.vertex_colors, colors)
                if texture:
                    assert mesh.texture_coordinates.tobytes() == uv.tobytes()
                found = (mesh.vertex_normals, mesh.vertex_colors, mesh.texture_coordinates)
                wanted = (normal, written is not None, texture)
                assert [value is not None for value in found] == [bool(w) for w in wanted]
    _, report = read(off(SQUARE, TWO_FACES, "C", [(opaque // 2).tolist()]))
    assert report.notes == ["left out: the alpha of the vertex colors"]


def test_polygons_and_their_colors(read):
    vertices = U + [(0, 0, 5), (1, 0, 5), (0, 1, 5)]
    polygons = [range(8), (8, 9, 10)]
    for behind in ([(255, 0, 9), (0, 128, 0)], [(255, 0, 9, 255), (0, 128, 0, 255)]):
        mesh, report = read(off(vertices, polygons, behind=behind))
        assert mesh.face_attributes["face_colors"].tolist() == [[255, 0, 9]] * 6 + [[0, 128, 0]]
        assert len(report.notes) == 1 and "1 concave" in report.notes[0]
    mesh, _ = read(off(vertices, polygons, behind=[(1.0, 0.0, 0.5), (0.0, 0.2, 0.0)]))
    assert mesh.face_attributes["face_colors"].tolist() == [[255, 0, 128]] * 6 + [[0, 51, 0]]
    for behind in ([(255, 0, 9), ()], [(1,), (2,)]):
        mesh, report = read(off(vertices, polygons, behind=behind))
        assert not mesh.face_attributes and "left out: what stands behind" in report.notes[1]


@pytest.mark.parametrize(
    "text, code, words",
    [
        ("OFF\n", "format", "numbers of vertices and faces"),
        ("OFF\n-1 2 0\n", "format", "numbers of vertices and faces"),
        ("4 2 0\n0 0 0\n", "format", "does not begin with OFF"),
        ("OFFER\n", "format", "does not begin with OFF"),
        ("OFF BINARY\n4 2 0\n", "format", "binary OFF"),
        (b"OFF BINARY\n\0\0\0\4", "format", "binary OFF"),
        (off(SQUARE, TWO_FACES, "4"), "format", "three dimensions"),
        (off(SQUARE, TWO_FACES, "n"), "format", "three dimensions"),
        (off(SQUARE, []), "no_faces", "no faces"),
        (off(SQUARE, [(0, 1, 4)]), "index", "face 0 refers to vertex 4"),
        (off(SQUARE, [(0, 1, -1)]), "index", "face 0 refers to vertex -1"),
        (off(SQUARE, TWO_FACES, "C"), "format", "vertex 0 of the OFF file has 3 values"),
        (off(SQUARE, TWO_FACES, "", [[(1,)] * 4]), "format", "has 4 values, not 3"),
        (off(SQUARE, TWO_FACES).replace("3 0 1 2", "4 0 1 2"), "format", "has 4 corners, but 3"),
        (off(SQUARE, TWO_FACES).replace("3 0 1 2", "-3 0 1 2"), "format", "has -3 corners"),
        (off(SQUARE, TWO_FACES).replace("3 0 1 2", "3 0 1.5 2"), "index", "no whole number"),
        (off(SQUARE, TWO_FACES).replace("3 0 1 2", "3 0 one 2"), "format", "no number"),
        (off(SQUARE, TWO_FACES).replace("1.0", "1.5.2"), "format", "no number"),
        (off(SQUARE, TWO_FACES).replace("1.0", "nan"), "not_finite", "vertex 1"),
        ("OFF\n9999999999 99999999999 0\n0 0 0\n", "truncated", "cut off"),
    ],
)
def test_what_is_refused(read, text, code, words):
    with pytest.raises(MapFileError) as refused:
        read(text)
    assert refused.value.code == code and words in str(refused.value)
    assert "\n" not in str(refused.value)


@settings(max_examples=200)
@given(st.data())
def test_any_damage_is_one_error_or_a_mesh(read, data):
    text = bytearray(off(SQUARE, TWO_FACES, "CN", [SQUARE.tolist(), [(1, 2, 3)] * 4]).encode())
    for _ in range(data.draw(st.integers(0, 4))):
        at = data.draw(st.integers(0, len(text) - 1))
        text[at] = data.draw(st.sampled_from(b" \n0719.-e#\xff\x00xN"))
    del text[data.draw(st.integers(1, len(text))) :]
    try:
        mesh, _ = read(bytes(text))
    except MapFileError as error:
        assert "\n" not in str(error)
    else:
        assert mesh.faces.max() < len(mesh.vertices)


def test_a_file_cut_off_anywhere(read):
    lines = off(SQUARE, TWO_FACES).splitlines(keepends=True)
    for count in range(1, len(lines)):
        with pytest.raises(MapFileError) as refused:
            read("".join(lines[:count]))
        assert refused.value.code in ("truncated", "format")
    _, report = read("".join(lines + ["1 2 3\n"]))
    assert report.notes == ["left out: 1 lines after the last face"]
