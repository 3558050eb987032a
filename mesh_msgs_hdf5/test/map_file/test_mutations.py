"""Thousands of damaged files, each read in a process of its own: a good read or one MapFileError.

Crashes inside libhdf5 are allowed there, for that is why nodes read through IsolatedMapFile: each
is then read through that, and must be an error like any other.
"""
import collections
import dataclasses
import itertools
import os

import numpy as np
import pytest
from every_member import reading_members
from forked import outcomes
from map_samples import SAMPLES, assert_same
from mutations import Mutations

from mesh_msgs_hdf5.isolation import IsolatedMapFile
from mesh_msgs_hdf5.map_file import MapFile
from mesh_msgs_hdf5.model.errors import MapFileError
from mesh_msgs_hdf5.model.mesh import Mesh

GEOMETRY = ("vertices", "faces")
# what reading all asks the same reader for: where that is good, these are good one by one too
IN_ALL = {field.name for field in dataclasses.fields(Mesh)}
IN_ALL |= {"layer_names", "face_attribute_names", "face_attribute", "label_names", "stored_uuid"}
IN_ALL |= {"texture_indices", "texture"}
COUNT, BATCHES, SAMPLES_COUNT = 1000, 2, 60
SHARING = 60  # so many are read in one process, where none ends it
TURNS = 3  # of what is read apart from the whole, each file meets every third


def write_map_of_everything(path, mesh):
    """Our own form, with something unknown in it."""
    import h5py

    MapFile.write(path, mesh)
    with h5py.File(path, "r+") as file:
        scan = file.create_dataset("raw/scans/0", data=np.arange(3000.0), chunks=(500,))
        scan.attrs["pose"] = np.eye(4)
        file["raw"].attrs["robot"] = "pluto"
    return MapFile(path).read()


class Reader:
    """Reads mutations of a file, in whatever process it is called."""

    def __init__(self, folder, data, mesh):
        self._folder = folder
        self._mutations = Mutations(data)
        self._mesh = mesh

    def path(self, number):
        path = self._folder / ("%d.h5" % number)
        path.write_bytes(self._mutations(number))
        return path

    def __call__(self, number):
        """[code of reading all, members that are silently wrong, errors that are no MapFileError].

        The code is "good" for no error.
        """
        path = self.path(number)
        wrong, strange = [], []
        try:
            code = self._read(number, path, wrong, strange)
        finally:
            path.unlink()
        return code, wrong, strange

    def _read(self, number, path, wrong, strange):
        try:
            file = MapFile(path)
            members = dict(reading_members(file))
            code = self._use("read", members.pop("read"), wrong, strange)
            apart = [name for name in members if code != "good" or name not in IN_ALL]
            for name in apart[number % TURNS :: TURNS]:
                self._use(name, members[name], [], strange)
        except MapFileError as error:
            return error.code
        except Exception as error:
            strange.append(repr(error)[:200])
            return "strange"
        return code

    def _use(self, name, member, wrong, strange):
        try:
            value = member()
        except MapFileError as error:
            assert error.code and "\n" not in str(error)
            return error.code
        except Exception as error:
            strange.append("%s: %r" % (name, error)[:200])
            return "strange"
        if isinstance(value, Mesh):
            wrong += [one for one in different_members(value, self._mesh)]
        return "good"

    def is_refused_apart(self, number):
        """The code of the error that reading it through IsolatedMapFile ends with."""
        with pytest.raises(MapFileError) as refused:
            file = IsolatedMapFile(self.path(number), timeout=20)
            for _, member in reading_members(file):
                member()
        return refused.value.code


def different_members(found, mesh):
    for field in dataclasses.fields(Mesh):
        try:
            assert_same(getattr(found, field.name), getattr(mesh, field.name), field.name)
        except AssertionError:
            yield field.name


def is_suspect(wrong, strange):
    """What the files before may have done to the process: such a file is read again, alone."""
    return bool(strange or set(wrong) & set(GEOMETRY))


def examine(reader, numbers):
    """Counters of codes and of wrong members; what ended in no good way is proven harmless."""
    codes, wrong = collections.Counter(), collections.Counter()
    for number, outcome in outcomes(reader, numbers, seconds=30, batch=SHARING):
        if isinstance(outcome, list) and is_suspect(*outcome[0][1:]):
            ((_, outcome),) = outcomes(reader, [number], seconds=30)
        if isinstance(outcome, str):  # the name of a signal
            code = reader.is_refused_apart(number)
            codes["%s, apart: %s" % (outcome, code)] += 1
            assert code in ("crashed", "timeout", "size"), number
            continue
        (code, members, strange), _ = outcome
        assert not strange, (number, strange)
        codes[code] += 1
        wrong.update(members)
    return codes, wrong


@pytest.fixture
def memory_folder(tmp_path):
    """A folder in memory if there is one: thousands of files are written."""
    folder = "/dev/shm/mesh_msgs_hdf5_%d" % os.getpid()
    if not os.access("/dev/shm", os.W_OK):
        yield tmp_path
        return
    path = type(tmp_path)(folder)
    path.mkdir(exist_ok=True)
    yield path
    for name in path.iterdir():
        name.unlink()
    path.rmdir()


@pytest.mark.parametrize("batch", range(BATCHES))
def test_mutations_of_a_map_of_everything(memory_folder, tmp_path, rich_mesh, batch):
    path = tmp_path / "whole.h5"
    mesh = write_map_of_everything(path, rich_mesh)
    reader = Reader(memory_folder, path.read_bytes(), mesh)
    size = COUNT // BATCHES
    codes, wrong = examine(reader, range(batch * size, (batch + 1) * size))
    print(dict(codes), "silently wrong:", dict(wrong))
    assert sum(codes.values()) == size and codes["good"] > size // 10 < size - codes["good"]
    assert not set(wrong) & set(GEOMETRY)  # its UUID is made of it


def test_a_map_cut_off_at_each_fiftieth(memory_folder, tmp_path, rich_mesh):
    path = tmp_path / "whole.h5"
    mesh = write_map_of_everything(path, rich_mesh)
    data = path.read_bytes()

    class Cut(Reader):
        def path(self, number):
            path = self._folder / ("%d.h5" % number)
            path.write_bytes(data[: len(data) * number // 50])
            return path

    codes, _ = examine(Cut(memory_folder, data, mesh), range(50))
    assert set(codes) <= {"empty", "format", "truncated", "damaged"} and codes["empty"] == 1


@pytest.mark.parametrize("layout", SAMPLES)
def test_mutations_of_files_of_other_programs(memory_folder, tmp_path, rich_mesh, layout):
    path = tmp_path / "whole.h5"
    mesh = SAMPLES[layout](path, rich_mesh)
    reader = Reader(memory_folder, path.read_bytes(), mesh)
    codes, wrong = examine(reader, range(SAMPLES_COUNT))
    print(layout, dict(codes), "silently wrong:", dict(wrong))
    assert sum(codes.values()) == SAMPLES_COUNT and codes["good"]


def test_the_examination_itself_notices(memory_folder, tmp_path, rich_mesh):
    """A crash, an error of another kind and a wrong member."""
    path = tmp_path / "whole.h5"
    mesh = write_map_of_everything(path, rich_mesh)
    reader = Reader(memory_folder, path.read_bytes(), mesh)
    found = dict(outcomes(lambda number: [os.abort, dict][number](), range(2)))
    assert found[0] == "SIGABRT" and found[1][0] == {}
    changed = dataclasses.replace(
        mesh, crs="x", labels=dict(itertools.islice(mesh.labels.items(), 2))
    )
    assert list(different_members(changed, mesh)) == ["labels", "crs"]
    wrong, strange = [], []
    assert reader._use("read", lambda: changed, wrong, strange) == "good" and wrong
    assert reader._use("read", lambda: {}[0], wrong, strange) == "strange" and strange
