"""The label journal: every edit that returned is there again, whatever happened since."""
import base64
import errno
import fcntl
import json
import os
import random
import signal
import stat
import subprocess
import sys
import time
import zlib
from pathlib import Path

import numpy as np
import pytest

from mesh_msgs_hdf5.labels import journal_files, journal_lines, journal_reading
from mesh_msgs_hdf5.labels.journal import Journal
from mesh_msgs_hdf5.labels.journal_reading import OwnedError, is_owned, read_journal
from mesh_msgs_hdf5.model.errors import MapFileError
from mesh_msgs_hdf5.model.mesh import Label

UUID = "d5e2a1f0-0000-5000-8000-000000000001"
OTHER = "d5e2a1f0-0000-5000-8000-000000000002"
FACES = 5000


def label(*faces, color=None):
    return Label(np.array(faces, np.uint32), color)


def opened(path, uuid=UUID, faces=FACES, **more):
    return Journal(path, uuid, "mesh", faces, **more)


def plain(edits):
    return {
        text: None if edit is None else (edit.faces.tolist(), edit.color)
        for text, edit in edits.items()
    }


def replayed(path):
    return plain(read_journal(path, UUID, FACES).edits)


def written(path, *edits, close=True):
    journal = opened(path)
    for edit in edits:
        journal.append(*edit)
    if close:
        journal.close()
    return journal


THREE = (("tree_1", label(1, 2, 3)), ("tree_2", label(7, color=(0, 128, 255))), ("tree_1", None))
REPLAYED = {"tree_2": ([7], (0, 128, 255)), "tree_1": None}


@pytest.fixture
def path(tmp_path):
    return str(tmp_path / "a.h5.journal")


@pytest.mark.parametrize("count", [0, 1, 2, 64, 65, 2000, FACES])
@pytest.mark.parametrize("color", [None, (0, 0, 0), (255, 128, 1)])
def test_an_entry_says_the_same_after_the_line(count, color):
    rng = np.random.default_rng(count)
    faces = np.sort(rng.choice(FACES, count, replace=False)).astype(np.uint32)
    line = journal_lines.encoded(journal_lines.edit_entry("Baum ä_1", Label(faces, color)))
    assert line.endswith(b"\n") and line.count(b"\n") == 1 and line.isascii()
    text, found = journal_lines.edit_of(journal_lines.decoded(line[:-1]), FACES)
    assert (text, found.color) == ("Baum ä_1", color) and found.faces.dtype == np.uint32
    np.testing.assert_array_equal(found.faces, faces)


def test_the_format_of_a_line_as_the_documentation_has_it():
    entry = journal_lines.edit_entry("tree_1", label(1, 2, 3, color=(0, 128, 0)))
    line = journal_lines.encoded(entry)
    found = json.loads(line)
    rest = line[:1] + line[line.index(b",") + 1 : -1]
    assert found.pop("crc") == "%08x" % zlib.crc32(rest)
    assert found == {"set": "tree_1", "color": [0, 128, 0], "count": 3, "u4": "AQAAAAIAAAADAAAA"}
    assert line.decode() in journal_lines.__doc__ + "\n"
    faces = np.arange(100, 400, 3, dtype="<u4")
    packed = json.loads(journal_lines.encoded(journal_lines.edit_entry("x", Label(faces))))["d4z"]
    differences = np.frombuffer(zlib.decompress(base64.b64decode(packed)), "<u4")
    np.testing.assert_array_equal(np.cumsum(differences), faces)


def test_any_changed_byte_of_a_line_is_seen():
    line = journal_lines.encoded(journal_lines.edit_entry(*THREE[1]))[:-1]
    assert journal_lines.decoded(line) is not None
    for place in range(len(line)):
        for bit in range(8):
            bad = bytearray(line)
            bad[place] ^= 1 << bit
            assert journal_lines.decoded(bytes(bad)) is None


def entry(**more):
    return {"set": "a_1", "color": None, "count": 1, "u4": "AQAAAA==", **more}


@pytest.mark.parametrize(
    "wrong",
    [
        entry(set="a/b"),
        entry(set=""),
        entry(set=5),
        entry(count=2),
        entry(count=-1),
        entry(count="1"),
        entry(count=FACES + 1),
        entry(u4="!!!!"),
        entry(u4="AQAA"),
        entry(u4=7),
        entry(u4=base64.b64encode(np.uint32([FACES]).tobytes()).decode()),
        entry(count=2, u4=base64.b64encode(np.uint32([3, 3]).tobytes()).decode()),
        entry(color=[1, 2]),
        entry(color=[1, 2, 256]),
        entry(color=[1, 2, True]),
        entry(color="red"),
        {"set": "a_1", "color": None, "count": 1, "d4z": "AQAAAA=="},
        {"set": "a_1", "color": None, "count": 1},
        {"set": "a_1", "count": 1, "u4": "AQAAAA=="},
        {
            "set": "a_1",
            "color": None,
            "count": 1,
            "d4z": base64.b64encode(zlib.compress(bytes(10**8))).decode(),
        },
        {"delete": ".."},
        {"unknown": 1},
        {},
    ],
)
def test_an_entry_that_is_no_edit_is_none(wrong):
    assert journal_lines.edit_of(entry(), FACES)[0] == "a_1"
    assert journal_lines.edit_of(wrong, FACES) is None


def test_edits_are_replayed_in_order(path):
    journal = written(path, *THREE, close=False)
    assert replayed(path) == REPLAYED
    journal.close()
    assert plain(opened(path).content.edits) == REPLAYED


def test_every_edit_is_synced_before_it_returns(path, monkeypatch):
    calls = []

    def noted(name, original):
        def call(descriptor, *arguments):
            kind = "folder" if stat.S_ISDIR(os.fstat(descriptor).st_mode) else "file"
            calls.append("%s %s" % (name, kind))
            return original(descriptor, *arguments)

        return call

    for name in ("write", "fsync"):
        monkeypatch.setattr(journal_files.os, name, noted(name, getattr(os, name)))
    journal = opened(path)
    assert "fsync folder" in calls and calls[-2:] == ["write file", "fsync file"]
    for edit in THREE:
        calls.clear()
        journal.append(*edit)
        assert calls == ["write file", "fsync file"]
    calls.clear()
    journal.rewrite(dict(THREE))
    assert calls[-2:] == ["fsync file", "fsync folder"]


def test_a_journal_without_edits_leaves_no_file(path):
    opened(path).close(remove=True)
    assert not os.path.exists(path)


def test_the_owner_is_locked_in_and_named(path):
    first = opened(path, owner={"node": "/map_server", "pid": 42, "host": "robot"})
    assert is_owned(path)
    with pytest.raises(OwnedError) as refused:
        opened(path)
    assert refused.value.code == "owned" and refused.value.owner["pid"] == 42
    assert "edited by /map_server (pid 42, host robot)" in str(refused.value)
    first.close()
    assert not is_owned(path)
    opened(path).close()


def test_a_short_look_does_not_keep_the_owner_out(path, monkeypatch):
    monkeypatch.setattr("mesh_msgs_hdf5.labels.journal._WAIT", 60)  # however slow the machine
    written(path, *THREE)
    with open(path, "rb") as stream:
        fcntl.flock(stream, fcntl.LOCK_SH)
        looker = subprocess.Popen(
            [sys.executable, "-c", "import time; time.sleep(0.1)"], pass_fds=[stream.fileno()]
        )
    opened(path).close()  # the child holds the lock for a moment
    looker.wait()


def test_who_waited_for_a_removed_journal_makes_a_new_one(path, monkeypatch):
    """Between opening and locking, the owner ends and removes it."""
    first = opened(path)
    original, calls = fcntl.flock, []

    def flock(descriptor, kind):
        if not calls:
            calls.append(1)
            first.close(remove=True)
        return original(descriptor, kind)

    monkeypatch.setattr("mesh_msgs_hdf5.labels.journal_reading.fcntl.flock", flock)
    second = opened(path)
    assert second.is_in_place()
    second.append(*THREE[0])
    assert replayed(path) == {"tree_1": ([1, 2, 3], None)}


@pytest.mark.parametrize("error", [errno.ENOLCK, errno.EOPNOTSUPP])
def test_a_disk_without_locks_is_one_note(path, monkeypatch, error):
    def flock(_descriptor, _kind):
        raise OSError(error, os.strerror(error))

    monkeypatch.setattr("mesh_msgs_hdf5.labels.journal_reading.fcntl.flock", flock)
    journal = written(path, *THREE, close=False)
    assert len(journal.notes) == 1 and "no locks" in journal.notes[0]
    assert replayed(path) == REPLAYED and not is_owned(path)
    journal.rewrite({"tree_2": label(7, color=(0, 128, 255)), "tree_1": None})
    assert replayed(path) == REPLAYED


@pytest.mark.parametrize("uuid", [OTHER, None])
def test_a_journal_of_another_mesh_is_refused_and_stays(path, uuid):
    written(path, *THREE)
    if uuid is None:  # its first lines are damaged
        lines = Path(path).read_bytes().split(b"\n")
        lines[:2] = b"x", b"y"
        Path(path).write_bytes(b"\n".join(lines))
    before = Path(path).read_bytes()
    words = "damaged: of which mesh" if uuid is None else "of another mesh"
    for call in (lambda: opened(path, OTHER), lambda: read_journal(path, OTHER, FACES)):
        with pytest.raises(MapFileError, match=words) as refused:
            call()
        assert refused.value.code == "journal" and "move this journal away" in str(refused.value)
    assert Path(path).read_bytes() == before and not is_owned(path)


def test_a_journal_of_another_mesh_without_edits_is_no_loss(path):
    written(path)
    journal = opened(path, OTHER)
    journal.append(*THREE[0])
    assert plain(read_journal(path, OTHER, FACES).edits) == {"tree_1": ([1, 2, 3], None)}


def test_a_newer_journal_is_refused(path):
    head = dict(journal_lines.header(UUID, "mesh", FACES), version=2)
    Path(path).write_bytes(journal_lines.encoded(head))
    with pytest.raises(MapFileError, match="newer Mesh Tools") as refused:
        opened(path)
    assert refused.value.code == "version"


def test_torn_at_any_byte_the_edits_before_are_there(path):
    written(path, *THREE)
    whole = Path(path).read_bytes()
    ends = [i + 1 for i, byte in enumerate(whole) if byte == 10]  # header, owner, three edits
    for size in range(len(whole) + 1):
        Path(path).write_bytes(whole[:size])
        complete = sum(end <= size + 1 for end in ends)  # the newline itself may be missing
        expected = {}
        for text, edit in THREE[: max(0, complete - 2)]:
            expected[text] = edit
        journal = opened(path)
        assert plain(journal.content.edits) == plain(expected)
        torn = size not in ends and size + 1 not in ends and size > 0
        assert len(journal.notes) == torn and (not torn or "not finished" in journal.notes[0])
        journal.append("new_1", label(5))
        journal.close()
        assert replayed(path) == {**plain(expected), "new_1": ([5], None)}
        lines = Path(path).read_bytes().split(b"\n")
        assert all(map(journal_lines.decoded, lines[:-1])) and lines[-1] == b""
    assert os.listdir(os.path.dirname(path)) == ["a.h5.journal"]


def test_zeros_after_a_power_failure_are_a_torn_line(path):
    written(path, *THREE)
    with open(path, "ab") as stream:
        stream.write(bytes(4096))
    journal = opened(path)
    assert plain(journal.content.edits) == REPLAYED and "4096 bytes" in journal.notes[0]


@pytest.mark.parametrize("damage", ["bit", "newline", "text"])
def test_damage_in_the_middle_costs_that_line_alone(path, damage):
    edits = [("a_%d" % i, label(i, i + 1)) for i in range(10)]
    written(path, *edits)
    lines = Path(path).read_bytes().split(b"\n")
    number = 2 + 4
    bad = [lines[number]]
    if damage == "bit":
        lines[number] = bad[0] = lines[number].replace(b"count", b"coumt")
    elif damage == "text":
        bad = [b"no line at all"]
        lines.insert(number, bad[0])
    else:  # two lines have become one, of which the second is whole
        bad = [lines[number][:-3]]
        lines[number : number + 2] = [bad[0] + lines[number + 1]]
    Path(path).write_bytes(b"\n".join(lines))
    expected = dict(edits)
    if damage != "text":
        del expected["a_4"]
    assert replayed(path) == plain(expected)
    for _ in range(2):  # kept once, however often it is opened
        journal = opened(path)
        assert plain(journal.content.edits) == plain(expected)
        assert journal.notes == [
            "1 damaged lines are not replayed; they are kept in %s.damaged" % path
        ]
        journal.close()
        assert Path(path + ".damaged").read_bytes() == bad[0] + b"\n"
    journal = opened(path)
    journal.clear()
    journal.close(remove=True)
    assert os.listdir(os.path.dirname(path)) == ["a.h5.journal.damaged"]


def test_a_line_without_end_is_not_read_into_memory(path, monkeypatch):
    monkeypatch.setattr(journal_reading, "_MAX_LINE", 300)
    written(path, ("a_1", label(1)))
    with open(path, "ab") as stream:
        stream.write(b"x" * 1000 + b"\n")
    written(path, ("a_2", label(2)))
    assert set(replayed(path)) == {"a_1", "a_2"}
    assert b"x" * 300 in Path(path + ".damaged").read_bytes()


def test_clear_and_rewrite(path):
    journal = written(path, *THREE, close=False)
    journal.rewrite({"tree_2": label(8)})
    assert replayed(path) == {"tree_2": ([8], None)} and is_owned(path)
    journal.append("tree_3", label(9))
    journal.clear()
    assert replayed(path) == {} and is_owned(path)
    journal.append(*THREE[0])
    assert replayed(path) == {"tree_1": ([1, 2, 3], None)}
    assert os.listdir(os.path.dirname(path)) == ["a.h5.journal"]


def test_links_and_what_is_no_file_are_refused(tmp_path, path):
    secret = tmp_path / "secret"
    secret.write_bytes(b"mine")
    os.symlink(secret, path)
    for call in (lambda: opened(path), lambda: read_journal(path, UUID, FACES)):
        with pytest.raises(MapFileError) as refused:
            call()
        assert refused.value.code == "link"
    os.unlink(path)
    os.mkfifo(path)
    with pytest.raises(MapFileError) as refused:
        opened(path)
    assert refused.value.code == "not_regular" and secret.read_bytes() == b"mine"


@pytest.mark.parametrize("mode,expected", [(0o644, 0o644), (0o600, 0o600), (0o775, 0o664)])
def test_it_has_the_permissions_of_the_map(tmp_path, path, mode, expected):
    (tmp_path / "a.h5").write_bytes(b"map")
    (tmp_path / "a.h5").chmod(mode)
    journal = opened(path, like=tmp_path / "a.h5")
    assert stat.S_IMODE(os.stat(path).st_mode) == expected
    journal.rewrite({})
    assert stat.S_IMODE(os.stat(path).st_mode) == expected


@pytest.mark.skipif(os.geteuid() != 0, reason="only root may give files away")
def test_it_belongs_to_the_owner_of_the_map(tmp_path, path):
    (tmp_path / "a.h5").write_bytes(b"map")
    os.chown(tmp_path / "a.h5", 12345, 23456)
    journal = opened(path, like=tmp_path / "a.h5")
    journal.rewrite({})
    assert (os.stat(path).st_uid, os.stat(path).st_gid) == (12345, 23456)


CALLS = ("open", "write", "fsync", "ftruncate", "replace", "fchmod")


class Faults:
    """Lets the k-th call to the system fail, after writing half if it is a write.

    error: 0 ends the process there.
    """

    def __init__(self, monkeypatch, failing, error, lasting=False):
        self.count, self.failing, self.error, self.lasting = 0, failing, error, lasting
        for name in CALLS:
            monkeypatch.setattr(
                journal_files.os, name, self._wrapped(name, getattr(os, name)), raising=True
            )

    def _wrapped(self, name, original):
        def call(*arguments, **more):
            number, self.count = self.count, self.count + 1
            if number == self.failing or self.lasting and number > self.failing >= 0:
                if name == "write" and len(arguments[1]) > 1:
                    original(arguments[0], arguments[1][: len(arguments[1]) // 2])
                if not self.error:
                    os._exit(7)
                raise OSError(self.error, os.strerror(self.error))
            return original(*arguments, **more)

        return call


def session(path, tell):
    """Some edits; tell is called with (number, whether it was stored) of each that has returned."""
    journal = opened(path, like=path)
    done = {}
    try:
        for number, (text, edit) in enumerate(EDITS):
            try:
                journal.append(text, edit)
                done[text] = edit
                tell(number, True)
            except MapFileError as refused:
                assert refused.code == "save" and "nothing was changed" in str(refused)
                tell(number, False)
            if number == 5:
                journal.rewrite(done)
    finally:
        os.close(journal._descriptor)  # as a kill does


def state_of(numbers):
    return plain(dict(EDITS[number] for number in numbers))


EDITS = [("a_%d" % (i % 7), label(i, i + 1) if i % 3 else None) for i in range(12)]


def calls_of_a_session(path, monkeypatch):
    with monkeypatch.context() as patch:
        faults = Faults(patch, -1, errno.EIO)
        session(path, lambda *_: None)
    os.unlink(path)
    return faults.count


@pytest.mark.parametrize("error", [errno.EIO, errno.ENOSPC])
@pytest.mark.parametrize("lasting", [False, True])
def test_whichever_call_fails_what_returned_is_there(path, monkeypatch, error, lasting):
    """Each call to the system fails in turn, alone or with all that follow."""
    total = calls_of_a_session(path, monkeypatch)
    assert total > 40
    failed = 0
    for k in range(total):
        stored, refused = [], []
        with monkeypatch.context() as patch:
            Faults(patch, k, error, lasting)
            try:
                session(path, lambda number, good: (stored if good else refused).append(number))
            except MapFileError as failure:
                assert failure.code == "save" and os.strerror(error) in str(failure)
                failed += 1
        possible = [state_of(stored)]
        if lasting and refused:  # neither synced nor cut off
            possible.append(state_of(stored + refused[:1]))
        assert plain(opened(path).content.edits) in possible
        assert os.listdir(os.path.dirname(path)) == ["a.h5.journal"]
        os.unlink(path)
    assert failed


def test_a_kill_at_any_call_loses_no_edit_that_returned(path, monkeypatch):
    ends = []
    for k in range(calls_of_a_session(path, monkeypatch)):
        read_end, write_end = os.pipe()
        write = os.write
        child = os.fork()
        if not child:
            Faults(monkeypatch, k, 0)
            session(path, lambda number, _stored: write(write_end, bytes([number])))
            os._exit(0)
        os.close(write_end)
        with open(read_end, "rb") as stream:
            returned = list(stream.read())
        assert os.WEXITSTATUS(os.waitpid(child, 0)[1]) == 7
        found = plain(opened(path).content.edits)
        assert found in (state_of(returned), state_of(range(len(returned) + 1)))
        ends.append(len(returned))
        os.unlink(path)
        for name in os.listdir(os.path.dirname(path)):  # what save.py sweeps
            assert name.endswith(".mesh_msgs_hdf5.tmp")
            os.unlink(os.path.join(os.path.dirname(path), name))
    assert set(ends) == set(range(len(EDITS) + 1)) - {len(EDITS)}


def test_after_a_failure_the_next_edit_works(path, monkeypatch):
    journal = written(path, THREE[0], close=False)
    size = journal.size
    with monkeypatch.context() as patch:
        Faults(patch, 0, errno.ENOSPC, True)
        for _ in range(3):
            with pytest.raises(MapFileError, match="make room on the disk"):
                journal.append(*THREE[1])
    assert journal.size > size  # half a line, which could not be cut off
    journal.append(*THREE[1])
    journal.append(*THREE[2])
    assert replayed(path) == REPLAYED
    assert b"\n\n" not in Path(path).read_bytes() and opened_notes(path) == []


def opened_notes(path):
    content = read_journal(path, UUID, FACES)
    return content.damaged + ([content.torn] if content.torn else [])


def test_a_full_disk_at_the_start_leaves_nothing(path, monkeypatch):
    with monkeypatch.context() as patch:
        Faults(patch, 3, errno.ENOSPC, True)
        with pytest.raises(MapFileError, match="make room") as refused:
            opened(path)
    assert refused.value.code == "save" and not os.path.exists(path)


WRITER = """
import sys
import numpy as np
from mesh_msgs_hdf5.labels.journal import Journal
from mesh_msgs_hdf5.model.mesh import Label
journal = Journal(sys.argv[1], sys.argv[2], "mesh", 5000)
number = int(sys.argv[3])
while True:
    number += 1
    faces = np.arange(number % 50, number % 50 + 1 + 37 * (number % 100), dtype=np.uint32)
    journal.append("a_%d" % (number % 5), Label(faces, (number % 256, 0, 0)))
    print(number, flush=True)
    if number % 40 == 0:
        journal.rewrite({"a_%d" % (number % 5): Label(faces, (number % 256, 0, 0))})
        print(-number, flush=True)
"""


def expected_of(number):
    first = number % 50
    return list(range(first, first + 1 + 37 * (number % 100))), (number % 256, 0, 0)


def test_a_kill_at_any_time_loses_no_edit_that_returned(path):
    rng = random.Random(5)
    start, state = 0, {}
    for _ in range(12):
        writer = subprocess.Popen(
            [sys.executable, "-c", WRITER, path, UUID, str(start)], stdout=subprocess.PIPE
        )
        first = writer.stdout.readline()
        time.sleep(0.002 + 0.05 * rng.random())
        writer.send_signal(signal.SIGKILL)
        numbers = [int(line) for line in (first + writer.stdout.read()).splitlines()]
        writer.wait()
        writer.stdout.close()
        for number in numbers:
            if number < 0:  # the others were left out
                state = {"a_%d" % (-number % 5): -number}
            else:
                state["a_%d" % (number % 5)] = number
        last = numbers[-1] if numbers[-1] > 0 else -numbers[-1]
        found = replayed(path)
        sure = {text: expected_of(number) for text, number in state.items()}
        maybe = dict(sure)  # one more may have been written without having returned
        maybe["a_%d" % ((last + 1) % 5)] = expected_of(last + 1)
        alone = {"a_%d" % (last % 5): expected_of(last)}  # written anew, not yet said
        assert found in (sure, maybe) or last % 40 == 0 and found == alone
        start = last + (found == maybe and found != sure)
        state = {text: start - (start - int(text[2:])) % 5 for text in found}
        opened(path).close()  # not owned by the killed process any more
    assert start > 12
