"""Whatever happens to the disk, the process or another program while a map is saved: the old or the
new file is there, one clear error, and nothing beside it after the next save.

Both ways of building are tried: in memory, and on disk as large files are.
"""
import contextlib
import errno
import fcntl
import functools
import os
import resource
import signal
import subprocess
import sys
import threading
import time

import numpy as np
import pytest
from forked import outcomes
from map_samples import assert_same_mesh
from raw_contents import raw_contents, without

from mesh_msgs_hdf5.files import save
from mesh_msgs_hdf5.map_file import MapFile
from mesh_msgs_hdf5.map_file.writing import map_saving
from mesh_msgs_hdf5.model.edit import Edit
from mesh_msgs_hdf5.model.errors import MapFileError
from mesh_msgs_hdf5.model.mesh import Label

CALLS = ("open", "memfd_create", "posix_fallocate", "fchown", "fchmod", "pread", "write") + (
    "fsync",
    "close",
    "replace",
)
EDIT = Edit(vertex_costs={"new": np.arange(40.0)}, layer_parameters={"new": {"a": 1}})
IN_MEMORY, ON_DISK = 1 << 40, 0
WRITE_BYTES = save.WRITE_BYTES


@pytest.fixture(params=[IN_MEMORY, ON_DISK], ids=["in memory", "on disk"])
def budget(request, monkeypatch):
    monkeypatch.setattr(map_saving, "MEMORY_BUDGET", request.param)
    monkeypatch.setattr(map_saving, "_SLACK_BYTES", 1 << 16)
    monkeypatch.setattr(save, "WRITE_BYTES", 1000)
    return request.param


@pytest.fixture
def rich_map(tmp_path, strange_data):
    path = tmp_path / "a.h5"
    path.write_bytes(strange_data)
    return path


@pytest.fixture
def small_map(tmp_path, full_data):
    """For what saves many times; what all is carried over, test_update.py knows."""
    path = tmp_path / "a.h5"
    path.write_bytes(full_data)
    return path


@pytest.fixture
def plain_map(tmp_path, rich_data):
    """With labels, and without strange things."""
    path = tmp_path / "a.h5"
    path.write_bytes(rich_data)
    return path


class Known:
    """raw_contents() of files; those of the same bytes are looked at once."""

    def __init__(self):
        self._found = {}

    def __call__(self, path):
        data = path.read_bytes()
        if data not in self._found:
            self._found[data] = raw_contents(path)
        return self._found[data]


class Steps:
    """Counts the calls to the system while active, and does something at the k-th."""

    def __init__(self, monkeypatch, at=None, action=None, after=False):
        self.calls = []
        self.done = []
        self._at, self._action, self._after = at, action, after
        for name in CALLS:
            monkeypatch.setattr(os, name, self._wrapped(name, getattr(os, name)))

    def _wrapped(self, name, original):
        def call(*arguments, **more):
            self.calls.append(name)
            mine = len(self.calls) - 1 == self._at
            if mine and not self._after:
                if name == "close":  # the kernel closes all the same
                    original(*arguments)
                self._action()
            result = original(*arguments, **more)
            if mine and self._after:
                self._action()
            self.done.append(name)
            return result

        return call


def rehearse(path, monkeypatch):
    """The calls of one save, of a file that is thrown away."""
    copy = path.parent / "rehearsal.h5"
    copy.write_bytes(path.read_bytes())
    file = MapFile(copy)
    with monkeypatch.context() as patch:
        steps = Steps(patch)
        file.update(EDIT)
    os.unlink(copy)
    return steps.calls


@pytest.mark.parametrize("error", [errno.EIO, errno.ENOSPC])
def test_whichever_call_fails(small_map, monkeypatch, budget, error):
    calls = rehearse(small_map, monkeypatch)
    wanted = ["posix_fallocate", "write"] if budget == ON_DISK else ["memfd_create", "write"]
    assert set(wanted) <= set(calls) and len(calls) > 12
    assert budget == ON_DISK or calls.count("write") >= 8
    old = small_map.read_bytes()
    new, contents = None, Known()

    def fail():
        raise OSError(error, os.strerror(error))

    kinds = set()
    for k in range(len(calls)):
        small_map.write_bytes(old)
        file = MapFile(small_map)
        message = ""
        with monkeypatch.context() as patch:
            steps = Steps(patch, k, fail)
            try:
                file.update(EDIT)
            except MapFileError as refused:
                message = str(refused)
                assert refused.code == "save" and os.strerror(error) in message, calls[k]
        kinds.add((steps.calls[k], bool(message)))
        assert os.listdir(small_map.parent) == ["a.h5"], calls[k]
        if "replace" in steps.done:
            assert not message or "is saved, but" in message
            new = new or contents(small_map)
            assert contents(small_map) == new
        else:
            assert "nothing was changed" in message and small_map.read_bytes() == old, calls[k]
    # only to let go of a folder may fail without a word
    assert {kind for kind, told in kinds if not told} == {"close"} and new
    assert {kind for kind, told in kinds if told} == set(calls)


@pytest.mark.parametrize("after", [False, True])
def test_a_kill_at_every_step(small_map, monkeypatch, budget, after):
    """SIGKILL before or after the k-th call, in a child; then a save that finds what it left."""
    calls = rehearse(small_map, monkeypatch)
    old, skip = small_map.read_bytes(), ["/mesh/channels/new"]
    contents = Known()
    whole = contents(small_map)
    file = MapFile(small_map)
    outcomes = []
    for k in range(len(calls)):
        small_map.write_bytes(old)
        child = os.fork()
        if not child:
            Steps(pytest.MonkeyPatch(), k, lambda: os.kill(os.getpid(), signal.SIGKILL), after)
            with contextlib.suppress(BaseException):
                MapFile(small_map).update(EDIT)
            os._exit(0)
        status = os.waitpid(child, 0)[1]
        assert os.WIFSIGNALED(status) and os.WTERMSIG(status) == signal.SIGKILL
        found = contents(small_map)
        outcomes.append("old" if found == whole else "new")
        if found != whole:
            assert without(found, skip) == without(whole, skip)
            assert file.vertex_costs("new").tolist() == EDIT.vertex_costs["new"].tolist()
        file.update(Edit(frame_id="later"))
        assert os.listdir(small_map.parent) == ["a.h5"], calls[k]
    assert outcomes == sorted(outcomes, reverse=True) and set(outcomes) == {"old", "new"}


@contextlib.contextmanager
def small_disk(folder, size):
    """A file system of so many bytes, or skip."""
    folder.mkdir()
    command = ["mount", "-t", "tmpfs", "-o", "size=%d" % size, "tmpfs", str(folder)]
    if os.geteuid() or subprocess.run(command, capture_output=True).returncode:
        pytest.skip("no permission to mount a small disk")
    try:
        yield
    finally:
        subprocess.run(["umount", str(folder)], check=True)


def test_a_full_disk(tmp_path, rich_map, budget):
    """Of any size that is too small: the old file stays, and there is room again afterwards."""
    data = rich_map.read_bytes()
    rest = raw_contents(rich_map)
    outcomes = []
    for room in (0, 1, 3, 8, 16, 24, 40, 60, 200):
        pages = -(-len(data) // 4096) + room
        disk = tmp_path / ("disk %d" % room)
        with small_disk(disk, pages * 4096):
            (disk / "a.h5").write_bytes(data)
            free = os.statvfs(disk).f_bavail
            try:
                MapFile(disk / "a.h5").update(EDIT)
                outcomes.append("saved")
            except MapFileError as refused:
                assert refused.code == "save" and "No space left" in str(refused)
                assert "make room" in refused.hint and "nothing was changed" in refused.message
                outcomes.append("full")
                assert raw_contents(disk / "a.h5") == rest
                assert os.statvfs(disk).f_bavail == free
            assert os.listdir(disk) == ["a.h5"]
    assert outcomes == sorted(outcomes) and set(outcomes) == {"full", "saved"}


FULL = """
import resource, sys
import numpy as np
from mesh_msgs_hdf5.model.edit import Edit
from mesh_msgs_hdf5.model.errors import MapFileError
from mesh_msgs_hdf5.map_file import MapFile
from mesh_msgs_hdf5.map_file.writing import map_saving

path, budget, limit = sys.argv[1], int(sys.argv[2]), int(sys.argv[3])
map_saving.MEMORY_BUDGET = budget
map_saving._SLACK_BYTES = 1 << 16
resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit))
try:
    MapFile(path).update(Edit(vertex_costs={"new": np.arange(40.0)}))
except MapFileError as error:
    print(error.code, error)
"""


@pytest.mark.parametrize("part", [0.0, 0.3, 0.9])
def test_a_limit_of_the_file_size(rich_map, budget, part):
    """The process ends well too: HDF5 never sees the error."""
    old = rich_map.read_bytes()
    limit = str(int(len(old) * part))
    done = subprocess.run(
        [sys.executable, "-c", FULL, str(rich_map), str(budget), limit],
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0 and done.stderr == ""
    assert done.stdout.startswith("save ") and "nothing was changed: File too large" in done.stdout
    assert rich_map.read_bytes() == old and os.listdir(rich_map.parent) == ["a.h5"]


@pytest.mark.parametrize("error", [errno.EXDEV, errno.EBUSY, errno.EPERM])
def test_a_file_that_cannot_be_renamed(rich_map, monkeypatch, budget, error):
    """A file that is mounted by itself, as containers do; one that is immutable."""
    old = rich_map.read_bytes()

    def replace(_source, _target):
        raise OSError(error, os.strerror(error))

    monkeypatch.setattr(os, "replace", replace)
    with pytest.raises(MapFileError, match="nothing was changed") as refused:
        MapFile(rich_map).update(EDIT)
    assert refused.value.hint
    assert rich_map.read_bytes() == old and os.listdir(rich_map.parent) == ["a.h5"]


def test_a_lock_that_is_busy_is_waited_for(rich_map, monkeypatch, budget):
    """EAGAIN a few times; and ENOLCK, as NFS says, is no lock at all."""
    original = fcntl.flock
    busy = iter([errno.EAGAIN] * 3 + [errno.ENOLCK] + [errno.EAGAIN] * 2)

    def flock(descriptor, kind):
        error = next(busy, None)
        if error is not None:
            raise OSError(error, os.strerror(error))
        original(descriptor, kind)

    monkeypatch.setattr(save.fcntl, "flock", flock)
    MapFile(rich_map).update(EDIT)
    assert "new" in MapFile(rich_map).layer_names() and os.listdir(rich_map.parent) == ["a.h5"]


def test_a_clock_that_jumps(rich_map, rich_mesh, budget):
    """Another program's save is noticed whatever its times are."""
    file = MapFile(rich_map)
    status = os.stat(rich_map)
    os.utime(rich_map, (2**31, 2**31))  # the old file is from the future
    file.update(EDIT)
    assert os.stat(rich_map).st_mtime < 2**31
    os.utime(rich_map, ns=(status.st_atime_ns, status.st_mtime_ns))  # and the new one from before
    file.update(Edit(frame_id="later"))
    assert file.frame_id == "later" and "new" in file.layer_names()
    one = save.stamp(rich_map)
    data = bytearray(rich_map.read_bytes())
    time.sleep(0.02)  # the clock of a file system has steps
    with open(rich_map, "r+b") as raw:
        raw.write(data)
    os.utime(rich_map, ns=(one[3], one[3]))
    assert save.stamp(rich_map) != one  # written to in place, and its time set back


def test_a_lock_file_of_another_program_does_not_matter(rich_map, budget):
    """There are none of ours; a lock dies with its owner."""
    (rich_map.parent / "a.h5.lock").write_text("1")
    MapFile(rich_map).update(EDIT)
    assert sorted(os.listdir(rich_map.parent)) == ["a.h5", "a.h5.lock"]


def test_readers_during_a_save_see_the_old_or_the_new_mesh(small_map, budget):
    """Whole, always; four of them, while one writer saves again and again."""
    stop, failures, seen = threading.Event(), [], set()

    def read():
        while not stop.is_set():
            try:
                mesh = MapFile(small_map).read()
                costs = mesh.vertex_costs.get("count", np.zeros(40, "f4"))
                parameters = mesh.layer_parameters.get("count", {"i": 0})
                assert (costs == costs[0]).all() and parameters["i"] == costs[0]
                seen.add(costs[0])
            except Exception as error:  # any at all fails the test
                failures.append(error)

    readers = [threading.Thread(target=read) for _ in range(4)]
    interval = sys.getswitchinterval()
    sys.setswitchinterval(interval / 20)  # they meet more often, and the writer waits less
    for reader in readers:
        reader.start()
    try:
        file = MapFile(small_map)
        for i in range(1, 16):
            file.write_layers({"count": (np.full(40, i, "f4"), {"i": i})})
    finally:
        stop.set()
        sys.setswitchinterval(interval)
        for reader in readers:
            reader.join()
    assert not failures and len(seen) > 2


def write_labels(path, name):
    """Eight, one by one, until each is in the file."""
    done = 0
    while done < 8:
        try:
            MapFile(path).update(Edit(labels={"%s_%d" % (name, done): Label(np.array([done]))}))
            done += 1
        except MapFileError as error:
            if error.code != "changed":
                raise


def test_several_writers_lose_nothing(plain_map, rich_mesh, budget, monkeypatch):
    """Each save goes through, or is refused as one that would undo the other's."""
    monkeypatch.setattr(save, "WRITE_BYTES", WRITE_BYTES)
    names = "abc"
    found = outcomes(functools.partial(write_labels, plain_map), names, at_once=len(names))
    assert sorted(value for value, outcome in found if outcome[0] is None) == list(names)
    names = set(MapFile(plain_map).label_names())
    assert {"%s_%d" % (name, i) for name in "abc" for i in range(8)} <= names
    assert set(rich_mesh.labels) <= names and os.listdir(plain_map.parent) == ["a.h5"]


MEMORY = """
import sys
import numpy as np
from mesh_msgs_hdf5.model.edit import Edit
from mesh_msgs_hdf5.map_file import MapFile
from mesh_msgs_hdf5.model.mesh import Mesh
from mesh_msgs_hdf5.map_file.writing import map_saving

map_saving.MEMORY_BUDGET = 1 << 20
MapFile(sys.argv[1]).layer_names()
def peak():
    with open("/proc/self/status") as status:
        return next(int(line.split()[1]) << 10 for line in status if line.startswith("VmHWM"))
before = peak()
MapFile(sys.argv[1]).update(Edit(vertex_costs={"new": np.arange(40.0)}))
print(peak() - before)
"""


def test_large_files_take_little_memory(rich_map, rich_mesh):
    """150 MB of scans, contiguous and in chunks, are carried over with a fraction of that."""
    import h5py

    rng = np.random.default_rng(0)
    with h5py.File(rich_map, "r+") as file:
        scans = file.create_group("large")
        scans["contiguous"] = rng.random(12_000_000).astype("f4")
        scans.create_dataset("chunks", data=rng.random((12_500_000, 2)).astype("f4"), chunks=True)
    before = raw_contents(rich_map, ["/mesh/channels/new"])
    done = subprocess.run(
        [sys.executable, "-c", MEMORY, str(rich_map)], capture_output=True, text=True, check=True
    )
    assert os.path.getsize(rich_map) > 140e6 and int(done.stdout) < 40e6
    assert raw_contents(rich_map, ["/mesh/channels/new"]) == before
    rich_mesh.vertex_costs["new"] = np.arange(40, dtype="f4")
    assert_same_mesh(MapFile(rich_map).read(), rich_mesh)


PEAK = """
import os, sys
import numpy as np
from mesh_msgs import zoo
from mesh_msgs_hdf5.map_file import MapFile
from mesh_msgs_hdf5.model.mesh import Mesh

def resident(name):
    with open("/proc/self/status") as status:
        return next(int(line.split()[1]) << 10 for line in status if line.startswith(name))

def mesh(faces):
    world = zoo.outdoor_world(faces=faces, seed=3)
    vertices = np.array(world.vertices, np.float32)
    costs = {str(i): vertices[:, 2] * np.float32(i + 1) for i in range(5)}
    normals = np.random.default_rng(0).random(vertices.shape, dtype=np.float32)
    return Mesh(vertices, np.array(world.faces, np.uint32), normals, vertex_costs=costs)

large = mesh(1_500_000)
small = mesh(1000)
arrays = [large.vertices, large.faces, large.vertex_normals, *large.vertex_costs.values()]
size = sum(array.nbytes for array in arrays)
for compression in sys.argv[2:]:
    if os.fork():
        assert os.wait()[1] == 0
        continue
    MapFile.write(sys.argv[1], small, compression=compression)
    with open("/proc/self/clear_refs", "w") as reset:
        reset.write("5")
    before = resident("VmRSS") - size
    MapFile.write(sys.argv[1], large, compression=compression)
    image = os.path.getsize(sys.argv[1])  # a file in memory is not resident
    print(compression, (resident("VmHWM") - before + image) / size)
    sys.exit()
"""
COMPRESSIONS = ["gzip", "none"]


@pytest.fixture(scope="module")
def peaks(tmp_path_factory):
    """Compression -> memory at its peak, in sizes of the arrays; each in a process of its own."""
    path = tmp_path_factory.mktemp("peak") / "a.h5"
    command = [sys.executable, "-c", PEAK, str(path), *COMPRESSIONS]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    return dict(line.split() for line in done.stdout.splitlines())


@pytest.mark.parametrize("compression", COMPRESSIONS)
def test_memory_is_at_most_two_and_a_half_times_the_arrays(peaks, compression):
    """The arrays themselves and the file in memory are in that."""
    assert 1.0 < float(peaks[compression]) <= 2.5


def test_memory_that_does_not_suffice_is_one_error(rich_map):
    """The child may take hardly more than it has: a large map is refused cleanly."""
    code = """
import resource, sys
import numpy as np
from mesh_msgs_hdf5.model.errors import MapFileError
from mesh_msgs_hdf5.map_file import MapFile
from mesh_msgs_hdf5.model.mesh import Mesh
rows = 4_000_000
mesh = Mesh(np.ones((rows, 3), "f4"), np.zeros((rows, 3), "u4"),
            vertex_costs={"a": np.random.default_rng(0).random(rows).astype("f4")})
pages = int(open("/proc/self/statm").read().split()[0])
limit = pages * 4096 + (6 << 20)  # half of what it takes to look whether vertices are finite
resource.setrlimit(resource.RLIMIT_AS, (limit, limit))
try:
    MapFile.write(sys.argv[1], mesh, compression="none")
except MapFileError as error:
    print(error.code)
except MemoryError:
    print("memory")
"""
    old = rich_map.read_bytes()
    done = subprocess.run(
        [sys.executable, "-c", code, str(rich_map)], capture_output=True, text=True
    )
    assert (done.returncode, done.stdout) == (0, "save\n"), done.stderr
    assert rich_map.read_bytes() == old and os.listdir(rich_map.parent) == ["a.h5"]


def test_rlimit_is_as_it_was():
    """The tests above set limits in children only."""
    assert resource.getrlimit(resource.RLIMIT_FSIZE)[0] == resource.RLIM_INFINITY
