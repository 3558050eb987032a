"""Map files read in a process of their own: the same answers, and each accident is one error."""
import contextlib
import gc
import inspect
import os
import resource
import signal
import subprocess
import sys
import threading
import time

import h5py
import numpy as np
import pytest
from every_member import ARGUMENTS, WRITING, public_names
from mesh_msgs.testing import wait_until

from mesh_msgs_hdf5 import isolation
from mesh_msgs_hdf5.checks.check import identical
from mesh_msgs_hdf5.isolation import IsolatedMapFile, isolated, isolated_map_file
from mesh_msgs_hdf5.map_file import MapFile
from mesh_msgs_hdf5.map_file.map_file import parts_of
from mesh_msgs_hdf5.model.errors import MapFileError
from mesh_msgs_hdf5.processes.zygote import OUT_OF_MEMORY, ZYGOTE, prepare


@pytest.fixture
def victim(monkeypatch):
    """A function that calls one of victims.py in a process of its own."""

    def call(name, path="/a/map.h5", *arguments, **limits):
        monkeypatch.setitem(isolation.FUNCTIONS, name, ("victims", name))
        return isolated(name, path, *arguments, **limits)

    return call


def zygote_pid():
    """The id of the process that forks the others; None before the first call."""
    process = ZYGOTE._process
    return process.pid if process else None


def same(one, other):
    """True if two values are the same, arrays by type and bytes."""
    if isinstance(one, np.ndarray) or isinstance(other, np.ndarray):
        return type(one) is type(other) and identical(one, other)
    if isinstance(one, dict):
        return list(one) == list(other) and all(same(one[key], other[key]) for key in one)
    if hasattr(one, "__dataclass_fields__"):
        return type(one) is type(other) and same(vars(one), vars(other))
    return type(one) is type(other) and one == other


def test_it_has_all_that_a_map_file_has(tmp_path, rich_mesh):
    path = tmp_path / "a.h5"
    MapFile.write(path, rich_mesh)
    direct, apart = MapFile(path), IsolatedMapFile(path)
    names = public_names(direct)
    assert WRITING | set(ARGUMENTS) | {"vertices", "read", "path", "parts"} <= set(names)
    for name in names:
        expected, value = getattr(direct, name), getattr(apart, name)
        if name in WRITING:
            assert callable(value)
        elif inspect.ismethod(expected):
            assert value.__doc__ == expected.__doc__
            assert inspect.signature(value) == inspect.signature(expected)
            arguments = ARGUMENTS.get(name, [])
            assert same(value(*arguments), expected(*arguments)), name
        else:
            assert same(value, expected), name


def test_arrays_are_ones_own(tmp_path, full_mesh):
    path = tmp_path / "a.h5"
    MapFile.write(path, full_mesh)
    for array in (IsolatedMapFile(path).vertices, IsolatedMapFile(path).read().faces):
        assert array.flags.writeable and array.flags.c_contiguous and array.flags.aligned
        array[0] = 0


def test_the_errors_are_the_same(tmp_path, full_mesh):
    whole = tmp_path / "whole.h5"
    MapFile.write(whole, full_mesh)
    (tmp_path / "empty.h5").write_bytes(b"")
    (tmp_path / "cut.h5").write_bytes(whole.read_bytes()[:3000])
    (tmp_path / "nan.h5").write_bytes(whole.read_bytes())
    with h5py.File(tmp_path / "nan.h5", "r+") as file:
        file["mesh/channels/vertices"][7] = np.nan
    for name in ("missing.h5", "empty.h5", "cut.h5", "nan.h5", "nul\0.h5", b"\xff.h5", ""):
        path = os.path.join(os.fsencode(tmp_path), os.fsencode(name))
        with pytest.raises(MapFileError) as direct:
            MapFile(path).read()
        with pytest.raises(MapFileError) as apart:
            IsolatedMapFile(path).read()
        assert apart.value.args[:1] == direct.value.args[:1]
        assert str(apart.value) == str(direct.value)
    for call in (lambda file: file.vertex_costs("x"), lambda file: file.write_layers({"a/b": ()})):
        with pytest.raises((MapFileError, ValueError)) as direct:
            call(MapFile(whole))
        if direct.type is MapFileError:
            with pytest.raises(MapFileError) as apart:
                call(IsolatedMapFile(whole))
            assert str(apart.value) == str(direct.value)
    with pytest.raises(TypeError):
        IsolatedMapFile(whole).vertex_costs()
    with pytest.raises(AttributeError):
        IsolatedMapFile(whole).no_such_thing


def test_a_mesh_that_is_replaced_between_calls_is_noticed(tmp_path, full_mesh):
    path = tmp_path / "a.h5"
    MapFile.write(path, full_mesh)
    file = IsolatedMapFile(path)
    MapFile(path).write_layers({"new": (np.ones(40, np.float32), None)})
    assert "new" in file.layer_names()  # the same mesh with one layer more
    full_mesh.vertices = full_mesh.vertices + 1
    MapFile.write(path, full_mesh)
    with pytest.raises(MapFileError) as refused:
        file.faces
    assert refused.value.code == "changed"
    assert same(IsolatedMapFile(path).vertices, full_mesh.vertices)


def test_saving_through_it(tmp_path, full_mesh):
    path = tmp_path / "a.h5"
    file = IsolatedMapFile.write(path, full_mesh)
    file.write_layers({"new": (np.ones(40, np.float32), {"radius": 0.5})})
    full_mesh.vertex_costs["new"] = np.ones(40, np.float32)
    assert file.layer_parameters("new") == {"radius": 0.5}
    found = MapFile(path).read().vertex_costs
    assert all(same(found[name], full_mesh.vertex_costs[name]) for name in found)
    assert sorted(found) == sorted(full_mesh.vertex_costs)


def test_closing(tmp_path, full_mesh):
    path = tmp_path / "a.h5"
    MapFile.write(path, full_mesh)
    with IsolatedMapFile(path) as file:
        assert file.vertex_count == 40
    with pytest.raises(ValueError, match="closed"):
        file.vertices


def test_relative_paths_are_those_of_the_moment(tmp_path, full_mesh, monkeypatch, victim):
    victim("echo")
    monkeypatch.chdir(tmp_path)
    MapFile.write("a.h5", full_mesh)
    assert IsolatedMapFile("a.h5").path == "a.h5"


def test_arguments_and_results_arrive(victim):
    values = (None, True, 1.5, float("inf"), "ä\udcff", (1, "2"), {"a": {7: [np.int64(3)]}})
    expected = ["/ä", None, True, 1.5, float("inf"), "ä\udcff", (1, "2"), {"a": {7: [3]}}, {"k": 1}]
    assert victim("echo", "/ä", *values, k=1) == expected
    with pytest.raises(KeyError):
        isolated("os.system", "/a")


@pytest.mark.parametrize(
    "how,code,words",
    [
        ("null", "crashed", "ended with SIGSEGV"),
        ("abort", "crashed", "ended with SIGABRT"),
        ("SIGBUS", "crashed", "ended with SIGBUS"),
        ("SIGTERM", "crashed", "ended with SIGTERM"),
        ("SIGRTMIN", "crashed", "ended with SIGRTMIN"),
        ("SIGKILL", "size", "out of memory"),
        ("3", "crashed", "exit code 3"),
        (str(OUT_OF_MEMORY), "size", "more memory than"),
    ],
)
def test_a_crash_is_an_error_like_any(victim, how, code, words):
    with pytest.raises(MapFileError) as refused:
        victim("crash", "/a/map.h5", how)
    assert refused.value.code == code and words in refused.value.message and refused.value.hint
    assert refused.value.path == "/a/map.h5" and "\n" not in str(refused.value)
    assert victim("echo", "/b") == ["/b", {}]


def test_memory_is_bounded(victim):
    assert victim("swallow", "/a", 50 << 20, memory_limit=150 << 20) == 50 << 20
    with pytest.raises(MapFileError) as refused:
        victim("swallow", "/a", 200 << 20, memory_limit=150 << 20)
    assert refused.value.code == "size" and "the 150 MiB allowed" in refused.value.message
    with pytest.raises(MapFileError) as refused:
        victim("compare", "/a", 100 << 20, memory_limit=150 << 20)
    assert refused.value.code == "size"
    with pytest.raises(MapFileError) as refused:
        victim("fail_for_memory", "/a")
    assert refused.value.code == "size"
    with pytest.raises(MapFileError) as refused:  # of the answer, too
        victim("answer_with", "/a", "big", memory_limit=30 << 20)
    assert refused.value.code == "size"


def test_time_is_bounded(victim, tmp_path):
    with pytest.raises(MapFileError) as refused:
        victim("sleep", tmp_path / "a", 1000, timeout=0.5)
    assert refused.value.code == "timeout" and "0.5 seconds" in refused.value.message
    assert gone(int((tmp_path / "a").read_text()))


@pytest.mark.parametrize("kind", ["key", "recursion", "system"])
def test_what_nobody_has_thought_of_is_an_error_too(victim, kind):
    with pytest.raises(MapFileError) as refused:
        victim("fail", "/a", kind)
    assert refused.value.code == "crashed" and "victims.py" in refused.value.message
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize("kind", ["object", "deep"])
def test_an_answer_that_cannot_be_carried(victim, kind):
    with pytest.raises(MapFileError) as refused:
        victim("answer_with", "/a", kind)
    assert refused.value.code == "crashed" and "WireError" in refused.value.message


@pytest.mark.parametrize(
    "reply", [None, 3, [], ["done"], ["done", 1, 2], ["refused", "a"], ["refused", 1, 2, 3, 4]]
)
def test_a_reply_that_is_none(victim, reply):
    with pytest.raises(MapFileError) as refused:
        victim("speak", "/a", reply)
    assert refused.value.code == "crashed" and "no proper answer" in refused.value.message


@pytest.mark.parametrize("raw", ["", "MESH", "MESH\xff\xff\xff\xff", "x" * 100, "MESH\2\0\0\0{]"])
def test_bytes_that_are_no_reply(victim, raw):
    with pytest.raises(MapFileError) as refused:
        victim("shout", "/a", raw)
    assert refused.value.code == "crashed" and "no proper answer" in refused.value.message


@pytest.mark.parametrize("state", [[1], {"vertex_count": 1}])
def test_an_answer_of_another_type_is_not_believed(tmp_path, full_mesh, monkeypatch, state):
    MapFile.write(tmp_path / "a.h5", full_mesh)
    file = IsolatedMapFile(tmp_path / "a.h5")
    monkeypatch.setattr(isolated_map_file, "_USE_MAP_FILE", ("victims", "speak"))
    monkeypatch.setattr(isolated_map_file._Reader, "call", lambda *_: ("vertices", state))
    with pytest.raises(MapFileError) as refused:
        file.vertices
    assert refused.value.code == "crashed" and "no proper answer" in refused.value.message


def test_threads_at_once(tmp_path, full_mesh, victim):
    path = tmp_path / "a.h5"
    MapFile.write(path, full_mesh)
    file, errors = IsolatedMapFile(path), []

    def work(number):
        for i in range(6):
            try:
                if number % 3:
                    assert same(file.vertices, full_mesh.vertices)
                    assert same(file.read().faces, full_mesh.faces)
                else:
                    with pytest.raises(MapFileError):
                        victim("crash", "/a", "SIGSEGV")
            except BaseException as error:
                errors.append(error)

    threads = [threading.Thread(target=work, args=(number,)) for number in range(6)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert not errors


def test_nothing_is_left_behind(victim, tmp_path):
    victim("echo")
    before = sorted(os.listdir("/proc/self/fd"))
    for _ in range(3):
        with pytest.raises(MapFileError):
            victim("crash", "/a", "abort")
        with pytest.raises(MapFileError):
            victim("sleep", tmp_path / "a", 1000, timeout=0.3)
        assert victim("echo", "/a") == ["/a", {}]
    assert sorted(os.listdir("/proc/self/fd")) == before
    the_spare_process()  # and no zombies either


def test_the_zygote_is_small_and_apart(victim):
    pid, parent, session, threads = victim("where")
    assert parent == zygote_pid() == session and threads == 1
    assert len(os.listdir("/proc/%d/task" % parent)) == 1
    assert victim("where")[0] != pid and zygote_pid() == parent


def test_what_is_prepared_is_used(victim):
    ZYGOTE.stop()
    assert zygote_pid() is None
    prepare()
    prepared = zygote_pid()
    prepare()
    assert victim("echo", "/a") == ["/a", {}] and zygote_pid() == prepared is not None


def test_preparing_waits_for_no_large_import():
    program = (
        "import sys\n"
        "sys.path[:] = %r\n"
        "from mesh_msgs_hdf5.processes.zygote import prepare\n"
        "print(sorted({'numpy', 'h5py', 'rospy', 'yaml'} & set(sys.modules)))\n"
    )
    said = subprocess.check_output([sys.executable, "-I", "-c", program % sys.path], text=True)
    assert said.strip() == "[]"


def test_preparing_may_fail(monkeypatch):
    def no_process():
        raise OSError("no process")

    monkeypatch.setattr(ZYGOTE, "start", no_process)
    prepare()


def test_the_zygote_is_started_anew(victim):
    victim("echo")
    old = zygote_pid()
    os.kill(old, signal.SIGKILL)
    os.waitid(os.P_PID, old, os.WEXITED | os.WNOWAIT)
    assert victim("echo", "/a") == ["/a", {}] and zygote_pid() != old


def test_a_kept_process_that_has_ended_is_replaced(tmp_path, full_mesh):
    path = tmp_path / "a.h5"
    MapFile.write(path, full_mesh)
    with IsolatedMapFile(path) as file:
        both = wait_until(
            lambda: len(children_of(zygote_pid())) == 2 and children_of(zygote_pid()),
            "the kept one, and a spare one",
        )
        for pid in both:
            os.kill(pid, signal.SIGKILL)
        wait_until(lambda: not children_of(zygote_pid()), "their end")
        assert same(file.vertices, full_mesh.vertices)


def test_a_kept_process_is_not_shared_with_a_forked_one(tmp_path, full_mesh):
    path = tmp_path / "a.h5"
    MapFile.write(path, full_mesh)
    with IsolatedMapFile(path) as file:
        pid = os.fork()
        if not pid:
            code = 1
            try:
                code = 0 if same(file.vertices, full_mesh.vertices) else 2
                ZYGOTE.stop()
            finally:
                os._exit(code)
        assert os.waitpid(pid, 0)[1] == 0
        assert same(file.faces, full_mesh.faces)


def test_what_is_not_used_any_more_leaves_no_process(tmp_path, full_mesh):
    path = tmp_path / "a.h5"
    MapFile.write(path, full_mesh)
    file = IsolatedMapFile(path)
    wait_until(lambda: len(children_of(zygote_pid())) == 2, "one for the first call, one spare")
    del file
    the_spare_process()


def the_spare_process(before=None):
    """The id of the process that is ready for the next request, when none but it is left.

    before: the id of who has answered the last one.
    """
    found = []

    def is_alone():
        found[:] = children_of(zygote_pid())
        return len(found) == 1 and found != [before]

    wait_until(is_alone, "nothing but a spare process")
    return found[0]


def test_a_request_is_answered_by_the_spare_process(victim):
    last = victim("where")[0]
    for _ in range(3):
        spare = the_spare_process(last)  # each answers one request
        last = victim("where")[0]
        assert last == spare


def test_without_a_spare_process_the_next_request_makes_one(victim):
    last = victim("where")[0]
    for _ in range(2):
        os.kill(the_spare_process(last), signal.SIGKILL)
        wait_until(lambda: not children_of(zygote_pid()), "its end")
        last, parent, *_ = victim("where")
        assert parent == zygote_pid()
    the_spare_process(last)


def test_a_process_has_nothing_of_the_others(victim, tmp_path):
    """No connection of the zygote and of who is at work, nor the map that all are warmed with."""
    alone = victim("open_files")
    assert [name.partition(":")[0] for name in alone].count("socket") == 1, alone
    assert not [name for name in alone if "map" in name], alone
    worker = threading.Thread(
        target=lambda: pytest.raises(MapFileError, victim, "sleep", tmp_path / "a", 9, timeout=9)
    )
    worker.start()
    wait_for_pid(tmp_path / "a")
    for _ in range(2):
        assert len(victim("open_files")) == len(alone)
    worker.join()


def test_a_forked_process_has_one_of_its_own(victim):
    parent = victim("where")[1]
    reading, writing = os.pipe()
    pid = os.fork()
    if not pid:
        try:
            os.write(writing, b"%d" % victim("where")[1])
            ZYGOTE.stop()
        finally:
            os._exit(0)
    os.waitpid(pid, 0)
    os.close(writing)
    with open(reading) as stream:
        its = int(stream.read())
    assert its != parent and gone(its) and victim("where")[1] == parent


SLEEPER = """
import sys, threading
sys.path[:] = %r
from mesh_msgs_hdf5 import isolation
isolation.FUNCTIONS["sleep"] = ("victims", "sleep")
def sleep(name):
    isolation.isolated("sleep", sys.argv[1] + name, 1000)
threading.Thread(target=sleep, args=("one",), daemon=True).start()
sleep("two")
"""


@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGINT, signal.SIGTERM])
def test_everything_ends_with_its_parent(tmp_path, number):
    """Also by Ctrl+C in a terminal, which signals the whole group: no word from the others."""
    process = subprocess.Popen(
        [sys.executable, "-c", SLEEPER % [place for place in sys.path if place]]
        + [str(tmp_path) + "/"],
        start_new_session=True,
        stderr=subprocess.PIPE,
    )
    try:
        for name in ("one", "two"):
            wait_for_pid(tmp_path / name)
        (zygote,) = children_of(process.pid)
        pids = wait_until(lambda: len(children_of(zygote)) == 3 and children_of(zygote), "a spare")
        os.killpg(process.pid, number)
        said = process.communicate(timeout=60)[1].decode()
    finally:
        process.kill()
        process.wait()
    assert all(gone(pid) for pid in [zygote, *pids])
    assert said.count("Traceback") == (1 if number == signal.SIGINT else 0), said
    assert "zygote_child" not in said


def wait_for_pid(path):
    return int(wait_until(lambda: path.exists() and path.read_text(), "%s" % path))


def gone(pid):
    """True once no such process runs (one that its new parent has not yet waited for counts)."""
    deadline = time.monotonic() + 60
    while time.monotonic() < deadline:
        try:
            with open("/proc/%d/stat" % pid) as stream:
                if stream.read().rpartition(")")[2].split()[0] == "Z":
                    return True
        except (FileNotFoundError, ProcessLookupError):
            return True
        time.sleep(0.02)
    return False


def children_of(parent):
    found = []
    for name in os.listdir("/proc"):
        try:
            with open("/proc/%d/stat" % int(name)) as stream:
                if int(stream.read().rpartition(")")[2].split()[1]) == parent:
                    found.append(int(name))
        except (ValueError, FileNotFoundError, ProcessLookupError):
            continue
    return found


def test_what_a_process_shares_is_bounded():
    code = (
        "import os\n"
        "from mesh_msgs_hdf5.isolation import zygote_child\n"
        "shared = os.memfd_create('arrays')\n"
        "zygote_child._prepare()\n"
        "os.posix_fallocate(shared, 0, zygote_child.MOST_SHARED)\n"
        "try:\n"
        "    os.posix_fallocate(shared, zygote_child.MOST_SHARED, 1)\n"
        "except OSError as error:\n"
        "    print(os.strerror(error.errno))\n"
    )
    done = subprocess.run([sys.executable, "-c", code], stdout=subprocess.PIPE, timeout=60)
    assert (done.returncode, done.stdout) == (0, b"File too large\n")


def test_a_wrong_call_says_only_that(capsys):
    with pytest.raises(TypeError):
        IsolatedMapFile()
    gc.collect()
    assert capsys.readouterr().err == ""


def test_a_path_that_no_file_can_have_is_named():
    for ask in (parts_of, lambda path: isolated("parts", path)):
        with pytest.raises(MapFileError) as caught:
            ask("/tmp/a\0b.h5")
        assert caught.value.code == "name"


def test_files_that_it_writes_may_be_as_large_as_ours():
    """What may be shared, 256 MB, is less."""
    with contextlib.closing(isolated_map_file._Reader(None, None)) as reader:
        limit = ("resource", "getrlimit")
        for _ in range(2):  # also after an answer
            found = reader.call("x", limit, [resource.RLIMIT_FSIZE], {})
            assert found == resource.getrlimit(resource.RLIMIT_FSIZE)
