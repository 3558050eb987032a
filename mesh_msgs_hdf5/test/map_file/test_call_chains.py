"""What a call of a MapFile costs, counted in causes: calls of functions, openings of the file."""
import ctypes
import os
import struct
import sys

import numpy as np
import pytest

import mesh_msgs_hdf5
from mesh_msgs_hdf5.isolation import IsolatedMapFile
from mesh_msgs_hdf5.map_file import MapFile
from mesh_msgs_hdf5.model.edit import Edit
from mesh_msgs_hdf5.model.mesh import Mesh
from mesh_msgs_hdf5.processes.zygote import ZYGOTE

SIDE = 317  # 100,000 vertices
_IN_OPEN, _EVENT = 0x20, struct.Struct("iIII")
_OWN = tuple(folder + os.sep for folder in mesh_msgs_hdf5.__path__)


@pytest.fixture(scope="module")
def large(tmp_path_factory):
    """A map of 100,000 vertices, whose arrays have several chunks."""
    x, y = np.meshgrid(np.arange(SIDE, dtype=np.float32), np.arange(SIDE, dtype=np.float32))
    vertices = np.column_stack((x.ravel(), y.ravel(), np.zeros(SIDE**2, np.float32)))
    first = (np.arange(SIDE - 1)[:, np.newaxis] * SIDE + np.arange(SIDE - 1)).reshape(-1, 1)
    faces = np.concatenate((first + [0, 1, SIDE], first + [1, SIDE + 1, SIDE]))
    path = tmp_path_factory.mktemp("large") / "a.h5"
    costs = {"slope": np.ones(SIDE**2, np.float32)}
    return MapFile.write(path, Mesh(vertices, faces.astype(np.uint32), vertex_costs=costs))


def own_calls(action):
    """The names of the functions of this package that are called."""
    calls = []

    def note(frame, event, _argument):
        file = frame.f_code.co_filename
        if event == "call" and file.startswith(_OWN) and file != __file__:
            calls.append("%s:%s" % (file, frame.f_code.co_name))

    before = sys.getprofile()
    sys.setprofile(note)
    try:
        action()
    finally:
        sys.setprofile(before)
    return calls


def opens_of(path, action):
    """How often a file is opened, by whatever code; what takes its place is the same file here."""
    libc = ctypes.CDLL(None, use_errno=True)
    watching = libc.inotify_init1(os.O_NONBLOCK | os.O_CLOEXEC)
    try:
        assert libc.inotify_add_watch(watching, os.fsencode(os.path.dirname(path)), _IN_OPEN) > 0
        action()
        data, names = os.read(watching, 1 << 16), []
    finally:
        os.close(watching)
    while data:
        length = _EVENT.unpack_from(data)[3]
        names.append(os.fsdecode(data[_EVENT.size : _EVENT.size + length].rstrip(b"\0")))
        data = data[_EVENT.size + length :]
    return names.count(os.path.basename(path))


def test_reading_takes_few_calls(large):
    large.vertices  # what is set up once
    calls = own_calls(lambda: large.vertices)
    assert 0 < len(calls) <= 40, calls
    calls = own_calls(lambda: MapFile(large.path).vertices)
    assert len(calls) <= 106, calls


def test_the_calls_do_not_grow_with_the_map(large, tmp_path):
    mesh = Mesh(np.eye(3, dtype=np.float32), np.array([[0, 1, 2]], np.uint32))
    small = MapFile.write(tmp_path / "small.h5", mesh)
    small.vertices
    assert len(own_calls(lambda: large.vertices)) == len(own_calls(lambda: small.vertices))


CALLS = {
    "open": lambda file: MapFile(file.path),
    "vertices": lambda file: file.vertices,
    "parts": lambda file: file.parts,
    "uuid": lambda file: file.uuid,
    "label_names": lambda file: file.label_names(),
    "read": lambda file: file.read(),
    "update": lambda file: file.update(Edit(frame_id="odom")),
    "write_layers": lambda file: file.write_layers({"slope": (np.zeros(40), {"radius": 1})}),
}


@pytest.mark.parametrize("name", CALLS)
def test_each_call_opens_the_file_once(tmp_path, full_mesh, name):
    file = MapFile.write(tmp_path / "a.h5", full_mesh)
    assert opens_of(file.path, lambda: CALLS[name](file)) == 1


def test_after_a_save_the_file_is_not_opened_to_know_what_is_in_it(tmp_path, full_mesh):
    full_mesh.vertex_normals = None
    file = MapFile.write(tmp_path / "a.h5", full_mesh)
    normals = np.ones((40, 3), np.float32)

    def save():
        file.update(Edit(vertex_normals=normals, remove=frozenset({"vertex_colors"})))
        assert file.has_normals and not file.has_colors

    assert opens_of(file.path, save) == 1
    assert file.vertex_normals.shape == (40, 3) and file.vertex_colors is None


def test_one_process_reads_several_members(tmp_path, full_mesh, monkeypatch):
    path = tmp_path / "a.h5"
    MapFile.write(path, full_mesh)
    forks, original = [], ZYGOTE.child
    monkeypatch.setattr(ZYGOTE, "child", lambda limit: forks.append(limit) or original(limit))
    IsolatedMapFile(path).read()
    assert len(forks) == 1
    with IsolatedMapFile(path) as file:
        assert len(file.vertices) == 40 and len(file.faces) == 60
        assert file.frame_id and file.layer_names() and file.read().vertex_costs
    assert len(forks) == 2
    file = IsolatedMapFile(path)
    assert len(file.vertices) == 40 and len(forks) == 3
    assert len(file.vertices) == 40 and len(forks) == 4
