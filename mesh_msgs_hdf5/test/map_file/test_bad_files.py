"""Files that are no good map: one MapFileError each, with its own code.

Nothing outside the file is read.
"""
import os
import stat

import h5py
import numpy as np
import pytest
from peak_memory import peak_memory

from mesh_msgs_hdf5.checks.exact import to_exact
from mesh_msgs_hdf5.formats.importer import read_mesh
from mesh_msgs_hdf5.map_file import MapFile
from mesh_msgs_hdf5.map_file.hdf5.hdf5_guard import default_budget
from mesh_msgs_hdf5.model.errors import MAX_SHOWN_PATH, MapFileError, shown_path


def refusal(path, **arguments):
    """The MapFileError of reading everything strictly; checks that it is one good line."""
    with pytest.raises(MapFileError) as refused:
        MapFile(path, strict=True, **arguments).read()
    text = str(refused.value)
    start = shown_path(os.fsdecode(path)) + ": "
    assert "\n" not in text and text.startswith(start) and len(text) > len(start) + 10
    return refused.value


def bad_path(kind, folder):
    path = folder / ("%s.h5" % kind)
    if kind == "missing":
        pass
    elif kind == "link":
        path.symlink_to("nowhere")
    elif kind == "loop":
        path.symlink_to(path)
    elif kind == "directory":
        path.mkdir()
    elif kind == "pipe":
        os.mkfifo(path)
    elif kind == "device":
        path = "/dev/zero"
    elif kind == "empty":
        path.write_bytes(b"")
    elif kind == "pointer":
        path.write_text("version https://git-lfs.github.com/spec/v1\noid sha256:00\nsize 1\n")
    elif kind == "text":
        path.write_text("I am no map\n" * 1000)
    elif kind == "mesh":
        path.write_bytes(b"ply\nformat ascii 1.0\nend_header\n")
    elif kind == "nul":
        path = str(path) + "\0"
    elif kind == "long":
        path = folder / ("x" * 4096)
    elif kind == "below a file":
        (folder / "file").write_text("x")
        path = folder / "file" / "a.h5"
    return path


CODES = {
    "missing": ("missing", "no such file"),
    "link": ("missing", "link to nowhere"),
    "loop": ("name", "circle"),
    "directory": ("directory", "folder"),
    "pipe": ("not_regular", "pipe"),
    "device": ("not_regular", "device"),
    "empty": ("empty", "0 bytes"),
    "pointer": ("lfs_pointer", "git lfs pull"),
    "text": ("format", "not an HDF5 file"),
    "mesh": ("format", "mesh_tool import"),
    "nul": ("name", "NUL"),
    "long": ("name", "too long"),
    "below a file": ("missing", "not a folder"),
}


@pytest.mark.parametrize("kind", CODES)
def test_what_is_no_file_of_ours_is_named(tmp_path, kind):
    path = bad_path(kind, tmp_path)
    error = refusal(path)
    code, words = CODES[kind]
    assert error.code == code and words in str(error)
    with pytest.raises(MapFileError) as refused:
        read_mesh(path)
    if kind not in ("text", "mesh"):
        assert (refused.value.code, refused.value.message) == (error.code, error.message)


@pytest.mark.skipif(os.geteuid() == 0, reason="root may read everything")
def test_a_file_without_permission(tmp_path):
    path = tmp_path / "a.h5"
    path.write_bytes(b"x")
    path.chmod(0)
    assert refusal(path).code == "permission"


def test_a_very_long_path_is_shortened_in_the_middle():
    path = "/begin" + "x" * 5000 + "/end.h5"
    text = str(MapFileError("missing", path, "there is no such file", "check the path"))
    assert len(text) < MAX_SHOWN_PATH + 60
    assert text.startswith("/begin") and "x/end.h5: there is no such file (check the path)" in text
    kept = shown_path(path)
    left, number, right = kept.replace("[... ", "|").replace(" characters ...]", "|").split("|")
    assert len(left) + int(number) + len(right) == len(path)
    assert shown_path("/a" * 200) == "/a" * 200


def test_every_message_is_another(tmp_path):
    texts = {kind: refusal(bad_path(kind, tmp_path)).message for kind in CODES}
    assert len(set(texts.values())) == len(CODES)


def test_a_name_that_is_not_utf8(tmp_path, full_mesh):
    path = os.fsencode(tmp_path) + b"/\xff.h5"
    error = refusal(path) if not os.path.exists(path) else None
    assert error.code == "missing" and str(error).encode("utf-8")
    assert MapFile.write(path, full_mesh).read().uuid == full_mesh.uuid


def test_a_file_cut_off_anywhere(tmp_path, full_mesh):
    MapFile.write(tmp_path / "whole.h5", full_mesh)
    data = (tmp_path / "whole.h5").read_bytes()
    path = tmp_path / "a.h5"
    for length in range(1, len(data), max(1, len(data) // 150)):
        path.write_bytes(data[:length])
        assert refusal(path).code in ("truncated", "format", "damaged"), length


def test_a_file_with_zeros_or_noise_somewhere(tmp_path, full_mesh):
    """Each either reads as something or is refused; never anything but a MapFileError."""
    MapFile.write(tmp_path / "whole.h5", full_mesh)
    data = (tmp_path / "whole.h5").read_bytes()
    path = tmp_path / "a.h5"
    refused = 0
    for start in range(0, len(data) - 256, len(data) // 40):
        path.write_bytes(data[:start] + b"\0" * 256 + data[start + 256 :])
        try:
            MapFile(path).read()
        except MapFileError:
            refused += 1
    assert refused > 10


def change(path, mesh, name, **arguments):
    """Write the mesh, then replace one channel; data=None removes it."""
    MapFile.write(path, mesh)
    with h5py.File(path, "r+") as file:
        del file["mesh"].attrs["uuid"]
        del file["mesh/channels"][name]
        if arguments:
            file["mesh/channels"].create_dataset(name, **arguments)
    return path


def with_row(array, row, value, kind):
    array = array.astype(kind)
    array[row] = value
    return array


@pytest.mark.parametrize(
    "name,kind,row,value,code,words",
    [
        ("vertices", "f4", 7, np.nan, "not_finite", "row 7 of /mesh/channels/vertices"),
        ("vertices", "f4", 7, -np.inf, "not_finite", "row 7 of"),
        ("vertices", "f8", 7, 1e60, "dtype", "row 7, column 0"),
        ("vertices", "f8", 7, 0.1, "dtype", "3 values do not fit float32"),
        ("vertex_normals", "f4", 5, np.nan, "not_finite", "row 5 of"),
        ("face_indices", "u4", 9, 40, "index", "face 9 refers to vertex 40, but the mesh has 40"),
        ("face_indices", "u4", 9, 0xFFFFFFFF, "index", "face 9 refers to vertex 4294967295"),
        ("face_indices", "i4", 9, -1, "index", "face 9 refers to vertex -1"),
        ("face_indices", "i8", 9, 2**40, "index", "face 9 refers to vertex"),
        ("face_indices", "f4", 9, 1, "dtype", "of type float32, not uint32"),
        ("vertex_colors", "i2", 3, 256, "dtype", "row 3, column 0"),
        ("vertex_colors", "f4", 3, 1, "dtype", "float32, not uint8"),
    ],
)
def test_wrong_values_are_named(tmp_path, full_mesh, name, kind, row, value, code, words):
    attribute = "faces" if name == "face_indices" else name
    array = with_row(getattr(full_mesh, attribute), row, value, kind)
    error = refusal(change(tmp_path / "a.h5", full_mesh, name, data=array))
    assert error.code == code and words in error.message


@pytest.mark.parametrize(
    "name,data,code",
    [
        ("vertices", np.zeros((3, 40), "f4"), "shape"),
        ("vertices", np.zeros((40, 4), "f4"), "shape"),
        ("vertices", np.zeros(41, "f4"), "shape"),
        ("vertices", np.zeros((4, 10, 3), "f4"), "shape"),
        ("vertices", np.float32(1), "shape"),
        ("vertices", np.zeros(40, [("x", "f4"), ("y", "f4"), ("z", "f4")]), "dtype"),
        ("vertices", np.array([b"1", b"2", b"3"]), "dtype"),
        ("vertices", h5py.Empty("f4"), "dtype"),
        ("face_indices", np.zeros((0, 3), "u4"), "no_faces"),
        ("face_indices", np.zeros((5, 4), "u4"), "shape"),
        ("vertex_normals", np.zeros((39, 3), "f4"), "shape"),
        ("vertex_colors", np.zeros((40, 4), "u1"), "value"),
        ("height_diff", np.full((40, 1), -np.inf, "f4"), "value"),
        ("height_diff", np.full((40, 1), 1e60, "f8"), "dtype"),
    ],
)
def test_wrong_shapes_and_types_are_refused(tmp_path, full_mesh, name, data, code):
    assert refusal(change(tmp_path / "a.h5", full_mesh, name, data=data)).code == code


@pytest.mark.parametrize("name", ["vertices", "face_indices"])
def test_a_missing_array_is_named(tmp_path, full_mesh, name):
    error = refusal(change(tmp_path / "a.h5", full_mesh, name))
    assert error.code == "no_mesh" and name in error.message


def test_links_are_not_followed(tmp_path, full_mesh):
    secret = tmp_path / "secret.h5"
    with h5py.File(secret, "w") as file:
        file["vertices"] = np.full((40, 3), 42, "f4")
    for name, link in (
        ("vertices", h5py.ExternalLink(str(secret), "/vertices")),
        ("vertices", h5py.SoftLink("/mesh/channels/vertex_normals")),
        ("vertex_normals", h5py.ExternalLink(str(secret), "/vertices")),
        ("vertex_colors", h5py.SoftLink("/mesh/channels/vertex_colors")),
    ):
        path = change(tmp_path / "a.h5", full_mesh, name)
        with h5py.File(path, "r+") as file:
            file["mesh/channels"][name] = link
        error = refusal(path)
        assert error.code == "link" and "/mesh/channels/" + name in error.message
    for where in ("mesh", "mesh/channels"):
        path = tmp_path / "b.h5"
        MapFile.write(path, full_mesh)
        with h5py.File(path, "r+") as file:
            del file[where]
            file[where] = h5py.ExternalLink(str(tmp_path / "a.h5"), where)
        assert refusal(path).code == "link"


def test_storage_in_other_files_is_not_read(tmp_path, full_mesh):
    secret = tmp_path / "secret.txt"
    secret.write_bytes(b"the password is 1234" * 100)
    path = change(
        tmp_path / "a.h5",
        full_mesh,
        "vertices",
        shape=(40, 3),
        dtype="f4",
        external=[(str(secret), 0, 480)],
    )
    assert refusal(path).code == "external"
    with h5py.File(tmp_path / "source.h5", "w") as file:
        file["v"] = np.zeros((40, 3), "f4")
    path = change(tmp_path / "b.h5", full_mesh, "vertices")
    with h5py.File(path, "r+") as file:
        layout = h5py.VirtualLayout((40, 3), "f4")
        layout[:] = h5py.VirtualSource(tmp_path / "source.h5", "v", shape=(40, 3))
        file["mesh/channels"].create_virtual_dataset("vertices", layout)
    assert refusal(path).code == "virtual"


@pytest.mark.parametrize("chunks", [None, (1 << 20, 3)])
def test_a_declared_size_is_not_believed(tmp_path, full_mesh, chunks):
    """12 TiB in a few kB, and a size that would fit: refused at once, without the memory."""
    for rows in (1 << 40, 1 << 22):
        path = change(
            tmp_path / "a.h5", full_mesh, "vertices", shape=(rows, 3), dtype="f4", chunks=chunks
        )
        assert path.stat().st_size < 200_000
        with peak_memory() as growth:
            assert refusal(path).code == "size"
            assert growth() < 40_000


def test_the_budget_of_memory_is_kept(tmp_path, full_mesh, monkeypatch):
    """Even for an array that is all there."""
    path = tmp_path / "a.h5"
    MapFile.write(path, full_mesh)
    monkeypatch.setattr("mesh_msgs_hdf5.map_file.hdf5.guarded_group.default_budget", lambda: 719)
    error = refusal(path)  # the faces take 720 bytes
    assert error.code == "size" and "face_indices declares 720 bytes, more than" in error.message
    assert 1 << 20 < default_budget() <= 8 << 30


@pytest.mark.parametrize("kind", ["i1", "i2", "i4", "i8", "f4", "u2"])
def test_conversion_to_unsigned_is_never_a_wrap(kind):
    for dtype in ("u1", "u4"):
        for value in (-1, 256, 2**40):
            array = np.zeros((3, 2), "i8")
            array[1, 1] = value
            array = array.astype(kind)
            fits = array.dtype.kind in "iu" and 0 <= array[1, 1] <= np.iinfo(dtype).max
            if fits:
                assert np.array_equal(to_exact(array, dtype, "a", "b"), array)
            else:
                with pytest.raises(MapFileError):
                    to_exact(array, dtype, "a", "b")


@pytest.mark.parametrize("kind", ["i1", "u1", "i2", "u2", "i4", "u4", "i8", "u8"])
@pytest.mark.parametrize("floats", ["f4", "f8"])
def test_integers_become_floats_only_where_they_stay_the_same(kind, floats):
    limits = np.iinfo(kind)
    values = {int(limits.min), int(limits.max), int(limits.max) - 1, int(limits.max) // 2 + 1, 0}
    values |= {2**e + d for e in range(limits.bits - 1) for d in (0, 1)}
    for value in values:
        array = np.array([value], kind)
        if int(np.dtype(floats).type(value)) == value:
            assert int(to_exact(array, floats, "a", "b")[0]) == value
        else:
            with pytest.raises(MapFileError, match="1 values do not fit"):
                to_exact(array, floats, "a", "b")


def test_a_half_written_array_is_not_read_as_zeros(tmp_path, full_mesh):
    path = change(
        tmp_path / "a.h5", full_mesh, "vertices", shape=(40, 3), dtype="f4", chunks=(10, 3)
    )
    with h5py.File(path, "r+") as file:
        file["mesh/channels/vertices"][:20] = full_mesh.vertices[:20]
    assert refusal(path).code == "size"


def test_unknown_filters_are_refused(tmp_path, full_mesh):
    path = change(tmp_path / "a.h5", full_mesh, "vertices", data=full_mesh.vertices, scaleoffset=3)
    error = refusal(path)
    assert error.code == "filter" and "filter 6" in error.message


@pytest.mark.parametrize(
    "name,value,code",
    [
        ("frame_id", "", "frame"),
        ("frame_id", "/map", "frame"),
        ("frame_id", "a b", "frame"),
        ("frame_id", 5, "value"),
        ("frame_id", np.bytes_(b"\xff\xfe"), "value"),
        ("frame_id", ["map", "odom"], "value"),
        ("source", "{", "value"),
        ("source", "[1]", "value"),
        ("schema_version", "new", "value"),
        ("schema_version", -1, "value"),
        ("uuid", np.zeros(300_000), "size"),
    ],
)
def test_wrong_attributes_are_refused(tmp_path, full_mesh, name, value, code):
    path = tmp_path / "a.h5"
    with h5py.File(path, "w", libver="latest") as file:  # old files have no attribute above 64 kB
        file["mesh/channels/vertices"] = full_mesh.vertices
        file["mesh/channels/face_indices"] = full_mesh.faces
        file["mesh"].attrs["schema_version"] = 1
        file["mesh"].attrs[name] = value
    assert refusal(path).code == code


@pytest.mark.parametrize("part", ["../mesh", "a//./b", "\n", "x" * 300])
def test_a_part_name_that_is_none(tmp_path, full_mesh, part):
    MapFile.write(tmp_path / "a.h5", full_mesh)
    assert refusal(tmp_path / "a.h5", part=part).code == "part"


@pytest.mark.parametrize(
    "name", ["", "a/b", ".", "..", "vertices", "x_idx", "a\nb", "a\0b", "\ud800", "x" * 256]
)
def test_a_layer_name_that_is_none(tmp_path, full_mesh, name):
    path = tmp_path / "a.h5"
    file = MapFile.write(path, full_mesh)
    old = path.read_bytes()
    with pytest.raises(MapFileError) as refused:
        file.write_layers({name: (np.zeros(40, "f4"), None)})
    assert refused.value.code == "layer" and path.read_bytes() == old
    assert os.listdir(tmp_path) == ["a.h5"]


@pytest.mark.parametrize(
    "costs,parameters,code",
    [
        (np.zeros(39, "f4"), None, "shape"),
        (np.full(40, 0.1), None, "dtype"),
        (np.full(40, -np.inf, "f4"), None, "value"),
        (np.zeros(40, "f4"), {"x": object()}, "value"),
    ],
)
def test_a_layer_that_cannot_be_saved_changes_nothing(tmp_path, full_mesh, costs, parameters, code):
    path = tmp_path / "a.h5"
    file = MapFile.write(path, full_mesh)
    old = path.read_bytes()
    with pytest.raises(MapFileError) as refused:
        file.write_layers({"new": (costs, parameters)})
    assert refused.value.code == code and path.read_bytes() == old
    assert os.listdir(tmp_path) == ["a.h5"]


def test_reading_changes_nothing(tmp_path, full_mesh):
    path = tmp_path / "a.h5"
    MapFile.write(path, full_mesh)
    path.chmod(stat.S_IRUSR)
    before = (path.read_bytes(), path.stat().st_mtime_ns)
    MapFile(path).read()
    assert (path.read_bytes(), path.stat().st_mtime_ns) == before
    assert os.listdir(tmp_path) == ["a.h5"]


def test_no_file_stays_open(tmp_path, full_mesh):
    path = tmp_path / "a.h5"
    MapFile.write(path, full_mesh).read()
    change(tmp_path / "b.h5", full_mesh, "vertices", data=np.full((40, 3), np.nan, "f4"))
    refusal(tmp_path / "b.h5")
    places = ["/proc/self/fd/%s" % number for number in os.listdir("/proc/self/fd")]
    names = [os.readlink(place) for place in places if os.path.lexists(place)]
    assert names and not [name for name in names if str(tmp_path) in name]
