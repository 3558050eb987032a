"""A map that another program has open to write: that is said, and nothing is called damaged."""
import errno
import os

import h5py
import numpy as np
import pytest
from holding import held_open

from mesh_msgs_hdf5.commands.mesh_tool import main
from mesh_msgs_hdf5.isolation import IsolatedMapFile, isolated
from mesh_msgs_hdf5.map_file import MapFile
from mesh_msgs_hdf5.map_file.hdf5.hdf5_guard import translated
from mesh_msgs_hdf5.model.edit import Edit
from mesh_msgs_hdf5.model.errors import MapFileError
from mesh_msgs_hdf5.model.mesh import Label


@pytest.fixture
def path(tmp_path, full_data):
    (tmp_path / "a.h5").write_bytes(full_data)
    return tmp_path / "a.h5"


@pytest.mark.parametrize("kind", [MapFile, IsolatedMapFile])
def test_it_is_a_code_of_its_own_until_that_program_is_closed(path, kind):
    file = kind(path)
    with held_open(path):
        before = path.read_bytes()
        edit = Edit(labels={"a_1": Label(np.uint32([1]))})
        for use in (lambda: kind(path), lambda: file.vertices, lambda: file.update(edit)):
            with pytest.raises(MapFileError) as refused:
                use()
            assert refused.value.code == "locked" and refused.value.path == str(path)
            assert "open" in refused.value.message and "close" in refused.value.hint
        with pytest.raises(MapFileError) as refused:
            isolated("repack", path, str(path), overwrite=True)
        assert refused.value.code == "locked" and path.read_bytes() == before
    file.update(edit)
    assert kind(path).label_names() == ["a_1"]


def test_a_file_with_a_user_block_is_an_hdf5_file_all_the_same(tmp_path):
    """HDF5 does not tell what it is while it is locked."""
    path = tmp_path / "block.h5"
    with h5py.File(path, "w", userblock_size=512) as file:
        file["a"] = 1
    with held_open(path), pytest.raises(MapFileError) as refused:
        MapFile(path)
    assert refused.value.code == "locked"


def test_the_mark_of_a_program_that_was_killed(path):
    """The newest kind of HDF5 file has one: nothing is damaged, and the way out is named."""
    with h5py.File(path, "r") as old, h5py.File(path.parent / "b.h5", "w", libver="latest") as new:
        for name in old:
            old.copy(name, new)
    path = path.parent / "b.h5"
    with held_open(path) as process:
        process.kill()
        process.wait()
        with pytest.raises(MapFileError) as refused:
            MapFile(path)
        assert refused.value.code == "locked" and "h5clear -s" in refused.value.hint


def test_a_disk_without_locks_is_not_waited_for():
    text = "Unable to open file (unable to lock file, errno = 37, error message = 'No locks')"
    error = translated("a.h5", OSError(errno.ENOLCK, text))
    assert error.code == "unreadable" and "HDF5_USE_FILE_LOCKING" in error.hint


def test_every_verb_ends_with_that_error(path, capsys, tmp_path):
    new, other = str(tmp_path / "new"), tmp_path / "b.h5"
    other.write_bytes(path.read_bytes())
    with held_open(path):
        for arguments in (
            ["info", path],
            ["layers", path],
            ["labels", "delete", path, "a_1"],
            ["export", path, new + ".ply"],
            ["convert", path, new + ".h5"],
            ["import", path, new + ".h5"],
            ["import", other, path, "--force"],  # what that program writes would be lost
            ["parts", "copy", path, "mesh", "new"],
            ["repack", path],
            ["render", path, new + ".png"],
            ["diff", path, path],
            ["validate", path],
        ):
            code = main([str(argument) for argument in arguments])
            out, err = capsys.readouterr()
            assert code == (2 if arguments[0] == "diff" else 1), arguments
            assert "close the program that has it open" in out + err and "restore" not in out + err
    assert sorted(os.listdir(tmp_path)) == ["a.h5", "b.h5"]
