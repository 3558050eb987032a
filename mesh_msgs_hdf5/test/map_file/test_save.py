"""Saving: the old or the new file at every moment, and nothing beside it."""
import contextlib
import errno
import fcntl
import os
import pwd
import signal
import stat
import struct
import subprocess
import sys
import time

import h5py
import numpy as np
import pytest

from mesh_msgs_hdf5.files import save
from mesh_msgs_hdf5.map_file import MapFile
from mesh_msgs_hdf5.map_file.writing import hdf5_stream, map_saving
from mesh_msgs_hdf5.model.edit import Edit
from mesh_msgs_hdf5.model.errors import MapFileError
from mesh_msgs_hdf5.model.mesh import Mesh

# an access control list: (tag, rights, user) of the owner, user 4321, the group, the mask, others
_ACCESS = [
    1,
    6,
    -1 % 2**32,
    2,
    6,
    4321,
    4,
    4,
    -1 % 2**32,
    16,
    6,
    -1 % 2**32,
    32,
    0,
    -1 % 2**32,
]
CALLS = ("open", "fchmod", "write", "fsync", "close", "replace")


class Faults:
    """Counts the calls that save.py makes to the system, and lets the k-th fail."""

    def __init__(self, monkeypatch, failing=None, error=errno.EIO):
        self.calls, self.done = [], []
        for name in CALLS:
            monkeypatch.setattr(
                save.os, name, self._wrapped(name, getattr(os, name), failing, error)
            )

    def _wrapped(self, name, original, failing, error):
        def call(*arguments, **more):
            self.calls.append(name)
            if len(self.calls) - 1 == failing:
                if name == "close":  # the kernel closes all the same
                    original(*arguments)
                raise OSError(error, os.strerror(error))
            result = original(*arguments, **more)
            self.done.append(name)
            return result

        return call


def calls_of_a_save(path, data, monkeypatch):
    with monkeypatch.context() as patch:
        faults = Faults(patch)
        save.save_file(path, data)
    return faults.calls


@pytest.fixture
def small_writes(monkeypatch):
    monkeypatch.setattr(save, "WRITE_BYTES", 1000)


@pytest.mark.parametrize("exists", [True, False])
@pytest.mark.parametrize("error", [errno.EIO, errno.ENOSPC, errno.EDQUOT])
def test_whichever_call_fails_the_old_file_stays(
    tmp_path, monkeypatch, small_writes, exists, error
):
    path = tmp_path / "a.h5"
    calls = calls_of_a_save(tmp_path / "rehearsal", b"n" * 3500, monkeypatch)
    create, write = "open open close", "write write write write fsync"
    assert calls == (create + " " + write + " open close replace fsync close").split()
    os.unlink(tmp_path / "rehearsal")
    count = len(calls) + exists  # one more: fchmod
    outcomes = []
    for k in range(count):
        if exists:
            path.write_bytes(b"old")
        message = ""
        with monkeypatch.context() as patch:
            faults = Faults(patch, failing=k, error=error)
            try:
                save.save_file(path, b"n" * 3500)
            except MapFileError as refused:
                assert refused.code == "save" and os.strerror(error) in str(refused)
                message = refused.message
        if "replace" in faults.done:
            assert path.read_bytes() == b"n" * 3500
            outcomes.append("not synced" if message.startswith("is saved, but") else message)
        else:
            assert "nothing was changed" in message
            assert path.exists() == exists and (not exists or path.read_bytes() == b"old")
            outcomes.append("old")
        assert os.listdir(tmp_path) == (["a.h5"] if path.exists() else [])
        if path.exists():
            os.unlink(path)
    # after its lock has done its work, it does not matter if the folder is closed well; and at the
    # end the new file is in place already
    assert outcomes == ["old"] * 2 + [""] + ["old"] * (count - 5) + ["not synced", ""]


def test_an_interrupt_leaves_nothing(tmp_path, monkeypatch):
    path = tmp_path / "a.h5"
    path.write_bytes(b"old")

    def interrupt(_descriptor):
        raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr(save.os, "fsync", interrupt)
        with pytest.raises(KeyboardInterrupt):
            save.save_file(path, b"new")
    assert path.read_bytes() == b"old" and os.listdir(tmp_path) == ["a.h5"]


def test_short_writes_are_completed(tmp_path, monkeypatch):
    original = os.write
    monkeypatch.setattr(save.os, "write", lambda fd, data: original(fd, data[:7]))
    save.save_file(tmp_path / "a.h5", b"0123456789" * 5)
    assert (tmp_path / "a.h5").read_bytes() == b"0123456789" * 5


def test_a_disk_that_does_not_sync_folders_is_fine(tmp_path, monkeypatch):
    original = os.fsync

    def fsync(descriptor):
        if stat.S_ISDIR(os.fstat(descriptor).st_mode):
            raise OSError(errno.EINVAL, "Invalid argument")
        original(descriptor)

    monkeypatch.setattr(save.os, "fsync", fsync)
    save.save_file(tmp_path / "a.h5", b"new")
    assert (tmp_path / "a.h5").read_bytes() == b"new"


@pytest.mark.parametrize("error", [errno.ENOLCK, errno.EOPNOTSUPP])
def test_a_disk_without_locks_is_fine(tmp_path, monkeypatch, error):
    def flock(_descriptor, _kind):
        raise OSError(error, os.strerror(error))

    monkeypatch.setattr(save.fcntl, "flock", flock)
    save.save_file(tmp_path / "a.h5", b"new")
    assert os.listdir(tmp_path) == ["a.h5"]


def test_mode_and_links_stay(tmp_path):
    target = tmp_path / "deep" / "a.h5"
    target.parent.mkdir()
    target.write_bytes(b"old")
    target.chmod(0o604)
    link = tmp_path / "link.h5"
    link.symlink_to("deep/a.h5")
    save.save_file(link, b"new")
    assert link.is_symlink() and target.read_bytes() == b"new"
    assert stat.S_IMODE(target.stat().st_mode) == 0o604


def test_extended_attributes_stay(tmp_path):
    """Access control lists are such; without them the mode means something else."""
    path = tmp_path / "a.h5"
    path.write_bytes(b"old")
    acl = struct.pack("<I" + 5 * "HHI", 2, *_ACCESS)
    try:
        os.setxattr(path, "user.note", b"mine")
        os.setxattr(path, "system.posix_acl_access", acl)
    except OSError as error:
        pytest.skip("this disk has no such attributes: %s" % error)
    save.save_file(path, b"new")
    assert os.getxattr(path, "user.note") == b"mine"
    assert os.getxattr(path, "system.posix_acl_access") == acl


def test_a_disk_without_extended_attributes_is_fine(tmp_path, monkeypatch):
    def refuse(*_arguments):
        raise OSError(errno.ENOTSUP, os.strerror(errno.ENOTSUP))

    (tmp_path / "a.h5").write_bytes(b"old")
    monkeypatch.setattr(save.os, "setxattr", refuse)
    monkeypatch.setattr(save.os, "listxattr", lambda _path: ["user.note"])
    monkeypatch.setattr(save.os, "getxattr", lambda *_arguments: b"mine")
    save.save_file(tmp_path / "a.h5", b"new")
    monkeypatch.setattr(save.os, "listxattr", refuse)
    save.save_file(tmp_path / "a.h5", b"newer")
    assert (tmp_path / "a.h5").read_bytes() == b"newer"


@pytest.mark.skipif(os.geteuid() != 0, reason="only root may give files away")
def test_the_owner_stays(tmp_path):
    path = tmp_path / "a.h5"
    path.write_bytes(b"old")
    os.chown(path, 12345, 23456)
    save.save_file(path, b"new")
    assert (path.stat().st_uid, path.stat().st_gid) == (12345, 23456)


@pytest.mark.parametrize("place,words", [("a.h5", "file is read-only"), ("", "no permission")])
def test_what_may_not_be_written_is_refused_before_the_work(tmp_path, monkeypatch, place, words):
    path = tmp_path / "a.h5"
    path.write_bytes(b"old")
    forbidden = os.path.realpath(tmp_path / place)
    monkeypatch.setattr(save.os, "access", lambda path, _mode: path != forbidden)
    with pytest.raises(MapFileError, match=words) as refused:
        save.check_target(path, overwrite=True)
    assert refused.value.code == "save"


def test_a_file_without_write_permission_is_read_only_for_root_too(tmp_path, full_mesh):
    path = tmp_path / "a.h5"
    MapFile.write(path, full_mesh)
    before = path.read_bytes()
    path.chmod(0o444)
    for change in (
        lambda: save.save_file(path, b"new"),
        lambda: MapFile.write(path, full_mesh),
        lambda: MapFile(path).update(Edit(frame_id="other")),
    ):
        with pytest.raises(MapFileError, match="the file is read-only") as refused:
            change()
        assert refused.value.hint == "chmod u+w, or name another one"
    assert path.read_bytes() == before


def test_who_owns_a_file_that_another_user_may_not_write(tmp_path, monkeypatch):
    path = tmp_path / "a.h5"
    path.write_bytes(b"old")
    monkeypatch.setattr(save.os, "geteuid", lambda: path.stat().st_uid + 1)
    monkeypatch.setattr(save.os, "access", lambda _path, mode: not mode & os.W_OK)
    with pytest.raises(MapFileError, match="the file is read-only") as refused:
        save.check_target(path, overwrite=True)
    owner = pwd.getpwuid(path.stat().st_uid).pw_name
    assert refused.value.hint == (
        "it belongs to %s: save as that user, or name another one" % owner
    )


@pytest.mark.parametrize("name", ["a.h5", "b.h5"])
def test_a_read_only_disk_is_named(tmp_path, monkeypatch, name):
    (tmp_path / "a.h5").write_bytes(b"old")
    monkeypatch.setattr(save.os, "access", lambda _path, mode: not mode & os.W_OK)
    flags = type("Flags", (), {"f_flag": os.ST_RDONLY})
    monkeypatch.setattr(save.os, "statvfs", lambda _path: flags)
    with pytest.raises(MapFileError, match="the disk is read-only") as refused:
        save.check_target(tmp_path / name, overwrite=True)
    assert refused.value.code == "save" and "chmod" not in refused.value.hint


def test_without_proc_the_error_says_so(tmp_path, full_mesh, monkeypatch):
    monkeypatch.setattr(hdf5_stream, "_OPEN_FILES", str(tmp_path / "none"))
    with pytest.raises(MapFileError, match="mount") as refused:
        MapFile.write(tmp_path / "a.h5", full_mesh)
    assert refused.value.code == "save" and not os.listdir(tmp_path)


def test_a_pipe_is_not_replaced(tmp_path):
    os.mkfifo(tmp_path / "a.h5")
    with pytest.raises(MapFileError) as refused:
        save.save_file(tmp_path / "a.h5", b"new")
    assert refused.value.code == "not_regular"


def test_a_new_file_has_the_usual_mode(tmp_path):
    old = os.umask(0o027)
    try:
        save.save_file(tmp_path / "a.h5", b"new")
    finally:
        os.umask(old)
    assert stat.S_IMODE((tmp_path / "a.h5").stat().st_mode) == 0o640


def test_what_others_left_is_swept_but_not_what_is_in_use(tmp_path):
    stale = tmp_path / ".a.h5.0123456789abcdef.mesh_msgs_hdf5.tmp"
    used = tmp_path / ".a.h5.fedcba9876543210.mesh_msgs_hdf5.tmp"
    foreign = tmp_path / ".b.h5.0123456789abcdef.mesh_msgs_hdf5.tmp"
    for path in (stale, used, foreign):
        path.write_bytes(b"half")
    with open(used, "rb") as held:
        fcntl.flock(held, fcntl.LOCK_EX)
        save.save_file(tmp_path / "a.h5", b"new")
    assert sorted(os.listdir(tmp_path)) == sorted([used.name, foreign.name, "a.h5"])


def test_a_taken_temporary_name_is_avoided(tmp_path, monkeypatch):
    tokens = iter(["aa", "aa", "bb"])
    monkeypatch.setattr(save.secrets, "token_hex", lambda _n: next(tokens))
    taken = tmp_path / ".x.h5.aa.mesh_msgs_hdf5.tmp"
    taken.write_bytes(b"mine")
    save.save_file(tmp_path / "x.h5", b"new")  # sweeps it: nobody holds it
    taken.write_bytes(b"mine")
    with open(taken, "rb") as held:
        fcntl.flock(held, fcntl.LOCK_EX)
        tokens = iter(["aa", "bb"])
        save.save_file(tmp_path / "x.h5", b"newer")
    assert taken.read_bytes() == b"mine" and (tmp_path / "x.h5").read_bytes() == b"newer"


def test_a_long_name(tmp_path):
    name = "x" * 252 + ".h5"
    save.save_file(tmp_path / name, b"new")
    assert os.listdir(tmp_path) == [name]


@pytest.mark.parametrize(
    "place,code",
    [
        ("no/a.h5", "save"),
        ("folder", "directory"),
        ("a.h5/", "directory"),
        ("taken.h5/", "directory"),
        ("a\0.h5", "name"),
        ("taken.h5", "exists"),
    ],
)
def test_a_place_where_nothing_can_be_saved(tmp_path, full_mesh, place, code):
    (tmp_path / "folder").mkdir()
    (tmp_path / "taken.h5").write_bytes(b"old")
    with pytest.raises(MapFileError) as refused:
        MapFile.write(str(tmp_path) + "/" + place, full_mesh, overwrite=False)
    assert refused.value.code == code
    assert sorted(os.listdir(tmp_path)) == ["folder", "taken.h5"] and not os.listdir(
        tmp_path / "folder"
    )
    assert (tmp_path / "taken.h5").read_bytes() == b"old"


def test_a_lost_update_is_refused(tmp_path, full_mesh, monkeypatch):
    """Somebody else saves between reading and saving."""
    path = tmp_path / "a.h5"
    file = MapFile.write(path, full_mesh)
    other = MapFile(path)
    original = save.save_file

    def late(path, data, **more):
        monkeypatch.undo()
        other.write_layers({"theirs": (np.ones(40, "f4"), None)})
        original(path, data, **more)

    monkeypatch.setattr(map_saving, "save_file", late)
    with pytest.raises(MapFileError) as refused:
        file.write_layers({"ours": (np.ones(40, "f4"), None)})
    assert refused.value.code == "changed"
    assert "theirs" in file.layer_names() and "ours" not in file.layer_names()
    file.write_layers({"ours": (np.ones(40, "f4"), None)})
    assert {"ours", "theirs"} <= set(file.layer_names()) and os.listdir(tmp_path) == ["a.h5"]


def test_a_writer_waits_for_another_but_not_for_ever(tmp_path, monkeypatch):
    monkeypatch.setattr(save, "LOCK_SECONDS", 0)
    descriptor = os.open(tmp_path, os.O_RDONLY)
    fcntl.flock(descriptor, fcntl.LOCK_EX)
    with pytest.raises(MapFileError, match="another program has been saving"):
        save.save_file(tmp_path / "a.h5", b"new")
    os.close(descriptor)
    save.save_file(tmp_path / "a.h5", b"new")


def set_attribute(place, name, value):
    return lambda file: file[place].attrs.__setitem__(name, value)


def put(place, rows, value):
    return lambda file: file[place].__setitem__(rows, value)


# what may go wrong in building a file -> what the refusal names
DAMAGES = {
    "geometry": (put("mesh/channels/vertices", 5, 1), "/mesh/channels/vertices"),
    "new layer": (put("mesh/channels/new", 5, 1), "/mesh/channels/new"),
    "frame": (set_attribute("mesh", "frame_id", "x"), "/mesh"),
    "vector": (set_attribute("mesh", "uuid", np.arange(3)), "/mesh"),
    "attribute gone": (lambda file: file["mesh"].attrs.__delitem__("operator"), "/mesh"),
    "attribute more": (set_attribute("raw/scans", "more", 1), "/raw/scans (attributes)"),
    "root": (set_attribute("/", "made by", ["a", "b"]), "attribute made by"),
    "dataset gone": (lambda file: file.__delitem__("raw/scans/z"), "/raw/scans"),
    "dataset more": (lambda file: file.__setitem__("more", 1), "names more"),
    "chunks": (put("raw/scans/z", 4999, 1), "/raw/scans/z (values)"),
    "chunk more": (put("raw/scans/holes", 0, 7), "/raw/scans/holes (values)"),
    "contiguous": (put("raw/scans/grows", (2, 3), 2), "/raw/scans/grows (values)"),
    "strings": (put("raw/scans/text", 1, "c"), "/raw/scans/text (values)"),
    "ragged": (put("raw/scans/ragged", 1, [1]), "/raw/scans/ragged (values)"),
    "not a number": (put("mesh/clustersets/mine", 0, np.nan), "/mesh/clustersets/mine (values)"),
    "size": (lambda file: file["raw/scans/grows"].resize(4, 0), "/raw/scans/grows (shape)"),
    "label": (put("mesh/labels/tree/1", 0, 7), "/mesh/labels/tree/1"),
    "link": (
        lambda file: (
            file["mesh"].__delitem__("soft"),
            file["mesh"].__setitem__("soft", h5py.SoftLink("/x")),
        ),
        "/mesh/soft (link)",
    ),
    "hard link": (
        lambda file: (
            file["raw/scans"].__delitem__("again"),
            file["raw/scans"].copy("z", "again"),
        ),
        "/raw/scans/",
    ),
    "type": (
        lambda file: (file.__delitem__("raw/typed"), file.__setitem__("raw/typed", np.arange(3))),
        "/raw/typed (type)",
    ),
}


@pytest.mark.parametrize("name", DAMAGES)
def test_a_wrong_file_is_never_saved(tmp_path, rich_mesh, strange_data, monkeypatch, name):
    """What was built is read again before it takes the old file's place."""
    path = tmp_path / "a.h5"
    old = strange_data
    path.write_bytes(old)
    original = map_saving.building
    damage, words = DAMAGES[name]

    @contextlib.contextmanager
    def damaged(*arguments):
        with original(*arguments) as file:
            yield file
            damage(file)

    monkeypatch.setattr(map_saving, "building", damaged)
    with pytest.raises(MapFileError, match="does not read back") as refused:
        MapFile(path).update(Edit(vertex_costs={"new": np.zeros(40)}))
    assert refused.value.code == "save" and words in str(refused.value)
    if name in ("geometry", "frame", "label"):
        with pytest.raises(MapFileError, match="does not read back"):
            rich_mesh.vertex_costs["new"] = np.zeros(40)
            MapFile.write(path, rich_mesh)
    assert path.read_bytes() == old and os.listdir(tmp_path) == ["a.h5"]


WRITER = """
import sys
import numpy as np
from mesh_msgs_hdf5.map_file import MapFile
from mesh_msgs_hdf5.map_file.writing import map_saving
map_saving.MEMORY_BUDGET = int(sys.argv[2])
file = MapFile(sys.argv[1])
print("ready", flush=True)
for i in range(1, 10000):
    file.write_layers({"count": (np.full(file.vertex_count, i, np.float32), {"i": i})})
"""


@pytest.mark.parametrize("budget", [1 << 40, 0], ids=["in memory", "on disk"])
def test_a_kill_during_a_save_leaves_the_old_or_the_new_file(tmp_path, budget):
    path = tmp_path / "a.h5"
    rng = np.random.default_rng(1)
    vertices = rng.random((3000, 3)).astype("f4")
    faces = rng.integers(0, 3000, (5000, 3)).astype("u4")
    mesh = Mesh(vertices, faces, vertex_costs={"count": np.zeros(3000, "f4")})
    file = MapFile.write(path, mesh)
    seen = set()
    for attempt in range(8):
        writer = subprocess.Popen(
            [sys.executable, "-c", WRITER, str(path), str(budget)], stdout=subprocess.PIPE
        )
        before = save.stamp(path)
        assert writer.stdout.readline() == b"ready\n"
        while attempt % 2 and save.stamp(path) == before:
            assert writer.poll() is None
            time.sleep(0.001)
        time.sleep(0.03 + 0.011 * attempt)
        writer.send_signal(signal.SIGKILL)
        writer.wait()
        writer.stdout.close()
        costs = MapFile(path).read().vertex_costs["count"]
        assert (costs == costs[0]).all()
        assert MapFile(path).layer_parameters("count").get("i", 0) == costs[0]
        seen.add(costs[0])
    assert len(seen) > 1  # some of the kills came after a save
    file.write_layers({"count": (np.zeros(3000, "f4"), None)})
    assert os.listdir(tmp_path) == ["a.h5"]
