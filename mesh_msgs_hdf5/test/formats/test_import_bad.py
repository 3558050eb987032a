"""Meshes that are refused: one line with the first index and the count, and nothing is written."""
import json
import os
import struct
import warnings

import numpy as np
import pytest
from mesh_writers import SQUARE, TWO_FACES, dae, obj, ply, stl, stl_text, xyz

from mesh_msgs_hdf5.commands.mesh_tool import main
from mesh_msgs_hdf5.formats.base.numbers_text import numbers
from mesh_msgs_hdf5.formats.exporter import write_mesh
from mesh_msgs_hdf5.formats.importer import read_mesh
from mesh_msgs_hdf5.isolation import FUNCTIONS
from mesh_msgs_hdf5.model.errors import MapFileError

FORMS = ("ascii", "binary_little_endian", "binary_big_endian")


def refusal(folder, name, data):
    path = folder / name
    path.write_bytes(data if isinstance(data, bytes) else data.encode())
    with pytest.raises(MapFileError) as refused:
        read_mesh(path)
    assert "\n" not in str(refused.value) and str(path) in str(refused.value)
    return refused.value


def writers(vertices, faces, letter="f"):
    for form in FORMS:
        yield "a.ply", ply(xyz(vertices, letter), faces, form)
    yield "a.obj", obj(vertices, faces)
    yield "a.stl", stl_text(vertices, faces)
    yield "a.dae", dae(vertices, faces)


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf, 1e60])
def test_coordinates_that_are_not_finite(tmp_path, value):
    vertices = SQUARE.astype(float)
    vertices[2, 1] = value
    for name, data in writers(vertices, TWO_FACES, "d"):
        error = refusal(tmp_path, name, data)
        assert error.code == "not_finite", name
        if name in ("a.ply", "a.obj"):
            assert error.message.startswith("vertex 2 is not finite in float32")
            assert error.message.endswith("1 in all")
        else:  # a soup: it is the third corner of the first face, and the second of the second
            assert error.message.startswith("corner 2 is not") and error.message.endswith(
                "2 in all"
            )
    if not abs(value) < np.inf:
        floats = SQUARE.copy()
        floats[2, 1] = value
        error = refusal(tmp_path, "b.stl", stl(floats, TWO_FACES))
        assert error.message.startswith("corner 2 is not finite")


@pytest.mark.parametrize("index", [4, 2**31 - 1, -1])
def test_faces_that_refer_to_no_vertex(tmp_path, index):
    faces = [[0, 1, 2], [0, 1, 2, 3], [0, 2, index], [index, 1, 2], [1, 2, 3]]
    for form in FORMS:
        error = refusal(tmp_path, "a.ply", ply(xyz(SQUARE), faces, form))
        assert error.code == "index" and error.message == (
            "face 2 refers to vertex %d, but the file has 4 vertices; 2 faces do so" % index
        )
    error = refusal(tmp_path, "a.obj", obj(SQUARE, faces))
    assert error.code == "index" and error.message == (
        "face 2 refers to vertex %d, but the file has 4 vertices; 2 faces do so" % (index + 1)
    )


def test_the_largest_index(tmp_path):
    error = refusal(tmp_path, "a.ply", ply(xyz(SQUARE), [[0, 1, 0xFFFFFFFF]], index="I"))
    assert "face 0 refers to vertex 4294967295" in error.message


def test_obj_numbers_from_the_end_stay_in_range(tmp_path):
    text = obj(SQUARE, []).decode()
    assert refusal(tmp_path, "a.obj", text + "f 1 2 -5\n").code == "index"
    assert refusal(tmp_path, "a.obj", text + "f 1 2 0\n").code == "index"
    assert refusal(tmp_path, "a.obj", text + "vn 0 0 1\nf 1//1 2//1 3//2\n").code == "index"


def test_no_faces(tmp_path):
    assert refusal(tmp_path, "a.ply", ply(xyz(SQUARE), [])).code == "no_faces"
    assert refusal(tmp_path, "a.ply", ply(xyz(SQUARE), [[0, 1]])).code == "no_faces"
    points = "ply\nformat ascii 1.0\nelement vertex 1\n"
    points += "".join("property float %s\n" % axis for axis in "xyz") + "end_header\n1 2 3\n"
    assert refusal(tmp_path, "a.ply", points).code == "no_faces"
    assert refusal(tmp_path, "a.obj", obj(SQUARE, [])).code == "no_faces"
    assert refusal(tmp_path, "a.stl", stl(SQUARE, [])).code == "no_faces"
    assert refusal(tmp_path, "a.stl", b"solid facet\nendsolid\n").code == "no_faces"
    empty = dae(SQUARE, [])
    assert refusal(tmp_path, "a.dae", empty).code == "no_faces"


@pytest.mark.parametrize("form", FORMS)
def test_a_ply_cut_off_anywhere(tmp_path, form):
    data = ply(xyz(SQUARE), [[0, 1, 2], [0, 1, 2, 3]], form, after=[("q", "d", [1.5, 2.5])])
    for length in range(4, len(data) - (4 if form == "ascii" else 0)):
        error = refusal(tmp_path, "a.ply", data[:length])
        assert error.code in ("truncated", "format", "no_faces"), (length, str(error))
        if length > data.index(b"end_header") + 11:
            assert error.code == "truncated", (length, str(error))


def test_other_formats_cut_off(tmp_path):
    data = stl(SQUARE, TWO_FACES)
    for length in (10, 83, 84, 100, len(data) - 1):
        assert refusal(tmp_path, "a.stl", data[:length]).code in ("truncated", "format")
    text = stl_text(SQUARE, TWO_FACES)
    for length in (60, 100, len(text) - 30):
        assert refusal(tmp_path, "a.stl", text[:length]).code in ("truncated", "format")
    text = dae(SQUARE, TWO_FACES).encode()
    for length in range(200, len(text) - 20, 300):
        assert refusal(tmp_path, "a.dae", text[:length]).code in ("format", "no_faces")


def head(vertices=4, faces=1, kind="list uchar int vertex_indices"):
    return (
        "ply\nformat binary_little_endian 1.0\nelement vertex %d\nproperty float x\n"
        "property float y\nproperty float z\nelement face %d\nproperty %s\nend_header\n"
        % (vertices, faces, kind)
    ).encode()


def test_ply_names_that_stand_twice(tmp_path):
    columns = xyz(SQUARE) + [("cost", "f", [1.0] * 4), ("cost", "f", [2.0] * 4)]
    error = refusal(tmp_path, "a.ply", ply(columns, TWO_FACES))
    assert "two properties of element vertex named cost" in error.message
    data = ply(xyz(SQUARE), TWO_FACES).replace(b"element face", b"element vertex 0\nelement face")
    assert "two elements named vertex" in refusal(tmp_path, "a.ply", data).message


def test_ply_triangle_strips(tmp_path):
    for strip in ([0, 1, 7], [0, 1, 2, -2, 3]):
        data = ply(xyz(SQUARE), [strip]).replace(b"element face", b"element tristrips")
        assert refusal(tmp_path, "a.ply", data).code == "index"
    data = ply(xyz(SQUARE), [[0, 1, -1, 2, 3]]).replace(b"element face", b"element tristrips")
    assert refusal(tmp_path, "a.ply", data).code == "no_faces"
    data = ply(xyz(SQUARE), [[0, 1.5, 2]], "ascii").replace(b"element face", b"element tristrips")
    assert "no whole number" in refusal(tmp_path, "a.ply", data).message


@pytest.mark.parametrize(
    "victim,words",
    [
        ("abort", "assimp ended with SIGABRT while reading it"),
        ("fail", "reading it failed: KeyError"),
    ],
)
def test_a_crash_of_assimp_is_an_error(tmp_path, monkeypatch, victim, words):
    monkeypatch.setitem(FUNCTIONS, "collada", ("victims", victim))
    error = refusal(tmp_path, "a.dae", dae(SQUARE, TWO_FACES))
    assert error.code == "damaged" and words in error.message and "convert" in error.hint


def test_assimp_is_not_led_astray_by_the_current_folder(tmp_path, monkeypatch):
    (tmp_path / "numpy.py").write_text("raise SystemExit('the wrong one')")
    monkeypatch.chdir(tmp_path)
    (tmp_path / "a.dae").write_text(dae(SQUARE, TWO_FACES))
    assert np.array_equal(read_mesh("a.dae")[0].vertices, SQUARE)


def test_announced_sizes_are_not_believed(tmp_path):
    """Rows and list lengths of 10^12 in a small file: refused at once."""
    body = SQUARE.tobytes()
    assert refusal(tmp_path, "a.ply", head(10**12) + body).code == "truncated"
    assert refusal(tmp_path, "a.ply", head(faces=10**12) + body).code == "truncated"
    long_list = head(kind="list uint int vertex_indices") + body + b"\xff" * 4 + bytes(12)
    assert refusal(tmp_path, "a.ply", long_list).code == "truncated"
    negative = head(kind="list char int vertex_indices") + body + b"\xff" + bytes(12)
    assert "list of length -1" in refusal(tmp_path, "a.ply", negative).message
    assert (
        refusal(tmp_path, "a.stl", bytes(80) + struct.pack("<I", 2**32 - 1) + bytes(50)).code
        == "truncated"
    )


@pytest.mark.parametrize(
    "change",
    [
        ("format ascii 1.0", "format ebcdic 1.0"),
        ("format ascii 1.0\n", ""),
        ("element vertex 4", "element vertex four"),
        ("element vertex 4", "element vertex -4"),
        ("element vertex 4\n", ""),
        ("property float x", "property quaternion x"),
        ("property float x", "property float u"),
        ("property float x", "what is this"),
        ("int vertex_indices", "float vertex_indices\nproperty int"),
    ],
)
def test_a_ply_header_that_says_nothing(tmp_path, change):
    data = ply(xyz(SQUARE), TWO_FACES, "ascii").decode()
    assert change[0] in data
    assert refusal(tmp_path, "a.ply", data.replace(*change)).code == "format"


@pytest.mark.parametrize("name", ["a.ply", "a.obj", "a.stl"])
def test_words_instead_of_numbers(tmp_path, name):
    written = dict(writers(SQUARE, TWO_FACES))
    data = ply(xyz(SQUARE), TWO_FACES, "ascii") if name == "a.ply" else written[name]
    error = refusal(tmp_path, name, data.replace(b"2.0", b"2,0"))  # a decimal comma
    assert error.code == "format" and "2,0" in error.message


def test_the_warnings_of_other_threads_are_no_errors(monkeypatch):
    def fromstring(text, **_more):
        warnings.warn("of somebody else", DeprecationWarning)
        return np.array(text.split(), float)

    monkeypatch.setattr(np, "fromstring", fromstring)
    assert numbers("a", b"1 2", "data").tolist() == [1, 2]


def test_obj_lines_of_a_wrong_length(tmp_path):
    error = refusal(tmp_path, "a.obj", b"v 0 0 0\nv 1 1\nv 0 1 1\nf 1 2 3\n")
    assert error.message.startswith("vertex 1 has 2 values")
    error = refusal(tmp_path, "a.obj", b"v 0 0 0\nv 1 1 1\nv 0 1 1\nf /1 2 3\n")
    assert error.code == "format"


def test_a_property_too_large_for_float32(tmp_path):
    data = ply(xyz(SQUARE) + [("cost", "d", [0, 1, 1e60, 1e61])], TWO_FACES)
    error = refusal(tmp_path, "a.ply", data)
    assert "property cost of vertex 2" in error.message and "2 in all" in error.message


def test_what_is_no_mesh(tmp_path):
    for name, data in (
        ("a.txt", b"hello"),
        ("a.ply", b"hello"),
        ("a.obj", b"hello world\n"),
        ("a.obj", os.urandom(5000)),
        ("a.stl", b"hello"),
        ("a.stl", b"x" * 300),
        ("a.dae", b"hello"),
        ("a.h5", b"hello"),
        ("a", b"\x89HDF\r\n\x1a\n" + bytes(100)),
    ):
        assert refusal(tmp_path, name, data).code in ("format", "truncated", "damaged"), (
            name,
            data,
        )


BAD = {
    "missing.ply": None,
    "empty.ply": b"",
    "pointer.ply": b"version https://git-lfs.github.com/spec/v1\noid sha256:0\nsize 1\n",
    "index.ply": ply(xyz(SQUARE), [[0, 1, 4]]),
    "nan.ply": ply(xyz(SQUARE * np.float32(np.nan)), TWO_FACES),
    "large.obj": obj(SQUARE.astype(float) * 1e60, TWO_FACES),
    "faceless.ply": ply(xyz(SQUARE), []),
    "short.stl": stl(SQUARE, TWO_FACES)[:-7],
    "text.dae": b"no scene",
}


@pytest.mark.parametrize("name", BAD)
def test_the_command_says_one_line_and_writes_nothing(tmp_path, capsys, name):
    if BAD[name] is not None:
        (tmp_path / name).write_bytes(BAD[name])
    before = sorted(os.listdir(tmp_path))
    assert main(["import", str(tmp_path / name), str(tmp_path / "out.h5")]) == 1
    output = capsys.readouterr()
    assert output.out == "" and output.err.count("\n") == 1
    assert output.err.startswith("mesh_tool: error: %s: " % (tmp_path / name))
    assert sorted(os.listdir(tmp_path)) == before


@pytest.mark.parametrize("suffix", [".ply", ".obj"])
def test_changed_bytes_of_our_own_exports(tmp_path, rich_mesh, suffix):
    """Remarks among them: whatever is changed, a good mesh or one MapFileError."""
    path = tmp_path / ("a" + suffix)
    write_mesh(path, rich_mesh)
    data = path.read_bytes()
    head = data.index(b"end_header") if suffix == ".ply" else data.index(b"\nv ")
    rng = np.random.default_rng(13)
    ends = {"mesh": 0, "error": 0}
    for i in range(300):
        changed = bytearray(data)
        for at in rng.integers(0, head if i % 3 else len(data), rng.integers(1, 4)):
            changed[at] = rng.integers(32, 127)
        path.write_bytes(changed)
        try:
            mesh, _ = read_mesh(path)
            assert len(mesh.faces) and (mesh.faces < len(mesh.vertices)).all()
            ends["mesh"] += 1
        except MapFileError as error:
            assert "\n" not in str(error)
            ends["error"] += 1
    assert min(ends.values()) > 10


REMARKS = [
    {"layer": "a", "property": ["x"]},
    {"layer": "x/y", "property": "cost", "parameters": 7},
    {"layer": "", "property": "cost"},
    {"label": "a/b", "property": "area", "value": 1},
    {"label": "a_1", "property": "area", "value": 10**400},
    {"label": "a_1", "property": {"area": 1}, "value": 1, "color": [1, 2]},
    {"label": "a_1", "property": "area", "value": 1, "color": [1, 2, 256]},
    {"label": "a_1", "property": "area", "value": True, "color": "red"},
    {"label": ["a_1"], "property": "area", "value": 1},
    {"face_attribute": "a", "properties": ["area", "area"], "type": "f8", "rank": 2},
    {"face_attribute": "a", "properties": ["area"], "type": "i8", "rank": 1},
    {"face_attribute": "a", "properties": ["area"], "type": ["f8"], "rank": "1"},
    {"face_attribute": "a", "properties": [["area"]], "type": "f8"},
    {"face_attribute": "a", "properties": [], "type": "f8"},
    {"face_attribute": "..", "properties": ["area"], "type": "f4", "rank": 1},
    {"material": 0, "color": [1, 2, 3]},
    {"material": 5, "color": [1, 2, 3], "texture": 10**400},
    {"material": -1, "color": None, "texture": "x"},
    {"texture": 10**400, "file": "a.png"},
    {"texture": -1, "file": "a.png"},
    {"texture": 0, "file": ["a.png"]},
    {"mesh": {"origin": [1, 2]}},
    {"mesh": {"origin": [1e400, 2, 3], "frame_id": "a b", "crs": 5, "source": []}},
    {"mesh": {"frame_id": ["map"], "crs": "x" * 5000}},
    {"mesh": 5},
    {},
]


@pytest.mark.parametrize("remark", REMARKS, ids=range(len(REMARKS)))
def test_remarks_that_are_none(tmp_path, remark):
    """The mesh is read; what a wrong remark speaks of is a number of the file or left out."""
    columns = xyz(SQUARE) + [("cost", "f", [0.0, 1, 2, 3])]
    data = ply(columns, TWO_FACES, after=[("area", "d", [0.5, 1.5])])
    line = b"comment mesh_tools " + json.dumps(remark).encode() + b"\ncomment made"
    (tmp_path / "a.ply").write_bytes(data.replace(b"comment made", line))
    mesh, report = read_mesh(tmp_path / "a.ply")
    assert np.array_equal(mesh.vertices, SQUARE) and np.array_equal(mesh.faces, TWO_FACES)
    assert mesh.frame_id == "map" and mesh.origin == (0, 0, 0) and mesh.materials is None
    for label in mesh.labels.values():
        assert label.color is None


def test_a_header_of_many_properties(tmp_path):
    """Names are compared in one go: this is quick."""
    columns = xyz(SQUARE) + [("p%d" % i, "f", [0.0] * 4) for i in range(20_000)]
    (tmp_path / "a.ply").write_bytes(ply(columns, TWO_FACES))
    assert len(read_mesh(tmp_path / "a.ply")[0].vertex_costs) == 20_000


@pytest.mark.parametrize("row", [0, 2])
def test_a_row_of_a_ply_that_is_longer_than_declared_is_named(tmp_path, row):
    """All behind it is read as something else: no faces, a wrong list, a file that is cut off."""
    start, body = ply(xyz(SQUARE), TWO_FACES, "ascii").split(b"end_header\n")
    lines = body.splitlines()
    lines[row] += b" 7"
    error = refusal(tmp_path, "a.ply", start + b"end_header\n" + b"\n".join(lines) + b"\n")
    assert error.code == "format"
    words = "row %d of element vertex has 4 values, but the header declares 3" % row
    assert words in error.message
    lines = [line + b" 7" for line in body.splitlines()[:4]] + body.splitlines()[4:]
    error = refusal(tmp_path, "a.ply", start + b"end_header\n" + b"\n".join(lines) + b"\n")
    assert "row 0 of element vertex has 4 values" in error.message
    # where lines are no rows, nothing is known of that
    (tmp_path / "a.ply").write_bytes(start + b"end_header\n" + b" ".join(body.split()))
    assert len(read_mesh(tmp_path / "a.ply")[0].faces) == 2
