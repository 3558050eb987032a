"""Files on which libhdf5 itself crashes or never ends: one error, and the reading process goes on.

HDF5 1.10 believes the sizes in a heap of variable-length texts (our own files have none that are
read; those of others may), and divides by the sides of chunks without a look at them.
"""
import re
import struct
import subprocess
import sys

import h5py
import numpy as np
import pytest
from crashers import LIES, write_crasher

from mesh_msgs_hdf5.formats.importer import read_mesh
from mesh_msgs_hdf5.isolation import IsolatedMapFile
from mesh_msgs_hdf5.map_file import MapFile
from mesh_msgs_hdf5.model.errors import MapFileError


def write_layout_of_another_version(path, mesh):
    """A map in which the layout of a face attribute says that it is of version 1.

    Then other bytes are taken for the sides of its chunks, zeros among them.
    """
    MapFile.write(path, mesh)
    with h5py.File(path) as file:
        (side,) = file["mesh/face_attributes/cost"].chunks
    data = path.read_bytes()
    # a layout message: version 3, chunked, 2 numbers; an address; rows, bytes of a number
    layout = b"\x03\x02\x02(.{8}%s)" % re.escape(struct.pack("<II", side, 4))
    data, count = re.subn(layout, b"\x01\x02\x02\\1", data, flags=re.DOTALL)
    assert count
    path.write_bytes(data)


@pytest.fixture(params=LIES)
def crasher(request, tmp_path, full_mesh):
    """(path, codes of the error; a libhdf5 that is mended finds the damage itself)."""
    path = tmp_path / "a.h5"
    write_crasher(path, full_mesh, request.param)
    return path, {"crash": ("crashed", "damaged"), "loop": ("timeout", "damaged")}[request.param]


def test_each_access_is_one_error(crasher, full_mesh):
    path, codes = crasher
    file = IsolatedMapFile(path, timeout=4)
    with pytest.raises(MapFileError) as refused:
        file.frame_id
    assert refused.value.code in codes and refused.value.path == str(path)
    assert refused.value.hint and "\n" not in str(refused.value)
    assert np.array_equal(file.vertices, full_mesh.vertices)  # what is sound can be had


def test_a_save_into_it_leaves_it_as_it_was_or_is_whole(crasher):
    """Whatever of the file must be read for that."""
    path, codes = crasher
    old = path.read_bytes()
    try:
        IsolatedMapFile(path, timeout=4).write_layers({"new": (np.ones(40, np.float32), None)})
    except MapFileError as error:
        assert error.code in codes + ("save",) and path.read_bytes() == old
    else:
        assert np.array_equal(IsolatedMapFile(path).vertex_costs("new"), np.ones(40))
    assert [place.name for place in path.parent.iterdir() if ".tmp" not in place.name] == [
        path.name
    ]


def test_a_layout_of_another_version(tmp_path, rich_mesh):
    """A bit of one of our own files, found among the mutations."""
    path = tmp_path / "a.h5"
    write_layout_of_another_version(path, rich_mesh)
    for read in (lambda path: IsolatedMapFile(path).read(), read_mesh):
        with pytest.raises(MapFileError) as refused:
            read(path)
        assert refused.value.code in ("crashed", "damaged") and refused.value.path == str(path)
        if refused.value.code == "crashed":
            assert "SIGFPE" in refused.value.message
    assert np.array_equal(IsolatedMapFile(path).vertices, rich_mesh.vertices)


def test_the_command_goes_on(tmp_path, full_mesh):
    """mesh_tool says so in one line and ends with 1, as for any bad file."""
    path = tmp_path / "a.h5"
    write_crasher(path, full_mesh, "crash")
    with pytest.raises(MapFileError) as refused:
        read_mesh(path)
    assert refused.value.code in ("crashed", "damaged")
    program = "import sys; sys.path[:] = %r; from mesh_msgs_hdf5.commands import mesh_tool; %s"
    result = subprocess.run(
        [sys.executable, "-c", program % (sys.path, "sys.exit(mesh_tool.main())"), "import"]
        + [str(path), str(tmp_path / "b.h5")],
        stderr=subprocess.PIPE,
        check=False,
    )
    said = result.stderr.decode()
    assert result.returncode == 1 and said.count("\n") == 1 and str(path) in said, said
    assert not (tmp_path / "b.h5").exists()
